"""`rune run auto --fleet`: which robots of a fleet are there, and layouts for them."""

from __future__ import annotations

import argparse
import contextlib
import logging
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Protocol

from hub.errors import CentralUnreachableError, EndpointError, HubError
from hub.plain_text import plain
from hub.zenoh.settings import UNLISTED, CertificateFiles, parse_place
from rune_tui.commands.auto import auto_layout
from rune_tui.link.fleet_mirrors import FleetMirror, FleetMirrors, FleetPlace
from rune_tui.startup.fleet_layout import MOST, fleet_layout_text

_logger = logging.getLogger(__name__)

_FIRST_S = 8.0
"""Longest wait for the first robot, or for all that were named [s]."""
_REST_S = 1.0
"""After this time without another robot, all are there [s]."""
_LOOK_S = 0.02


def fleets_of(options: argparse.Namespace) -> contextlib.closing[FleetMirrors]:
    """The fleets that the options name; none is joined yet.

    Raises:
        EndpointError: What should name a router names none, or its certificates are not given.
    """
    secure = bool(options.fleet) and parse_place(options.fleet).scheme == "tls"
    if secure and options.keys is None:
        text = f"{options.fleet} needs your certificate: give the folder with its files by --keys"
        raise EndpointError(text)
    holder = CertificateFiles.only_operator(options.keys) if secure else ""
    place = FleetPlace(
        router=options.fleet or "",
        name=options.fleet_name,
        operator=options.fleet_operator or holder,
        keys=options.keys if secure else None,
    )
    return contextlib.closing(FleetMirrors(place))


@contextlib.contextmanager
def with_fleet_files(
    mirrors: FleetMirrors, fleet: str, named: Sequence[str]
) -> Iterator[list[str]]:
    """Layout files for the robots of a fleet: all together where there are several, then each.

    The files are there until the end of the context.

    Args:
        mirrors: Join fleets.
        fleet: Which.
        named: The wanted robots; empty: all that are there.

    Raises:
        CentralUnreachableError: None of them is there.
        EndpointError: The fleet cannot be joined so.
    """
    mirror = mirrors.join(fleet, named)
    robots = _present(mirror, named)
    sys.stderr.write(f"rune: in the fleet {plain(fleet)}: {', '.join(robots)}\n")
    with tempfile.TemporaryDirectory(
        prefix="rune-auto-",
        ignore_cleanup_errors=True,  # a late robot may still be described
    ) as folder:
        files = FleetFiles(mirror, fleet, Path(folder), robots)
        mirrors.arrivals = files
        yield files.names()


class ShownFleet(Protocol):
    """What layout files need of a mirror."""

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the robots that are there now."""

    def endpoint(self, robot: str) -> str:
        """Where the hub of a robot is while it is there."""


class FleetFiles:
    """Layout files for robots of a fleet, and for those that join later.

    A robot keeps its number for good, so that no key leads to another robot than before.
    """

    def __init__(self, mirror: ShownFleet, fleet: str, folder: Path, robots: Sequence[str]) -> None:
        """Write those for the robots that are there.

        Raises:
            HubError: A robot does not describe itself.
        """
        self._mirror, self._fleet, self._folder = mirror, fleet, folder
        self._robots = [*robots]
        self._write_fleet()
        for robot in robots[:MOST]:
            self._write_own(robot)

    def look(self) -> str:
        """The robots that joined since the last call, in one sentence; empty: none."""
        came = [robot for robot in self._mirror.present if robot not in self._robots]
        if not came:
            return ""
        shown = came[: max(0, MOST - len(self._robots))]
        self._robots += came
        self._write_fleet()
        for robot in shown:  # a robot that has just started may need seconds to describe itself
            threading.Thread(target=self._try_own, args=(robot,), daemon=True).start()
        names = plain(" and ".join(came))
        if shown == came:
            return f"{names} joined the fleet: F4 shows all {len(self._robots)} robots"
        return f"{names} joined the fleet; at most {MOST} are shown, and --only chooses which"

    def names(self) -> list[str]:
        """The paths of the files: all robots where there are several, then each."""
        several = [0] if len(self._robots) > 1 else []
        numbers = [*several, *range(1, len(self._robots) + 1)]
        return [str(path) for path in map(self._path, numbers) if path.exists()]

    def _path(self, number: int) -> Path:
        """The file of a robot by its number; 0: of all."""
        name = self._robots[number - 1] if number else "fleet"
        return self._folder / f"{number} {name}.xml"

    def _write_fleet(self) -> None:
        if len(self._robots) > 1:
            self._path(0).write_text(fleet_layout_text(self._robots, self._fleet), "utf-8")

    def _write_own(self, robot: str) -> None:
        text = auto_layout(self._mirror.endpoint(robot), robot=robot, fleet=self._fleet)
        path = self._path(self._robots.index(robot) + 1)
        path.with_suffix(".part").write_text(text, "utf-8")
        path.with_suffix(".part").rename(path)  # whole, or not there

    def _try_own(self, robot: str) -> None:
        try:
            self._write_own(robot)
        except (HubError, OSError) as error:
            _logger.warning("%s has no layout of its own: %s", robot, error)


def _present(mirror: FleetMirror, named: Sequence[str]) -> list[str]:
    """The robots that are there, once no more come."""
    since = time.monotonic()
    end = since + _FIRST_S
    seen: tuple[str, ...] = ()
    found: tuple[str, ...] = ()
    while time.monotonic() < end and not (named and set(named) <= set(found)):
        if mirror.refused:
            raise EndpointError(mirror.trouble)
        found = mirror.present
        if found != seen:
            seen, since = found, time.monotonic()
        if not named and found and time.monotonic() - since > _REST_S:
            break
        time.sleep(_LOOK_S)
    if found:
        return sorted(found)
    if mirror.trouble:
        raise CentralUnreachableError(mirror.trouble)
    who = " and ".join(named) if named else "no robot"
    text = f"{plain(who)} {'is not' if named else 'is'} in the fleet {mirror.place.name} now"
    if mirror.place.keys is not None:  # a router says nothing to those that it refuses
        text += f", or {UNLISTED}"
    raise CentralUnreachableError(text)
