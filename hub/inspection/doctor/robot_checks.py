"""The doctor on the needs of one robot file: keys, folders, devices."""

from __future__ import annotations

import contextlib
import grp
import os
import pwd
import re
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from hub.errors import KeyFileError
from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.ipc.security import key_files
from hub.ipc.security.keyring import Keyring, default_folder
from hub.paths import for_logs, for_maps, for_missions, for_recordings
from hub.robots.body_tables import ROBOTS_OWN
from hub.robots.description import RobotDescription

"""The source in a robot file for the robot's own camera."""
"""Longest path of a folder for sockets; a socket's path has about 100 bytes at most."""
_DEVICE = re.compile(r"/dev/[^\s,;\"']+")
_COMMON_FILES = ("/dev/null", "/dev/zero", "/dev/stdin", "/dev/stdout", "/dev/stderr")
_MOST_SHOWN = 8


def keys(robot: RobotDescription) -> list[Finding]:
    """Whether clients with keys can connect, and other users cannot read the keys."""
    if not robot.gateway:
        return [ok("not needed: there is no gateway")]
    make = "make one with: rune-hub keys make NAME --role operate"
    make += f" --folder {robot.keys}" if robot.keys else ""
    try:
        folder = Path(robot.keys) if robot.keys else default_folder()
        keyring = Keyring(folder)
        if not key_files.is_there(folder):
            fault = _unwritable(folder)
            if fault:
                return [problem(f"{folder} is not there and cannot be made ({fault})", make)]
            return [warning(f"{folder} is not there, so nobody has a key", make)]
        key_files.private_folder(folder)
        made = key_files.is_there(folder / "hub.toml")
        if made:  # otherwise asking for them would make them
            keyring.hub_keys()
        holders = keyring.holders()
    except KeyFileError as error:
        return [problem(str(error), "nobody can connect from other machines before")]
    if not made and (fault := _unwritable(folder)):
        return [problem(f"the hub's own keys cannot be made in {folder} ({fault})", make)]
    if not holders:
        return [warning(f"no keys are listed in {folder}, so nobody can come in", make)]
    names = ", ".join(holder.name for holder in holders[:_MOST_SHOWN])
    return [ok(f"{len(holders)} in {folder}: {names}")]


def folders(robot: RobotDescription) -> list[Finding]:
    """Whether files can be written; a hub needs that only if the robot file asks for it."""
    findings = []
    for what, (folder, wanted) in written_folders(robot).items():
        if fault := _unwritable(folder):
            text = f"{what} cannot be written to {folder} ({fault})"
            advice = f"mkdir -p {folder}, and let this user write there"
            findings.append(problem(text, advice) if wanted else warning(text, advice))
        else:
            findings.append(ok(f"{what} can be written to {folder}"))
    return findings


def written_folders(robot: RobotDescription) -> dict[str, tuple[Path, bool]]:
    """The folders that a hub writes to, and whether the robot file asks for them."""
    recordings = robot.recording
    return {
        "logs": (for_logs(robot.logs), bool(robot.logs)),
        "maps": (for_maps(robot.map_folder), bool(robot.map_folder)),
        "missions": (for_missions(robot.mission_folder), bool(robot.mission_folder)),
        "recordings": (
            for_recordings(recordings.folder),
            recordings.always or bool(recordings.folder),
        ),
    }


def existing(folder: Path) -> Path:
    """The folder, or the nearest one above it that exists."""
    folder = folder.absolute()
    return next(place for place in (folder, *folder.parents) if place.exists())


def devices(robot: RobotDescription) -> list[Finding]:
    """Whether devices and files that the robot file names are there and open to this user."""
    findings = [device_finding(Path(name)) for name in _named_devices(robot)]
    source = robot.camera.source
    if source != ROBOTS_OWN and not source.startswith("/dev/"):
        if "://" in source:
            text = f"the camera is at {source}; whether it gives pictures is not known"
            findings.append(warning(text, "look at its picture in the console"))
        elif not _is_open(Path(source), os.R_OK):
            text = f"the camera's file {source} is not there or cannot be read"
            findings.append(problem(text, "correct [camera], key 'source'"))
        else:
            findings.append(ok(f"the camera's file {source} can be read"))
    return findings or [ok("the robot file names none")]


def _unwritable(folder: Path) -> str:
    """Why nothing can be written to a folder, or where it would be made; empty if it can be."""
    try:
        with tempfile.TemporaryFile(dir=existing(folder)):
            return ""
    except OSError as fault:
        return key_files.reason_of(fault)


def _named_devices(robot: RobotDescription) -> list[str]:
    named = [*_texts(robot.camera.source), *_texts(robot.modules)]
    found = [device for text in named for device in _DEVICE.findall(text)]
    return [device for device in dict.fromkeys(found) if device not in _COMMON_FILES]


def _texts(value: object) -> Iterator[str]:
    """All texts in a TOML value."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, list):
        for item in value:
            yield from _texts(item)


def device_finding(path: Path) -> Finding:
    """Whether a device is there and may be used."""
    try:
        found = path.stat()
    except OSError as fault:
        others = sorted(str(other) for other in path.parent.glob(f"{_stem(path.name)}*"))
        seen = f"; there are {', '.join(others[:_MOST_SHOWN])}" if others else ""
        text = f"{path}: {key_files.reason_of(fault)}{seen}"
        return problem(text, "plug it in, or correct its name in the robot file")
    if _is_open(path, os.R_OK | os.W_OK):
        return ok(f"{path} is there and open to this user")
    return problem(f"{path} is not open to this user", _way_in(path, found))


def _is_open(path: Path, wanted: int) -> bool:
    """Whether this user may; the system is asked, because access lists count as well."""
    return os.access(path, wanted, effective_ids=os.access in os.supports_effective_ids)


def _stem(name: str) -> str:
    """The name without its number: glob of those of the same kind."""
    return re.sub(r"[*?\[]", "?", name.rstrip("0123456789"))


def _way_in(path: Path, found: os.stat_result) -> str:
    """The remedy that gives this user a device."""
    user = str(os.geteuid())
    with contextlib.suppress(KeyError):
        user = pwd.getpwuid(os.geteuid()).pw_name
    group = ""
    with contextlib.suppress(KeyError):
        group = grp.getgrgid(found.st_gid).gr_name
    if found.st_gid and group and found.st_mode & (stat.S_IRGRP | stat.S_IWGRP) == 0o060:
        return f"usermod -aG {group} {user}, then log in again"
    return f"write a udev rule that gives {path.name} to a group of {user}, such as plugdev"
