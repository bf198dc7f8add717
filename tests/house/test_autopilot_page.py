"""The tables of the page on autopilots are those of the code.

After a wanted change, write them anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.robots.mavlink.profiles.table import PROFILES
from rune_tui.visualizers.parts.autopilot_words import PHASES
from tests.support.docstrings import meanings
from tests.support.page_tables import check_page, put_table

_PAGE = Path(__file__).parents[2] / "docs" / "autopilots.md"


def test_the_tables_of_the_page_are_those_of_the_code() -> None:
    lines = _PAGE.read_text().splitlines()
    means = meanings(AutopilotPhase)
    phases = [
        f"| {phase.name} | {PHASES[phase] or 'DISARMED'} | {means[phase.name]} |"
        for phase in AutopilotPhase
    ]
    put_table(lines, "The pane `autopilot` begins", phases)
    profiles = [profile for _, profile in PROFILES]
    put_table(lines, "### Parameters that make it safe", [*_parameters(profiles)])
    put_table(lines, "## What is verified on what", [_kind(each) for each in profiles])
    check_page(_PAGE, lines)


_SAFE = {
    "rover": {"FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": 2, "FS_THR_ENABLE": 1, "FS_TIMEOUT": 0.1},
    "Sub": {"FS_PILOT_INPUT": 1, "FS_PILOT_TIMEOUT": 0.5, "FS_GCS_ENABLE": 4, "FS_GCS_TIMEOUT": 2},
    "blimp": {"RC_OVERRIDE_TIME": 0.5, "FS_THR_ENABLE": 1},
}
"""The safe parameters, with which the times of the page were measured."""


@pytest.mark.parametrize(("event", "place"), [("zero speed", 0), ("the link is cut both ways", 1)])
def test_the_times_to_stop_of_the_page_are_those_that_are_computed(event: str, place: int) -> None:
    """The page states the longest time that was measured."""
    lines = _PAGE.read_text().splitlines()
    heads = next(line for line in lines if line.startswith("| event | rover, from"))
    row = next(line for line in lines if line.startswith(f"| {event} |"))
    pairs = zip(heads.split("|")[2:-1], row.split("|")[2:-1], strict=True)
    for head, cell in pairs:
        name, _, speed = head.strip().partition(", from ")
        profile = next(each for _, each in PROFILES if each.name == name.lower())
        stops = profile.stops(_SAFE[name], float(speed.removesuffix(" m/s")), receiver=False)
        if "drifts" in cell:
            assert stops[place] > 10.0
        else:
            longest = float(cell.rpartition(" to ")[2].removesuffix("s ").strip())
            assert stops[place] == pytest.approx(longest, rel=0.1)


def _parameters(profiles: list[VehicleProfile]) -> Iterator[str]:
    rows: dict[tuple[str, str, str], list[str]] = {}
    for profile in profiles:
        for each in profile.wanted:
            safe = " or ".join(f"{value:g}" for value in each.allowed)
            kind = profile.name if profile.autopilot == "ArduPilot" else f"PX4 {profile.name}"
            rows.setdefault((each.name, safe, each.why), []).append(kind)
    for (name, safe, why), kinds in rows.items():
        yield f"| {', '.join(kinds)} | `{name}` | {safe} | {why} |"


def _kind(profile: VehicleProfile) -> str:
    follows = ", else ".join(profile.mode_name(number) for number in profile.drives)
    stays = profile.mode_name(profile.holds) if profile.holds is not None else "none"
    rules = "recordings" if profile.verified else "documents"
    return f"| {profile.name} | {profile.autopilot} | {follows} | {stays} | {rules} |"
