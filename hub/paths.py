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


def for_hubs() -> list[Path]:
    """The folders where hubs of this user have their sockets; a new hub takes the first.

    Each is one user's alone, mode 0700. A client looks in all of them: a service, a login and a
    scheduled job have other environments. `RUNE_RUNTIME_DIR` names the only one.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    named = [Path(os.environ[each]) for each in _RUNTIME if os.environ.get(each)]
    if os.environ.get(_RUNTIME[0]):
        return named[:1]
    login = Path(f"/run/user/{user}")
    folders = [each / "rune" for each in (*named, login) if each.is_dir()]
    folders += [Path(tempfile.gettempdir()) / f"rune-{user}", Path(f"/tmp/rune-{user}")]
    # Of services; root also finds the hubs of those who are logged in.
    folders += sorted(Path("/run").glob("*/rune"))
    folders += sorted(Path("/run/user").glob("*/rune")) if user == 0 else []
    return [each for each in dict.fromkeys(folders) if len(str(each)) <= _LONGEST_FOR_HUBS]


_LONGEST_FOR_HUBS = 50
"""Longest path of such a folder, which the name of a hub and of a socket follow."""
_RUNTIME = ("RUNE_RUNTIME_DIR", "XDG_RUNTIME_DIR")


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
