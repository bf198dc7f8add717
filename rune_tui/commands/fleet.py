"""`rune run auto --fleet`: which robots of a fleet are there, and layouts for them."""

from __future__ import annotations

import argparse
import contextlib
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from hub.errors import CentralUnreachableError
from hub.plain_text import plain
from rune_tui.commands.auto import auto_layout
from rune_tui.link.fleet_mirrors import FleetMirror, FleetMirrors, FleetPlace
from rune_tui.startup.fleet_layout import MOST, fleet_layout_text

_FIRST_S = 8.0
"""Longest wait for the first robot, or for all that were named [s]."""
_REST_S = 1.0
"""After this time without another robot, all are there [s]."""
_LOOK_S = 0.02


def fleets_of(options: argparse.Namespace) -> contextlib.closing[FleetMirrors]:
    """The fleets that the options name; none is joined yet."""
    place = FleetPlace(
        router=options.fleet or "",
        name=options.fleet_name,
        operator=options.fleet_operator,
        keys=options.keys if (options.fleet or "").startswith("tls/") else None,
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
    """
    mirror = mirrors.join(fleet, named)
    robots = _present(mirror, named)
    sys.stderr.write(f"rune: in the fleet {plain(fleet)}: {', '.join(robots)}\n")
    with tempfile.TemporaryDirectory(prefix="rune-auto-") as folder:
        texts = {}
        if len(robots) > 1:
            texts["fleet"] = fleet_layout_text(robots, fleet)
        for robot in robots[:MOST]:
            texts[robot] = auto_layout(mirror.endpoint(robot), robot=robot, fleet=fleet)
        paths = []
        for number, (name, text) in enumerate(texts.items()):
            paths.append(Path(folder) / f"{number} {name}.xml")
            paths[-1].write_text(text, "utf-8")
        yield [str(path) for path in paths]


def _present(mirror: FleetMirror, named: Sequence[str]) -> list[str]:
    """The robots that are there, once no more come."""
    since = time.monotonic()
    end = since + _FIRST_S
    seen: tuple[str, ...] = ()
    found: tuple[str, ...] = ()
    while time.monotonic() < end and not (named and set(named) <= set(found)):
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
    raise CentralUnreachableError(text)
