"""The word or number that decides is the last to be cut, in every pane at every size."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any, Final

import pytest

from hub.gcm.autonomy import Phase
from hub.gcm.body import ROBOT_DESCRIPTION, HoldKind
from hub.gcm.mapping import INTEREST_POINTS
from hub.gcm.mission import MISSION_STATE, MissionState
from hub.gcm.navigation import MotionState
from hub.gcm.supervision import (
    CAPABILITY_REPORTS,
    MODULE_REPORTS,
    CapabilityPhase,
    ModulePhase,
)
from hub.gcm.vehicle import VEHICLE_STATE, Arming, HoldPhase, HoldState, VehicleState
from hub.ipc.definition import MessageDefinition
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.view import View
from rune_tui.visualizers.words.status_words import signed_forms
from tests.console.situations import MINE, NOW, ROOT, received, robot, shipped
from tests.console.states import described
from tests.console.visualizers import known
from tests.support.cases import for_each

LAYOUTS: Final = sorted(path.stem for path in (ROOT / "layouts").glob("*.xml"))
SIZES: Final = (
    *((16, 4), (20, 5), (24, 9), (40, 12), (57, 17), (80, 24)),
    *((100, 30), (120, 40), (160, 48), (200, 60)),
)
NAMES: Final = ("r1", "Спасатель-двенадцать", "救助ロボット三号", "a" * 40, "Ünïcödé e\u0301tude")
MARKS: Final = 12


def _all_of(role: str, name: str, age: float, *, ended: bool) -> RobotState:
    """A robot that reports all that panes show, `age` seconds old [s]."""
    autonomy = known.autonomy(
        x=3.2,
        y=4.6,
        frontier_m=6.4,
        why="no way leads around the table, which stands in the middle of the room",
        phase=Phase.BLOCKED if ended else Phase.ACTIVE,
        explored=0.62,
        distance_m=3.1,
        seconds=131.0,
        ended_s=449.0 if ended else math.nan,
        sender=3,
    )
    mission = MissionState(
        name=f"search of {name}",
        running=1,
        begun=1.0,
        running_s=754.0,
        marks=MARKS,
        map_age_s=10.0,
    )
    why = "it was ended by signal 9 for the third time within a minute"
    points = [
        known.point(each, x=-16.25, y=each + 0.5, by="Александра", note="a note")
        for each in range(1, MARKS + 1)
    ]
    reports: dict[MessageDefinition[Any], Any] = {
        MISSION_STATE: mission,
        MODULE_REPORTS: known.modules(known.module("vision", ModulePhase.FAILED, why=why)),
        CAPABILITY_REPORTS: known.capabilities(
            known.capability(
                "VIS_VID", CapabilityPhase.UNAVAILABLE, module="vision", wanted="a console"
            )
        ),
        INTEREST_POINTS: known.points(*points),
        VEHICLE_STATE: VehicleState(
            activity="",
            arming=Arming.ARMED,
            holds=(
                HoldState(kind=HoldKind.HEADING, phase=HoldPhase.HOLDING, target=0.5, error=0.01),
            ),
        ),
    }
    seen = robot(
        role,
        age=age,
        control=dataclasses.replace(MINE, operator=name[:20]),
        autonomy=autonomy,
        phase=LinkPhase.LOST if age > 20.0 else LinkPhase.CONNECTED,
        since=NOW - 30.0,
        battery_fraction=0.08,
        motion=MotionState.MOVING,
        linear=0.37,
    )
    messages = {each.name: received(value, age) for each, value in reports.items()}
    messages[ROBOT_DESCRIPTION.name] = described(name)
    return seen.with_(messages={**seen.messages, **messages})


DECIDING: Final[dict[str, tuple[str, ...]]] = {
    "visualizeMission": (f"{MARKS} marks",),
    "visualizeMarks": ("-16.25, 12.50",),
    "visualizeControl": ("you have control",),
    "visualizeAutonomy": ("EXPLORING 62 %",),
    "visualizeModules": ("vision",),
    "visualizeCapabilities": ("VIS_VID",),
    "visualizeEventLog": ("victim 12 marked", "victim 12 is marked"),
    "visualizeBattery": ("8%",),
    "visualizeHeading": ("090", "000"),
    "visualizeLink": ("linked",),
    "visualizeStatus": ("MOVING",),
    "visualizeTeam": ("rover !!", "!! BATTERY"),
    "visualizeAttention": ("BATTERY CRITICAL",),
    "visualizeAlarms": ("BATTERY CRITICAL 8%", "nothing else"),
    "visualizeVehicle": ("heading",),
    "visualizeSpeed": ("+0.37",),
    "visualizePlot": ("0.37",),
}
"""Per visualizer function: a pane that has room shows at least one of these texts."""
ENDED: Final = {"visualizeAutonomy": ("EXPLORING 62 % BLOCKED",)}
"""Texts that replace these after the robot's task has ended."""
OLD: Final = {
    "visualizeLink": ("LINK LOST 30 s", "30 s old"),
    "visualizeStatus": ("was MOVING", "LINK LOST"),
    "visualizeTeam": ("rover !!", "!! LINK LOST"),
    "visualizeAttention": ("LINK LOST 30 s",),
    "visualizeAlarms": ("LINK LOST 30 s", "not known"),
}
"""Texts that replace these after the link to the robot is lost."""
BESIDE: Final = {
    "visualizeEventLog": len("14:06 "),
    "visualizeAttention": len(": … +2"),
    "visualizeStatus": len("…"),
}
"""Room that a pane needs besides its text [cells]."""


def _panes(
    layout: LayoutSpec, size: tuple[int, int], name: str, age: float, *, ended: bool
) -> Iterator[tuple[str, str, tuple[int, int]]]:
    """Function, words and size [cells] of each pane."""
    view = View(layout, spent=lambda: 0.0)
    view.resize(*size)
    notice = Notice(text="victim 12 is marked", when=NOW - 30.0, clock="14:06:40")
    state = dataclasses.replace(
        ConsoleState.at_start(layout, NOW, "ada"),
        began=0.0,
        notices=(notice,),
        robots={each.name: _all_of(each.name, name, age, ended=ended) for each in layout.robots},
    )
    assert view.render(state) is not None
    for pane in view.panes:
        if pane.visible(state) and pane.layer is not None:
            glyphs = pane.layer.canvas.glyphs
            rows = ("".join(chr(each or 32) for each in row).strip() for row in glyphs.tolist())
            yield pane.function, " ".join(rows), (glyphs.shape[1], glyphs.shape[0])


@pytest.mark.parametrize("name", LAYOUTS)
def test_what_decides_is_whole_in_every_pane_that_has_room_for_it(name: str) -> None:
    layout, missing = shipped(name), []
    for number, size in enumerate(SIZES):
        for age, ended in ((0.1, False), (0.1, True), (30.0, False)):
            called = NAMES[(number + ended) % len(NAMES)]
            for function, said, room in _panes(layout, size, called, age, ended=ended):
                situation = OLD if age > 1.0 else ENDED if ended else {}
                forms = situation.get(function) or DECIDING.get(function, ())
                needed = min(map(len, forms), default=0) + BESIDE.get(function, 0)
                if function == "visualizeStatus" and "Space STOP" in said:
                    needed += len("Space STOP  ")  # how to stop comes first
                if needed <= room[0] and forms and not any(form in said for form in forms):
                    missing.append((size, function, room, age, said))
    assert missing == []


def test_a_narrow_pane_shows_as_much_of_it_as_fits() -> None:
    """Where there is less room than the test above wants."""
    said = {
        (function, room, age): words
        for name in ("land-sea-air", "robobot-2003-expanded")
        for size in SIZES[:2]
        for age in (0.1, 30.0)
        for function, words, room in _panes(shipped(name), size, NAMES[0], age, ended=False)
    }
    assert said["visualizeAttention", (16, 1), 0.1] == "BATTERY CRIT… +2"
    assert said["visualizeAttention", (16, 1), 30.0] == "LINK LOST 30… +2"
    assert said["visualizeSpeed", (4, 1), 0.1] == "+.37"
    assert said["visualizeSpeed", (3, 1), 0.1] == "+.4"


@for_each(
    ("value", "forms"),
    [
        (0.37, ["+0.37", "+.37", "+0.4", "+.4", "+…"]),
        (-0.37, ["-0.37", "-.37", "-0.4", "-.4", "-…"]),
        (0.04, ["+0.04", "+.04", "+…"]),
        (1.26, ["+1.26", "+1.3", "+1", "+…"]),
        (0.0, ["0.00", "0.0", "0"]),
        (math.nan, ["?"]),
    ],
)
def test_no_short_form_of_a_speed_says_that_a_moving_robot_stands(
    value: float, forms: list[str]
) -> None:
    assert [*dict.fromkeys(signed_forms(value, 2))] == forms


@for_each("name", LAYOUTS)
def test_how_to_stop_is_in_sight_at_every_size(name: str) -> None:
    layout = shipped(name)
    for size in SIZES:
        for age in (0.1, 30.0):
            view = View(layout, spent=lambda: 0.0)
            view.resize(*size)
            robots = {
                each.name: _all_of(each.name, "r", age, ended=False) for each in layout.robots
            }
            state = ConsoleState.at_start(layout, NOW, "ada")
            cells = view.render(dataclasses.replace(state, robots=robots))
            assert cells is not None
            shown = "".join(chr(point or 32) for point in cells.glyphs.flat).casefold()
            assert "space stop" in shown or "stop space" in shown, (size, age)
