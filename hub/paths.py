"""Where files of Rune belong on this machine: sockets, logs, maps, missions, recordings.

The user's own folders follow the XDG base directory specification; those of a service, systemd.
"""

from __future__ import annotations

import os
import re
import tempfile
import zlib
from pathlib import Path

LONGEST_FOR_SOCKETS = 60
"""Longest path of a socket file, about 100 bytes."""


def for_sockets() -> Path:
    """The parent of a daemon's own folder for sockets."""
    for candidate in (os.environ.get("XDG_RUNTIME_DIR", ""), tempfile.gettempdir()):
        if candidate and len(candidate) <= LONGEST_FOR_SOCKETS and Path(candidate).is_dir():
            return Path(candidate)
    return Path("/tmp")


def for_logs(wanted: str = "") -> Path:
    """The folder for folders of log files; `wanted` if that names one."""
    given = wanted or os.environ.get("LOGS_DIRECTORY", "").partition(":")[0]
    return Path(given) if given else _own("STATE", "state")


def for_maps(wanted: str = "") -> Path:
    """The folder for saved maps; `wanted` if that names one."""
    return Path(wanted) if wanted else _own("DATA", "share") / "maps"


def for_missions(wanted: str = "") -> Path:
    """The folder for the folders of robots with their missions; `wanted` if that names one."""
    return Path(wanted) if wanted else _state() / "missions"


def for_recordings(wanted: str = "") -> Path:
    """The folder for the folders of robots with their recordings; `wanted` if that names one."""
    return Path(wanted) if wanted else _state() / "recordings"


def for_vehicle_parameters() -> Path:
    """The folder for the parameters that vehicles had before they were changed."""
    return _state() / "vehicle-parameters"


def _state() -> Path:
    given = os.environ.get("STATE_DIRECTORY", "").partition(":")[0]
    return Path(given) if given else _own("STATE", "state")


def for_pose(robot: str) -> Path:
    """The file with the frame of navigation: the transform of dead reckoning to the map.

    It is needed only until the next boot, so it is in the folder of sockets.
    """
    return for_sockets() / f"rune-pose-{os.getuid()}-{as_file_name(robot)}"


def for_reckoning(robot: str) -> Path:
    """The file with the last place of a robot whose dead reckoning outlives its driver."""
    return for_sockets() / f"rune-reckoning-{os.getuid()}-{as_file_name(robot)}"


def as_file_name(name: str) -> str:
    """The name of something as the name of a file; it differs for each, and never leads out."""
    safe = re.sub(r"[^A-Za-z0-9_-]", "-", name)[:64]
    return safe if safe == name and name else f"{safe}-{zlib.crc32(name.encode()):08x}"


def _own(kind: str, name: str) -> Path:
    named = Path(os.environ.get(f"XDG_{kind}_HOME", ""))
    if not named.is_absolute():  # the specification ignores relative paths
        home = os.path.expanduser("~")  # noqa: PTH111 - Path raises where there is none
        named = Path(home if home != "~" else tempfile.gettempdir()) / ".local" / name
    return named / "rune"
