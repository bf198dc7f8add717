"""What lies over the whole picture: the help, notices and the banner."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.joystick_state import JoystickState
from rune_tui.model.robot_state import LinkPhase, LinkState
from rune_tui.model.theme import DARK
from rune_tui.view import View
from tests.console.states import layout_of, rendered
from tests.console.view_scenes import (
    NAVIGATION,
    STATE,
    known,
    robot,
    two_panes,
    view,
    viewport,
    words,
)


def test_the_help_lies_over_everything_and_takes_the_mouse() -> None:
    shown = two_panes()
    shown.resize(100, 20)
    state = dataclasses.replace(STATE, robots={"magellan": robot(), "blimp": robot("blimp")})
    helped = dataclasses.replace(state, help=True)
    assert shown.render(state) is not None
    cells = shown.render(helped)
    assert cells is not None
    lines = words(cells).splitlines()
    assert lines[0].strip().startswith("HELP")
    assert "escape: close" in lines[1]
    assert "blimp" in lines[18]  # what is vital stays to be seen
    assert (cells.pixels[:36, :, :3] == helped.theme.panel[:3]).all()
    assert shown.hits(10, 20, helped) == ()
    assert shown.render(helped) is None
    assert shown.render(state) is not None


@pytest.mark.parametrize(
    "changed",
    [
        {"trouble": "1 problem: layout.xml:3:5: no such thing"},
        {"joysticks": {"pad": JoystickState(name="pad", prompt="move lefty to its maximum")}},
    ],
)
def test_what_somebody_has_to_do_is_drawn_over_the_upper_edge_until_it_is_done(changed):
    over = View(
        layout_of(
            view(viewport("visualizeCameraImage", (0, 0, 80, 48), zpos=1000), xsize=80, ysize=48)
        )
    )
    over.resize(80, 24)
    robots = {"magellan": robot()}
    before = rendered(over, robots, STATE)
    troubled = dataclasses.replace(STATE, **changed)
    cells = rendered(over, robots, troubled)
    assert before is not None
    assert cells is not None
    said = "".join(chr(glyph) for glyph in cells.glyphs[:4].ravel())
    assert "no such thing" in said or "move lefty to its maximum" in said
    assert rendered(over, robots, troubled) is None
    after = rendered(over, robots, STATE)
    assert after is not None
    assert np.array_equal(after.glyphs, before.glyphs)


@pytest.mark.parametrize("function", ["visualizeStatus", "visualizeEventLog"])
def test_a_notice_is_shown_for_a_while_where_no_log_tells_of_it(function: str) -> None:
    screen = View(layout_of(view(viewport(function, (0, 80, 160, 16)))))
    screen.resize(100, 30)
    notice = Notice(text="no ground is known there", when=100.0, robot="magellan")
    state = ConsoleState(now=100.2, notices=(notice,))
    shown = rendered(screen, {"magellan": robot()}, state)
    assert shown is not None
    above = words(shown).splitlines()[:4]
    shown_here = any("magellan: no ground is known there" in line for line in above)
    assert shown_here == (function == "visualizeStatus")
    later = rendered(screen, {"magellan": robot()}, ConsoleState(now=107.0, notices=(notice,)))
    if shown_here:
        assert later is not None
        assert "no ground" not in words(later)
    quiet = dataclasses.replace(notice, quiet=True, when=107.0)
    screen.resize(100, 30)
    again = rendered(screen, {"magellan": robot()}, ConsoleState(now=107.0, notices=(quiet,)))
    assert again is not None
    assert "no ground" not in "\n".join(words(again).splitlines()[:4])


def test_what_went_wrong_just_now_is_on_the_banner_with_a_log_and_without() -> None:
    notice = Notice(text="the mark was not taken", when=100.0, robot="magellan", alarm=True)
    for function in ("visualizeStatus", "visualizeEventLog"):
        screen = View(layout_of(view(viewport(function, (0, 80, 160, 16)))))
        screen.resize(100, 24)
        state = ConsoleState(now=100.2, notices=(notice,))
        shown = rendered(screen, {"magellan": robot()}, state)
        assert shown is not None
        assert words(shown).splitlines()[0].strip() == "!!  the mark was not taken  !!"
        assert tuple(shown.pixels[0, 0, :3]) == DARK.alarm[:3]
        later = rendered(screen, {"magellan": robot()}, ConsoleState(now=107.0, notices=(notice,)))
        assert later is not None
        assert "not taken" not in words(later).splitlines()[0]


def test_the_gravest_alarm_of_all_robots_is_on_the_banner_and_nowhere_else() -> None:
    screen = two_panes()
    screen.resize(100, 20)
    lost = LinkState(phase=LinkPhase.LOST, since=90.0, endpoint="tcp://127.0.0.1:1")
    low = dataclasses.replace(NAVIGATION, battery_fraction=0.05)
    robots = {"magellan": robot(navigation=known(low)), "blimp": robot("blimp", link=lost)}
    shown = rendered(screen, robots, STATE)
    assert shown is not None
    first = words(shown).splitlines()[0]
    assert "blimp: LINK LOST 10 s" in first
    assert first.rstrip().endswith("+1")
    assert words(shown).count("LINK LOST") == 1
