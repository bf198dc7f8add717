"""What panes leave to other panes: their room, or words; and the banner hides none of them."""

from __future__ import annotations

import dataclasses
from itertools import combinations
from typing import Any, Final

from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.autonomy import Phase
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.flight import ALTITUDE, Altitude
from hub.gcm.imu import IMU
from hub.ipc.definition import MessageDefinition
from hub.robots.messages_of import described
from rune_tui.layout.placing import given_away
from rune_tui.layout.spec import PlaceSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Received, RobotState
from rune_tui.view import View
from tests.console.situations import NOW, SITUATIONS, received, robot, scene, shipped
from tests.console.states import layout_of, rendered
from tests.console.view_scenes import view, viewport, words
from tests.console.visualizers import known
from tests.support.cases import for_each
from tests.support.magellan import magellan_body

TEAM: Final = shipped("land-sea-air")
SIZES: Final = ((80, 24), (100, 30), (120, 40), (160, 48), (200, 60))


def meet(one: PlaceSpec, other: PlaceSpec) -> bool:
    across = one.xpos < other.xpos + other.xsize and other.xpos < one.xpos + one.xsize
    down = one.ypos < other.ypos + other.ysize and other.ypos < one.ypos + one.ysize
    return across and down


NAMES: Final = sorted({each.viewport for each in TEAM.view.arrangements[0].places})


@given(st.sampled_from(TEAM.view.arrangements), st.sets(st.sampled_from(NAMES), max_size=4))
def test_room_that_is_given_away_makes_no_two_places_meet(arrangement: Any, idle: set[str]) -> None:
    before = {each.viewport: each for each in arrangement.places}
    after = given_away(arrangement.places, idle)
    assert {each.viewport for each in after} == before.keys() - idle
    for one, other in combinations(after, 2):
        assert meet(one, other) == meet(before[one.viewport], before[other.viewport])
    for place in after:
        old = before[place.viewport]
        assert place.xsize * place.ysize >= old.xsize * old.ysize


def body(measures: tuple[MessageDefinition[Any], ...], name: str) -> Received[Any]:
    made = described(dataclasses.replace(magellan_body(), name=name), measures)
    return received(made, 0.0)


def shown(known: dict[str, RobotState], size: tuple[int, int]) -> tuple[View, str]:
    view = View(TEAM, spent=lambda: 0.0)
    view.resize(*size)
    cells = view.render(dataclasses.replace(ConsoleState.at_start(TEAM, NOW), robots=known))
    assert cells is not None
    return view, words(cells)


@for_each("size", SIZES)
def test_a_rover_has_no_panes_of_what_flies_and_its_map_is_larger(size: tuple[int, int]) -> None:
    def team(*measures: MessageDefinition[Any]) -> dict[str, RobotState]:
        level = Altitude(stamp=0.0, depth=2.5)
        measured = {ALTITUDE.name: received(level, 0.0)} if measures else {}
        return {
            each.name: (known := robot(each.name)).with_(
                messages={
                    **known.messages,
                    ROBOT_DESCRIPTION.name: body(measures, each.name),
                    **measured,
                }
            )
            for each in TEAM.robots
        }

    rover, said = shown(team(), size)
    assert "attitude" not in said
    assert "height" not in said
    diver, says = shown(team(IMU, ALTITUDE), size)
    assert "─ depth" in says, "the title is what is shown"
    areas = [
        next(pane.place for pane in view.panes if pane.spec.name == "map")
        for view in (diver, rover)
    ]
    assert areas[0].width * areas[0].height < areas[1].width * areas[1].height


@for_each("size", SIZES)
def test_the_banner_leaves_the_option_bar_and_other_panes_in_sight(size: tuple[int, int]) -> None:
    expanded = words(scene(shipped("robobot-2003-expanded"), SITUATIONS["low-battery"], size))
    assert "collapse" in expanded
    assert "link" in expanded
    search = words(scene(shipped("search"), SITUATIONS["goal-blocked"], size))
    assert "─ map" in search


@for_each("shown", ["rover", "blimp"])
def test_how_a_task_ended_is_a_problem_unless_a_pane_shows_that_robots_task(shown: str) -> None:
    blocked = known.autonomy(phase=Phase.BLOCKED, why="no way", ended_s=1.0)
    team = {name: robot(name, autonomy=blocked) for name in ("rover", "blimp")}
    panes = (
        viewport("visualizeAlarms", (0, 0, 160, 48), robot="blimp"),
        viewport("visualizeAutonomy", (0, 48, 160, 48), robot=shown),
    )
    screen = View(layout_of(view(*panes)))
    screen.resize(80, 24)
    cells = rendered(screen, team, ConsoleState(now=NOW))
    assert cells is not None
    problems = words(cells).splitlines()[0]
    assert ("BLOCKED" in problems) == (shown == "rover")
