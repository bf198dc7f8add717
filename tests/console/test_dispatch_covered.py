"""Which keys count while a page or a question is open, and after the console was away."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from rune_tui.controls.events import ControlEvent
from rune_tui.controls.keyboard import KeyboardHold
from rune_tui.dispatch import Dispatch
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    AskToLeave,
    Effect,
    Notify,
    PaletteEffect,
    QuitEffect,
    ReleaseFirst,
    SuspendEffect,
    ToggleHelp,
    ToggleLog,
)
from rune_tui.model.page import Page
from rune_tui.model.robot_state import LinkPhase, LinkState, Received
from rune_tui.startup.opening import open_layout
from tests.console.dispatching import DEMO, TWO_ROBOTS, at, down, stops, up, velocities
from tests.console.states import robot_of
from tests.support.messages import robot_state


def test_quit_is_global(two_robots: LayoutSpec):
    assert Dispatch(two_robots).handle(down("q"), at(0.0)) == (QuitEffect(),)


HELPED = dataclasses.replace(at(0.0), help=True)


ASKED = ConsoleState(now=0.0, leaving=("the recording ends",))


def test_asked_about_the_end_the_same_key_and_enter_confirm(two_robots: LayoutSpec):
    for key in ("q", "enter"):
        assert Dispatch(two_robots).handle(down(key), ASKED) == (QuitEffect(),)


def test_a_quick_second_press_answers_and_a_page_takes_it_once(two_robots: LayoutSpec):
    quick = dataclasses.replace(down("q"), second=True)
    assert Dispatch(two_robots).handle(quick, ASKED) == (QuitEffect(),)
    assert Dispatch(two_robots).handle(quick, HELPED) == ()


def test_asked_about_the_end_the_stop_stops_and_the_question_stays(two_robots: LayoutSpec):
    effects = Dispatch(two_robots).handle(down("space"), ASKED)
    assert stops(effects) == ["robot"]
    assert not any(isinstance(each, AskToLeave) for each in effects)


def test_the_key_that_disarms_does_so_under_a_page_and_asked_about_the_end(tmp_path: Path):
    path, stop = tmp_path / "layout.xml", '<widget handler="widgetStop">'
    disarm = '<widget handler="widgetDisarm"><event key="f9"/></widget>'
    arms = '<capability name="DRV_ARM"/><capability name="NAV_MOVE"/>'
    made = TWO_ROBOTS.replace(stop, disarm + stop)
    path.write_text(made.replace('<capability name="NAV_MOVE"/>', arms, 1))
    dispatch = Dispatch(open_layout(path))
    known = dataclasses.replace(
        at(0.0),
        robots={
            "robot": robot_of(
                name="robot", link=LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
            )
        },
    )
    for covered, before in (({"help": True}, 0), ({"leaving": ASKED.leaving}, 1)):
        effects = dispatch.handle(down("f9"), dataclasses.replace(known, **covered))
        assert [type(each) for each in effects] == [AskToLeave] * before + [Notify]
    peeks = dataclasses.replace(known, peeked="blimp")
    (said,) = dispatch.handle(down("f9"), peeks)
    assert isinstance(said, Notify)
    assert "while you peek" in said.notice.text


def test_asked_about_the_end_an_enter_that_stops_does_nothing_else(tmp_path: Path):
    path = tmp_path / "layout.xml"
    path.write_text(TWO_ROBOTS.replace('key="space"', 'key="enter"'))
    effects = Dispatch(open_layout(path)).handle(down("enter"), ASKED)
    assert stops(effects) == ["robot"]
    assert QuitEffect() not in effects


def test_asked_about_the_end_any_other_key_stays_and_does_nothing_else(
    two_robots: LayoutSpec,
):
    stay = AskToLeave(reasons=())
    assert Dispatch(two_robots).handle(down("escape"), ASKED) == (stay,)
    release = ReleaseFirst(keys=frozenset({"w"}))
    assert Dispatch(two_robots).handle(down("w"), ASKED) == (stay, release)


def test_a_driving_key_that_is_typed_into_a_search_comes_once(two_robots: LayoutSpec):
    state = dataclasses.replace(at(0.0), help=True, page=Page(typing=True))
    typed = ControlEvent(name="w", pressed=True, must_release_first=True)
    (turned,) = Dispatch(two_robots).handle(typed, state)
    assert turned.page.search == "w"
    again = ControlEvent(name="w", pressed=True, proven=True)
    assert Dispatch(two_robots).handle(again, dataclasses.replace(state, page=turned.page)) == ()


def test_asked_about_the_end_a_key_that_repeats_or_goes_up_answers_nothing(
    two_robots: LayoutSpec,
):
    held = ControlEvent(name="q", pressed=True, repeat=True)
    assert Dispatch(two_robots).handle(held, ASKED) == ()
    assert Dispatch(two_robots).handle(up("q"), ASKED) == ()
    moved = ControlEvent(name="mouse motion", pressed=True)
    assert Dispatch(two_robots).handle(moved, ASKED) == ()


def test_under_the_help_only_stop_help_and_quit_count(two_robots: LayoutSpec):
    dispatch = Dispatch(two_robots)
    for key in ("w", "e", "h", "i"):
        assert dispatch.handle(down(key), HELPED) == ()
    assert stops(dispatch.handle(down("space"), HELPED)) == ["robot"]
    assert dispatch.handle(down("q"), HELPED) == (QuitEffect(),)


def test_a_stop_that_came_and_went_between_two_reports_has_keys_released_first(
    two_robots: LayoutSpec,
):
    dispatch = Dispatch(two_robots)

    def reported(stops: int) -> ConsoleState:
        navigation = Received(value=robot_state(stops=stops), measured=0.0, number=1)
        link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
        robot = robot_of(name="robot", link=link, navigation=navigation)
        return ConsoleState(now=0.0, robots={"robot": robot})

    assert not [each for each in dispatch.look(reported(7)) if isinstance(each, ReleaseFirst)]
    dispatch.handle(down("w"), reported(7))
    assert dispatch.look(reported(7)) == []
    *stopped, required = dispatch.look(reported(8))
    assert velocities(tuple(stopped), "robot") == [(0.0, 0.0)]
    assert isinstance(required, ReleaseFirst)
    assert required.keys >= {"w", "e"}
    assert dispatch.look(reported(8)) == []


def old(key: str, *, repeat: bool = False) -> ControlEvent:
    return ControlEvent(name=key, pressed=True, repeat=repeat, must_release_first=True, stale=True)


def test_of_what_may_have_been_typed_while_the_console_was_away_only_a_stop_counts(
    two_robots: LayoutSpec,
):
    dispatch = Dispatch(two_robots)
    assert stops(dispatch.handle(old("space"), at(0.0))) == ["robot"]
    assert stops(dispatch.handle(old("space", repeat=True), at(0.0))) == ["robot"]


@pytest.mark.parametrize("key", ["w", "h", "q", "?", "ctrl+z", "ctrl+p"])
def test_what_else_may_have_been_typed_while_the_console_was_away_is_told_once(
    two_robots: LayoutSpec, key: str
):
    dispatch = Dispatch(two_robots)
    (effect,) = dispatch.handle(old(key), at(0.0))
    assert isinstance(effect, Notify)
    assert effect.notice.text.endswith("right after: pause, then press it again")
    assert dispatch.handle(old(key, repeat=True), at(0.0)) == ()


def test_a_key_that_repeats_and_was_never_pressed_does_nothing_but_stop(two_robots: LayoutSpec):
    dispatch, keyboard = Dispatch(two_robots), KeyboardHold()
    done: dict[str, list[Effect]] = {}
    for key in ("w", "h", "q", "?", "ctrl+z", "space"):
        events = (*keyboard.down(key, 0.0, repeat=True), *keyboard.up(key, 0.0))
        done[key] = [each for event in events for each in dispatch.handle(event, at(0.0))]
    assert stops(done.pop("space")) == ["robot"]
    assert not any(done.values()), done


def test_a_key_that_means_nothing_is_not_missed(two_robots: LayoutSpec):
    assert Dispatch(two_robots).handle(old("x"), at(0.0)) == ()


def test_a_key_that_goes_up_under_the_help_is_let_go(two_robots: LayoutSpec):
    dispatch = Dispatch(two_robots)
    dispatch.handle(down("i"), at(0.0))
    assert velocities(dispatch.handle(up("i"), HELPED), "blimp") == [(0.0, 0.0)]


def test_under_the_help_nothing_is_done_when_a_key_goes_up(tmp_path: Path):
    path = tmp_path / "up.xml"
    path.write_text(TWO_ROBOTS.replace('key="h"', 'key="h" when="released"'))
    dispatch = Dispatch(open_layout(path))
    assert dispatch.handle(up("h"), at(0.0)) != ()
    assert dispatch.handle(up("h"), HELPED) == ()


def test_the_question_mark_opens_and_closes_the_help_and_escape_closes_it():
    dispatch = Dispatch(DEMO)
    assert dispatch.handle(down("?"), at(0.0)) == (ToggleHelp(),)
    assert dispatch.handle(down("?"), HELPED) == (ToggleHelp(),)
    assert dispatch.handle(down("escape"), HELPED) == (ToggleHelp(),)
    assert dispatch.handle(down("escape"), at(0.0)) == ()
    held = ControlEvent(name="?", pressed=True, repeat=True)
    assert dispatch.handle(held, HELPED) == ()


def test_the_list_opens_and_the_shell_comes_back_also_from_a_page():
    dispatch = Dispatch(DEMO)
    assert dispatch.handle(down("ctrl+p"), at(0.0)) == (PaletteEffect(),)
    assert dispatch.handle(down("ctrl+z"), at(0.0)) == (SuspendEffect(),)
    logged = ConsoleState(now=0.0, log=True)
    searching = dataclasses.replace(HELPED, page=Page(typing=True))
    for state, page in ((HELPED, ToggleHelp()), (logged, ToggleLog()), (searching, ToggleHelp())):
        assert dispatch.handle(down("ctrl+p"), state) == (page, PaletteEffect())
        assert dispatch.handle(down("ctrl+z"), state) == (SuspendEffect(),)
        held = ControlEvent(name="ctrl+p", pressed=True, repeat=True)
        assert dispatch.handle(held, state) == ()


def test_keys_that_the_layout_binds_are_the_layouts(tmp_path: Path):
    path = tmp_path / "bound.xml"
    bound = '<event key="q"/><event key="?"/><event key="ctrl+p"/><event key="escape"/>'
    path.write_text(TWO_ROBOTS.replace('<event key="q"/>', bound))
    dispatch = Dispatch(open_layout(path))
    for key in ("?", "ctrl+p", "escape"):
        assert dispatch.handle(down(key), at(0.0)) == (QuitEffect(),)
    # Whoever wants to leave the help does not want to end the console.
    assert dispatch.handle(down("escape"), HELPED) == (ToggleHelp(),)


def test_an_escape_that_stops_still_stops_under_the_help(tmp_path: Path):
    path = tmp_path / "stop.xml"
    path.write_text(TWO_ROBOTS.replace('key="space"', 'key="escape"'))
    effects = Dispatch(open_layout(path)).handle(down("escape"), HELPED)
    assert effects[0] == ToggleHelp()
    assert stops(effects) == ["robot"]
