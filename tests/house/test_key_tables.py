"""The tables of keys on the pages are those of the code.

After a wanted change, write them anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house/test_key_tables.py
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from hub import toml_reader
from hub.recording.live.settings import PictureSettings, RecordingTable
from hub.robomon.module_table import ModuleSpec
from hub.robots.body_tables import BumperTable, CameraTable, FrameTable, RangeTable
from hub.robots.description import RobotDescription
from hub.robots.ros_table import RosTable
from hub.robots.vehicle_tables import HoldTable, JointTable, LightTable
from hub.shaper.profile import (
    BurstsSpec,
    DirectionSpec,
    EpisodesSpec,
    LinkProfile,
    load_profile,
    shipped_profiles,
)
from hub.sim import arena_specs, spec_values
from hub.sim.ground import specs as ground_specs
from hub.toml_reader import REQUIRED, Key, Within, keys_of, tables_of
from tests.support.page_tables import check_page, put_table

_DOCS = Path(__file__).parents[2] / "docs"
_COLOURS = {colour: f"`{name}`" for name, colour in spec_values.COLOURS.items()}
_ARENA = {
    "At the top of the file": arena_specs.ArenaSpec,
    "`[start]`": arena_specs.StartSpec,
    "`[hall]`": arena_specs.HallSpec,
    "`[[wall]]`": arena_specs.WallSpec,
    "Each of `doorways`": arena_specs.DoorwaySpec,
    "`[[box]]`": arena_specs.BoxSpec,
    "`[[cylinder]]`": arena_specs.CylinderSpec,
    "`[[victim]]`": arena_specs.VictimSpec,
    "`[[landmark]]`": arena_specs.LandmarkSpec,
    "`[[ring]]`": arena_specs.RingSpec,
    "`[water]`": arena_specs.WaterSpec,
    "`[air]`": arena_specs.AirSpec,
    "`[[berth]]`": arena_specs.BerthSpec,
    "`[scoring]`": arena_specs.ScoringSpec,
    "`[terrain]`": ground_specs.TerrainSpec,
    **{f"`[[{name}]]`": kind for name, (kind, _) in ground_specs.GROUND_TABLES.items()},
}
_BODY = {
    "`[[frame]]`": FrameTable,
    "`[[range]]`": RangeTable,
    "`[[bumper]]`": BumperTable,
    "`[camera]`": CameraTable,
    "`[[hold]]`": HoldTable,
    "`[[light]]`": LightTable,
    "`[[joint]]`": JointTable,
}
_LINK = {
    "At the top of the file": LinkProfile,
    "For both directions": DirectionSpec,
    "In `[blackouts]`": EpisodesSpec,
    "In `[bursts]`": BurstsSpec,
}


def _pages() -> Iterator[tuple[str, str, Mapping[str, Key]]]:
    """Page, how the line before the table begins, and the keys."""
    for heading, kind in _ARENA.items():
        yield "writing-an-arena.md", heading, keys_of(kind)
    for table, keys in tables_of(RobotDescription).items():
        heading = f"`[{table}]`" if table else "At the top of the file"
        yield "writing-a-robot.md", heading, keys
    for heading, kind in _BODY.items():
        yield "writing-a-robot.md", heading, keys_of(kind)
    yield "writing-a-robot.md", "`[ros]`", keys_of(RosTable)
    yield "writing-a-robot.md", "`[recording]`", keys_of(RecordingTable)
    yield "writing-a-robot.md", "Its `pictures`", keys_of(PictureSettings)
    yield "writing-a-robot.md", "`[modules.NAME]`", keys_of(ModuleSpec)
    for heading, kind in _LINK.items():
        yield "links.md", heading, keys_of(kind)


def _row(name: str, key: Key) -> str:
    allowed = key.read.allowed if isinstance(key.read, Within) else ""
    default = key.default if isinstance(key.default, tuple) else ()
    shown = _COLOURS.get(default) or toml_reader.shown(key)
    if shown in ("", "()") and key.default is not REQUIRED:
        shown = "none"
    elif isinstance(key.default, str) and not key.without:
        shown = f"`{shown}`"
    return "| " + " | ".join((f"`{name}`", key.meaning, allowed, shown)) + " |"


@pytest.mark.parametrize("page", ["writing-an-arena.md", "writing-a-robot.md", "links.md"])
def test_tables_of_keys_are_those_of_the_code(page: str) -> None:
    path = _DOCS / page
    lines = path.read_text().splitlines()
    for where, heading, keys in _pages():
        if where != page:
            continue
        put_table(lines, heading, [_row(name, key) for name, key in keys.items()])
    check_page(path, lines)


def test_table_of_link_profiles_is_that_of_their_files() -> None:
    path = _DOCS / "links.md"
    lines = path.read_text().splitlines()
    put_table(lines, "The profiles:", [_profile_row(load_profile(n)) for n in shipped_profiles()])
    check_page(path, lines)


def _profile_row(profile: LinkProfile) -> str:
    way = profile.down
    jitter = f" ({profile.jitter * 1e3:.0f})" if profile.jitter else ""
    loss = f"{way.loss * 100:g} % ({way.burst:g})" if way.loss else "none"
    cells = (
        f"`{profile.name}`",
        profile.purpose,
        f"{profile.round_trip * 1e3:g}{jitter}",
        loss,
        f"{way.rate / 1e3:,g}",
    )
    return "| " + " | ".join(cells) + " |"
