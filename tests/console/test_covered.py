"""The running console while something lies over its view: pages, the palette, questions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from textual import events
from textual.widgets import Input, OptionList

from rune_tui.controls.events import ControlEvent
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect
from rune_tui.ui.question import Question
from tests.console.app_desk import Desk, Script, scrolled_up


def test_the_words_of_a_mark_are_changed_once_and_keys_do_not_drive_meanwhile(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.console.state.ghosts)
        assert not desk.robot.book.points
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.robot.book.points)
        await desk.until(lambda: any("victim 1 is marked" in text for text in desk.notices))
        await desk.pilot.click(offset=(29, 14), button=3)
        await desk.until(lambda: isinstance(desk.console.screen, Question))
        await desk.until(lambda: desk.console.screen.focused is not None)
        await desk.press("ctrl+u", "w", "e", "t", "enter")
        await desk.until(lambda: desk.robot.book.points[0].note == "wet")
        await desk.until(lambda: not isinstance(desk.console.screen, Question))
        await desk.pilot.click(offset=(29, 14), button=3)
        await desk.until(lambda: isinstance(desk.console.focused, Input))
        line = desk.console.screen.focused
        for _ in range(3):  # as of enters that come at once
            line.post_message(Input.Submitted(line, "dry"))
        await desk.until(lambda: desk.robot.book.points[0].note == "dry")
        await desk.until(lambda: not isinstance(desk.console.screen, Question))
        assert len(desk.console.screen_stack) == 1
        assert not any(desk.robot.speeds)

    play(script)


def test_under_the_palette_keys_do_not_drive_and_what_is_chosen_is_done(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.drive()
        await desk.press("ctrl+p")
        assert desk.console.state.held == ()
        await desk.until(lambda: len(desk.console.screen_stack) == 2)
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
        await desk.press("w", "q", "backspace", "backspace", *"stop")
        assert set(await desk.commands(3)) == {0.0}
        assert desk.robot.stops == []
        # The list appears as fast as the machine allows, and enter takes what is in it by then.
        for _ in range(100):
            if desk.robot.stops:
                break
            await desk.press("enter")
            desk.robot.client.listen(0.02)
        assert "space" in desk.robot.stops[0]
        await desk.until(lambda: len(desk.console.screen_stack) == 1)

    play(script)


def test_a_list_that_finds_nothing_says_so_and_enter_does_nothing(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.press("ctrl+p")
        await desk.until(lambda: len(desk.console.screen_stack) == 2)

        def shown() -> str:
            listed = desk.console.screen.query(OptionList)
            return " ".join(str(option.prompt) for each in listed for option in each.options)

        await desk.until(lambda: isinstance(desk.console.focused, Input))
        await desk.press(*"zzqx")
        await desk.until(lambda: "Nothing here is called" in shown())
        await desk.press("enter")
        assert desk.robot.stops == []
        assert not any(desk.robot.speeds)

    play(script)


@pytest.mark.usefixtures("ends")
@pytest.mark.parametrize("keys", [("q", "q"), ("ctrl+p", "ctrl+c", "ctrl+c")])
def test_with_a_recording_the_console_asks_before_it_ends(
    play: Callable[[Script], None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    keys: tuple[str, ...],
):
    monkeypatch.setenv("XDG_DOCUMENTS_DIR", str(tmp_path))

    async def script(desk: Desk) -> None:
        await desk.press("r")
        await desk.until(lambda: desk.console.state.recording)
        await desk.drive()
        await desk.press(*keys[:-1])
        assert desk.console.state.leaving == ("the recording ends",)
        assert desk.console.state.held == ()
        assert not desk.console.leaving
        await desk.press("space")
        await desk.until(lambda: desk.robot.stops)
        assert desk.console.state.leaving
        await desk.press("escape")
        assert not desk.console.state.leaving
        await desk.press(*keys)
        assert desk.console.leaving
        desk.console.effects.end_recording()

    play(script)


@pytest.mark.usefixtures("ends")
@pytest.mark.parametrize("key", ["q", "ctrl+c"])
def test_where_nothing_is_lost_the_console_ends_at_once(play: Callable[[Script], None], key: str):
    async def script(desk: Desk) -> None:
        await desk.press(key)
        assert desk.console.leaving

    play(script)


def test_the_help_lets_go_and_its_key_closes_it(play: Callable[[Script], None]):
    async def script(desk: Desk) -> None:
        await desk.drive()
        await desk.press("question_mark")
        assert desk.console.state.held == ()
        assert desk.console.state.help
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
        await desk.press("w")
        assert set(await desk.commands(3)) == {0.0}
        await desk.press("escape")
        assert not desk.console.state.help
        await desk.drive()

    play(script)


def test_a_page_is_scrolled_by_keys_and_the_wheel_no_farther_than_its_end(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.pilot.resize_terminal(60, 10)
        await desk.press("f1", "end")
        end = desk.console.state.page.top
        assert 0 < end < 100
        await desk.press("pagedown", "up")
        assert desk.console.state.page.top == end - 1
        desk.console.on_mouse_scroll_up(scrolled_up())
        await desk.until(lambda: desk.console.state.page.top == max(0, end - 4))
        await desk.press("/", *"vict")
        assert desk.console.state.page.search == "vict"
        assert not any(desk.robot.speeds)

    play(script)


def test_an_answer_that_its_widget_cannot_take_leaves_the_console_running(
    play: Callable[[Script], None],
):
    def answer(text: str, _: ConsoleState) -> tuple[Effect, ...]:
        raise ValueError(text)

    async def script(desk: Desk) -> None:
        asked = AskEffect(robot="magellan", asked="Words", text="", answer=answer)
        desk.console.effects.run((asked,))
        await desk.press("x", "enter")
        await desk.until(lambda: any("could not be done" in text for text in desk.notices))
        await desk.drive()

    play(script)


def test_the_stop_key_stops_below_the_palette_and_is_no_part_of_the_search(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.press("ctrl+p")
        await desk.until(lambda: isinstance(desk.console.focused, Input))
        await desk.press("g", "space", "o")
        await desk.until(lambda: desk.robot.stops)
        assert desk.console.focused.value == "go"
        assert desk.console.covered

    play(script)


def test_the_stop_key_is_a_letter_of_an_answer_and_stops_the_second_time(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        answers: list[str] = []

        def answer(text: str, _: ConsoleState) -> tuple[Effect, ...]:
            answers.append(text)
            return ()

        ask = AskEffect(robot="magellan", asked="Words", text="", answer=answer)
        desk.console.effects.run((ask,))
        await desk.until(lambda: isinstance(desk.console.focused, Input))
        await desk.press(*"two", "space", "m", "space")
        await desk.commands(2)
        assert desk.robot.stops == []
        await desk.press("space")
        await desk.until(lambda: desk.robot.stops)
        await desk.press("x", "enter")
        assert answers == ["two m  x"]

    play(script)


@pytest.mark.parametrize("over", ["the list", "another window"])
def test_a_gamepad_that_nobody_sees_the_effect_of_only_stops(
    play: Callable[[Script], None], monkeypatch: pytest.MonkeyPatch, over: str
):
    async def script(desk: Desk) -> None:
        console = desk.console
        if over == "the list":
            await desk.press("ctrl+p")
            await desk.until(lambda: console.covered)
        else:
            console.post_message(events.AppBlur())
            await desk.until(lambda: not console.app_focus)
        moved = [ControlEvent(name=name, pressed=True) for name in ("q", "f", "w", "space")]
        monkeypatch.setattr(console.inputs.joysticks, "events", lambda _: iter(moved))
        console.inputs.joysticks_moved()
        assert not console.leaving
        assert not console.state.full
        await desk.until(lambda: desk.robot.stops)
        assert set(await desk.commands(2)) == {0.0}

    play(script)
