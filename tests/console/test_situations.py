"""What `search` shows in nine situations, as text files that can be read and compared.

After a wanted change, write them anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/console
"""

from __future__ import annotations

import dataclasses
import functools
import os

import pytest

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.picture import plain_text
from rune_tui.model.theme import DARK
from tests.console.situations import ROOT, SITUATIONS, scene, shipped
from tests.support.cases import for_each

SNAPSHOTS = ROOT / "tests" / "golden" / "situations"
SEARCH = shipped("search")
ALARMS = {
    "near-wall": "CLOSE 0.00 m ahead",
    "stale-picture": "PICTURE 4.2 s OLD",
    "lost-link": "LINK LOST 30 s",
    "asked-for-control": "bob ASKS FOR CONTROL, 8 s: P hands it over, B keeps it",
    "goal-blocked": "no way around the table",
    "mark-refused": "refused: the place is above the horizon",
    "low-battery": "BATTERY CRITICAL 8%",
}


@functools.cache
def shown(name: str, size: tuple[int, int]) -> Cells:
    """What `search` shows in a situation."""
    return scene(SEARCH, SITUATIONS[name], size)


def words(cells) -> str:
    return "\n".join("".join(chr(p or 32) for p in row) for row in cells.glyphs.tolist())


@for_each("size", [(120, 40), (80, 24)])
@for_each("name", SITUATIONS)
def test_situation_looks_as_it_did(name: str, size: tuple[int, int]) -> None:
    text = plain_text(shown(name, size))
    path = SNAPSHOTS / f"{name}-{size[0]}x{size[1]}.txt"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    assert text == path.read_text()


@for_each("size", [(40, 12), (80, 24), (120, 40), (160, 48), (200, 60)])
@for_each(("name", "alarm"), ALARMS.items())
def test_what_must_be_seen_first_is_the_banner_and_stands_there_only(
    name: str, alarm: str, size: tuple[int, int]
) -> None:
    cells = shown(name, size)
    plate = (cells.pixels[::2, :, :3] == DARK.alarm[:3]).all(axis=2)
    rows = [row for row in range(size[1]) if plate[row, : size[0] // 2].all()]
    assert len(rows) == (3 if size[1] >= 30 else 1)
    assert rows[0] <= 3
    banner = words(cells).splitlines()[rows[len(rows) // 2]]
    if len(alarm) <= plate[rows[0]].sum() - 2:
        assert alarm in banner
    # The list of events is a record of what happened; all else says it once.
    recorded = "events" in words(cells) and name in {"goal-blocked", "mark-refused"}
    assert recorded or words(cells).count(alarm) <= 1


@pytest.mark.parametrize("name", ["driving", "exploring"])
def test_where_nothing_is_wrong_nothing_is_red(name: str) -> None:
    cells = shown(name, (120, 40))
    assert "!!" not in words(cells)
    plate = (cells.pixels[..., :3] == DARK.alarm[:3]).all(axis=2)
    assert not plate[:4].any()
    assert words(cells).count("EXPLORING 62 % by itself · a key that drives ends it") == (
        name == "exploring"
    )
    assert words(cells).count("EXPLORING") == (name == "exploring")


@pytest.mark.parametrize("size", [(120, 40), (160, 48), (200, 60)])
def test_a_pane_says_how_far_the_robot_is_by_itself_and_how_it_ended(size: tuple[int, int]) -> None:
    assert "3.1 m to go" in words(shown("exploring", size))
    assert "took 41 s, ended 2 s ago" in words(shown("goal-blocked", size))


@for_each("size", [(40, 12), (80, 24), (120, 40), (200, 60)])
@for_each("name", SITUATIONS)
def test_the_key_that_stops_is_always_in_sight(name: str, size: tuple[int, int]) -> None:
    assert "Space STOP" in words(shown(name, size))


@pytest.mark.parametrize("over", [{"full": "camera"}, {"help": True}, {"log": True}])
def test_the_key_that_stops_is_in_sight_where_no_line_of_keys_is(over) -> None:
    situation = dataclasses.replace(SITUATIONS["near-wall"], state=over)
    status = words(scene(SEARCH, situation, (80, 24))).splitlines()[-1]
    assert status.strip().startswith("Space STOP")
