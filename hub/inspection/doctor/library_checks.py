"""The doctor on Python and libraries: whether they are those that this robot needs."""

from __future__ import annotations

import importlib.metadata
import sys

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from hub.inspection.doctor.finding import Finding, ok, problem, warning
from hub.robots.body_tables import ROBOTS_OWN
from hub.robots.description import RobotDescription

_DISTRIBUTION = "robot-user-nexus"
_CAMERA_EXTRA = "camera"


def versions() -> list[Finding]:
    """Whether Python and the libraries are those that the hub was made for."""
    python = ".".join(map(str, sys.version_info[:3]))
    wanted = importlib.metadata.metadata(_DISTRIBUTION)["Requires-Python"]
    found = [("Python", python, wanted)] + [
        (need.name, _installed(need.name), str(need.specifier)) for need in _needs("")
    ]
    return [judged_version(*one) for one in found]


def judged_version(name: str, version: str, ranges: str) -> Finding:
    """The findings about a library; an empty version: it is not installed."""
    if not version:
        return problem(f"{name} is not installed", f'pip install "{name}{ranges}"')
    if not _fits(version, ranges):
        advice = f'pip install "{name}{ranges}"' if name != "Python" else "install another Python"
        return problem(f"{name} {version} is not {ranges}", advice)
    return ok(f"{name} {version}")


def extras(robot: RobotDescription) -> list[Finding]:
    """Whether the libraries are there that only some robots need."""
    needed = robot.camera.source != ROBOTS_OWN
    lacking = missing(_CAMERA_EXTRA)
    if not lacking:
        return [ok("all that this robot needs is installed")]
    text = f"extra {_CAMERA_EXTRA!r} lacks {', '.join(lacking)}"
    install = f'pip install "{_DISTRIBUTION}[{_CAMERA_EXTRA}]"'
    if needed:
        return [problem(f"{text}, which camera {robot.camera.source} needs", install)]
    return [warning(f"{text}: pictures cannot be coded as JPEG", install)]


def missing(extra: str) -> list[str]:
    """Libraries of an extra that are missing or have a wrong version."""
    lacking = []
    for wanted in _needs(extra):
        version = _installed(wanted.name)
        if not version:
            lacking.append(wanted.name)
        elif not _fits(version, str(wanted.specifier)):
            lacking.append(f"{wanted.name} {wanted.specifier} (there is {version})")
    return lacking


def _needs(extra: str) -> list[Requirement]:
    """The requirements of an extra on this system; of the empty extra: of Rune itself."""
    lines = map(Requirement, importlib.metadata.requires(_DISTRIBUTION) or [])
    return [
        line
        for line in lines
        if (not extra if line.marker is None else line.marker.evaluate({"extra": extra}))
    ]


def _fits(version: str, ranges: str) -> bool:
    return SpecifierSet(ranges).contains(version, prereleases=True)


def _installed(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""
