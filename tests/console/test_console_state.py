"""What robots are called, and what of the console's state survives another layout."""

from __future__ import annotations

from pathlib import Path

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.mapping import PointKind
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState, Ghost, PictureWish, carried_over
from rune_tui.model.robot_state import LinkPhase, LinkState
from rune_tui.model.world import WorldPoint
from rune_tui.startup.opening import open_layout
from tests.console.states import described, robot_of
from tests.support.cases import for_each


def layout_of(folder: Path, run: int, robots: str, viewports: str) -> LayoutSpec:
    text = "".join(f'<robot name="{name}"/>' for name in robots)
    inner = "".join(
        f'<viewport name="{name}" robot="{robots[0]}" xpos="0" ypos="0" xsize="9" ysize="9"/>'
        for name in viewports
    )
    path = folder / "layout.xml"
    path.write_text(f'<rune run="{run}">{text}<view xsize="9" ysize="9">{inner}</view></rune>')
    return open_layout(path)


def test_what_the_operator_did_to_what_is_there_again_holds(tmp_path: Path) -> None:
    state = ConsoleState(
        now=1.0,
        chosen="b",
        shown={"v": False, "w": False, "y": True},
        full="v",
        zooms={"v": 2.0, "w": 3.0},
        wishes={"a": PictureWish(quality=1), "b": PictureWish(quality=2)},
        night=frozenset("ab"),
        trouble="1 problem",
    )
    kept = carried_over(state, layout_of(tmp_path, 2, "bc", "wxy"))
    assert (kept.chosen, kept.trouble, kept.full) == ("b", "", "")
    assert kept.shown == {"w": False, "y": True}
    assert kept.zooms == {"w": 3.0}
    assert (kept.wishes, kept.night) == ({"b": PictureWish(quality=2)}, frozenset("b"))


def test_a_chosen_robot_that_is_gone_gives_way_to_the_first(tmp_path: Path) -> None:
    before = layout_of(tmp_path, 4, "ab", "")
    state = ConsoleState.at_start(before, 1.0)
    assert carried_over(state, layout_of(tmp_path, 5, "cd", "")).chosen == "c"


def test_the_ghost_of_a_mark_ends_with_the_layout_whose_widgets_would_end_it(
    tmp_path: Path,
) -> None:
    place = WorldPoint(x=1.0, y=2.0, uncertainty=0.1)
    ghost = Ghost(kind=PointKind.VICTIM, place=place, until=9.0)
    state = ConsoleState(now=1.0, ghosts={"a": ghost})
    assert not carried_over(state, layout_of(tmp_path, 2, "a", "v")).ghosts


@for_each(
    ("own", "titles"),
    [
        ({"robot": "magellan"}, ["magellan"]),
        ({"robot": ""}, ["robot"]),
        ({"left": "anna", "right": "ben"}, ["anna", "ben"]),
        ({"left": "magellan", "right": "magellan"}, ["left", "right"]),
        ({"left": "magellan", "right": "magellan", "boat": "anna"}, ["left", "right", "anna"]),
        ({"left": "right", "right": "left"}, ["left", "right"]),
        ({"left": "left", "right": ""}, ["left", "right"]),
    ],
)
def test_robots_go_by_their_own_names_and_by_their_roles_where_names_are_alike(
    own: dict[str, str], titles: list[str]
) -> None:
    link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
    robots = {
        role: robot_of(name=role, link=link, messages={ROBOT_DESCRIPTION.name: described(name)})
        for role, name in own.items()
    }
    state = ConsoleState(now=1.0, robots=robots)
    assert [state.title(role) for role in own] == titles
