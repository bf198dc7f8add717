"""The tables of the page on autopilots are those of the code.

After a wanted change, write them anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

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
