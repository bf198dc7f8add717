"""The running console at a real bus: hands, the mouse, marks and faults."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from textual import events

from hub.command_line import ExitCode
from hub.gcm.navigation import STOP, TURN_COMMAND, Stop, TurnCommand
from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityReports
from hub.recording.recording_set import RecordingSet
from rune_tui.compositor.cells import Cells
from rune_tui.controls.events import PAUSE_S
from rune_tui.drawn_layers import DrawnLayers
from rune_tui.layout.loader import load_layout
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Notify, SendEffect
from rune_tui.model.own_records import RUNE_INPUT
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.ui.driver_reports import KeyMoved
from rune_tui.ui.live_state import LiveState
from rune_tui.view import View
from tests.console.app_desk import Desk, Script
from tests.support.full_disk import files_no_longer_than


def test_a_click_on_the_floor_is_a_mark_on_the_robots_map_and_undo_takes_it_back(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.console.state.ghosts)
        assert not desk.robot.book.points
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.robot.book.points)
        (point,) = desk.robot.book.points
        assert (point.x, point.y) == pytest.approx((10 * 29.5 / 60, -10 * 29.5 / 40))
        assert point.by == "jane"
        assert (point.uncertainty, point.note) == (pytest.approx(0.1), "")
        await desk.until(lambda: any("victim 1 is marked" in text for text in desk.notices))
        await desk.press("u")
        await desk.until(lambda: not desk.robot.book.points)

    play(script)


def test_a_click_on_a_wall_marks_nothing_and_says_so(play: Callable[[Script], None]):
    async def script(desk: Desk) -> None:
        await desk.pilot.click(offset=(29, 3))
        await desk.until(lambda: any("nothing tells how far" in text for text in desk.notices))
        await desk.commands(2)
        assert not desk.robot.book.points

    play(script)


def test_a_button_that_is_held_no_longer_drives_when_what_is_under_it_changes(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        for change, back in (("f", "f"), ("question_mark", "escape"), ("ctrl+p", "escape"), "vv"):
            await desk.pilot.mouse_down(offset=(29, 14), button=2)
            await desk.until(lambda: desk.robot.speeds[-1] > 0.0)
            await desk.press(change)
            await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
            assert set(await desk.commands(3)) == {0.0}, change
            await desk.pilot.mouse_up(offset=(29, 14))
            await desk.press(back)

    play(script)


def test_a_key_that_was_let_go_of_for_the_operator_has_to_go_up_first(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.drive()
        desk.console.on_app_blur()
        await desk.press("w")
        assert desk.console.state.held == ()
        assert desk.console.state.must_release == ("w",)
        await desk.until(lambda: not desk.console.state.must_release)
        await desk.drive()

    play(script)


def test_a_button_drives_no_longer_when_the_mouse_says_that_none_is_down(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.pilot.mouse_down(offset=(29, 14), button=2)
        await desk.until(lambda: desk.robot.speeds[-1] > 0.0)
        await desk.pilot.hover(offset=(20, 10))  # it went up where the terminal did not see it
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
        assert set(await desk.commands(3)) == {0.0}

    play(script)


def test_a_key_drives_on_while_viewports_come_and_go(play: Callable[[Script], None]):
    async def script(desk: Desk) -> None:
        for _ in range(10):  # on a busy machine the key is up before the other one is read
            await desk.drive()
            await desk.press("v")
            if (await desk.commands(1))[0] > 0.0:
                return
        pytest.fail("showing a viewport let go of the key")

    play(script)


def test_a_key_drives_on_and_a_button_is_let_go_when_another_size_moves_viewports(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        console = desk.console
        await desk.report_releases()
        console.post_message(KeyMoved("w", "w", KeyMove.PRESS))
        await desk.until(lambda: desk.robot.speeds[-1] > 0.0)
        await desk.pilot.resize_terminal(120, 20)
        await desk.until(lambda: console.state.rows and console.size.width == 120)
        assert "w" in console.state.held
        assert set(await desk.commands(3)) == {desk.robot.speeds[-1]}
        console.post_message(KeyMoved("w", "w", KeyMove.RELEASE))
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
        await desk.pilot.mouse_down(offset=(90, 14), button=2)
        await desk.until(lambda: desk.robot.speeds[-1] > 0.0)
        await desk.pilot.resize_terminal(60, 20)
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)

    play(script)


def test_a_key_of_another_script_is_the_us_key_or_is_said_to_do_nothing(
    play: Callable[[Script], None], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("LC_ALL", "C")

    async def script(desk: Desk) -> None:
        console = desk.console
        console.post_message(events.Key("ц", "ц"))
        console.post_message(events.Key("ц", "ц"))
        await desk.until(lambda: [text for text in desk.notices if "ц (U+0446) is bound" in text])
        await desk.report_releases()
        console.post_message(KeyMoved("ц", "ц", KeyMove.PRESS, base="w"))
        await desk.until(lambda: desk.robot.speeds[-1:] > [0.0])
        console.post_message(KeyMoved("ц", "ц", KeyMove.RELEASE, base="w"))
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
        assert len([text for text in desk.notices if "is bound to nothing" in text]) == 1

    play(script)


def test_what_is_held_is_let_go_when_the_terminal_tells_of_releases_no_longer(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        console = desk.console
        await desk.report_releases()
        console.post_message(KeyMoved("w", "w", KeyMove.PRESS))
        await desk.until(lambda: "w" in console.state.held)
        await desk.report_releases(reported=False)
        assert not console.state.held

    play(script)


def test_a_stop_that_was_typed_while_the_console_was_held_up_is_a_stop_and_nothing_drives(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.until(lambda: not desk.console.inputs.is_stale(time.monotonic()))
        time.sleep(PAUSE_S + 0.1)  # noqa: ASYNC251 - it is held up
        await desk.press("w", "space")
        await desk.until(lambda: desk.robot.stops)
        assert "w" not in desk.console.state.held
        assert [text for text in desk.notices if "typed while it was blocked" in text]

    play(script)


def test_keys_of_a_layout_that_the_terminal_does_not_tell_are_named_once(
    play: Callable[[Script], None], tmp_path: Path
):
    async def script(desk: Desk) -> None:
        assert not [text for text in desk.notices if "does not tell" in text]
        path = tmp_path / "layout.xml"
        path.write_text(path.read_text().replace('"w" control', '"kp_8" control'))
        for reported in (True, False, False):
            await desk.report_releases(reported=reported)
            await desk.console.effects.open_layout(
                load_layout(path, desk.console.current.layout.vocabulary)
            )
        missed = [text for text in desk.notices if "does not tell kp_8" in text]
        assert len(missed) == 1
        assert desk.notices.index(missed[0]) > desk.notices.index(f"opened {path}")

    play(script)


def test_an_effect_that_cannot_be_done_is_told_once_and_what_comes_after_it_is_done(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        nowhere = SendEffect(robot="nobody", definition=STOP, value=Stop(reason="the test"))
        stop = SendEffect(robot="magellan", definition=STOP, value=Stop(reason="the test"))
        desk.console.effects.run((nowhere, nowhere, stop))
        await desk.until(lambda: desk.robot.stops)
        assert len([text for text in desk.notices if "could not be done" in text]) == 1

    play(script)


def test_no_confirmation_hides_the_reason_why_an_order_is_not_sent(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        reports = CapabilityReports(robot="magellan", capabilities=())
        desk.robot.client.publish(CAPABILITY_REPORTS, reports)
        await desk.until(lambda: desk.link.state.link.lacking)
        state = desk.console.state
        desk.console.effects.run(
            (
                SendEffect(robot="magellan", definition=TURN_COMMAND, value=TurnCommand()),
                Notify.now(state, "it turns", robot="magellan"),
                Notify.now(state, "it is hot", robot="magellan", alarm=True),
                Notify.now(state, "another robot turns", robot="other"),
            )
        )
        last = [notice.text for notice in desk.console.state.notices][-3:]
        assert "turn command has no effect: it does not provide" in last[0]
        assert last[1:] == ["it is hot", "another robot turns"]

    play(script)


def test_the_click_that_brings_the_terminal_to_the_front_marks_nothing(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        desk.console.post_message(events.AppBlur())
        desk.console.post_message(events.AppFocus())
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: any("click again" in text for text in desk.notices))
        assert not desk.console.state.ghosts

    play(script)


def test_a_step_that_fails_ends_no_console_and_leaves_the_others(
    play: Callable[[Script], None], monkeypatch: pytest.MonkeyPatch
):
    def broken(*_: Any) -> Any:
        text = "a fault of ours"
        raise ValueError(text)

    async def script(desk: Desk) -> None:
        with monkeypatch.context() as patch:
            patch.setattr(desk.console.inputs.joysticks, "tick", broken)
            await desk.until(lambda: any("could not be done" in text for text in desk.notices))
            await desk.drive()
        assert len([text for text in desk.notices if "could not be done" in text]) == 1

    play(script)


def test_a_recording_that_a_full_disk_ends_is_not_shown_as_running(
    play: Callable[[Script], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DOCUMENTS_DIR", str(tmp_path))

    async def script(desk: Desk) -> None:
        await desk.press("r")
        await desk.until(lambda: desk.console.state.recording)
        with files_no_longer_than(1):
            await desk.until(lambda: not desk.console.state.recording)
            await desk.until(lambda: any("then it ended: " in text for text in desk.notices))
        assert desk.console.state.notices[-1].alarm
        assert desk.console.effects.end_recording() == ExitCode.NOT_KEPT

    play(script)


def test_a_recording_has_keys_that_are_down_at_its_begin_or_answer_a_study(
    play: Callable[[Script], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DOCUMENTS_DIR", str(tmp_path))
    # A busy machine holds the console up, which releases all keys and drops the next one.
    monkeypatch.setattr("rune_tui.ui.input_events.PAUSE_S", math.inf)

    async def script(desk: Desk) -> None:
        for key in "wr":  # at once: a key without repeats counts as up after a while
            desk.console.post_message(KeyMoved(key, key, KeyMove.PRESS))
        await desk.until(lambda: desk.console.state.recording)
        path = desk.console.state.recording
        desk.console.inputs.note_taken("f6", time.monotonic(), repeat=False)
        desk.console.post_message(KeyMoved("w", "w", KeyMove.RELEASE))
        await desk.until(lambda: "w" not in desk.console.state.held)
        desk.console.effects.end_recording()
        with RecordingSet.open([Path(path)]) as recorded:
            channels = {
                number
                for number, topic in recorded.channels.items()
                if topic.message == RUNE_INPUT.name
            }
            messages = [*recorded.messages(channels=channels)]
        moves = [RUNE_INPUT.decode(each.payload) for each in messages]
        assert [each.input for each in moves].count("f6") == 1
        found = [(each.pressed, each.repeat) for each in moves if each.input == "w"]
        assert (found[0], found[-1]) == ((True, True), (False, False))

    play(script)


def test_withheld_control_lets_only_stops_through_and_says_why(
    play: Callable[[Script], None],
) -> None:
    async def script(desk: Desk) -> None:
        inputs = desk.console.inputs
        assert inputs.unused_for(time.monotonic()) > 0.0
        await desk.drive()
        assert inputs.unused_for(time.monotonic()) == 0.0
        inputs.release_all()
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
        assert inputs.unused_for(time.monotonic()) > 0.0
        inputs.withheld = True
        count = sum(map(bool, desk.robot.speeds))
        await desk.press("w")
        await desk.until(lambda: "control is withheld" in " ".join(desk.notices))
        await desk.press("space")
        await desk.until(lambda: desk.robot.stops)
        assert sum(map(bool, desk.robot.speeds)) == count
        inputs.withheld = False
        inputs.release_all()
        desk.robot.speeds.clear()
        await desk.drive()

    play(script)


def test_a_key_that_drives_has_one_state_built_for_it(
    play: Callable[[Script], None], monkeypatch: pytest.MonkeyPatch
):
    async def script(desk: Desk) -> None:
        console, built = desk.console, []
        await desk.report_releases()
        build = vars(LiveState)["now"].fget
        monkeypatch.setattr(LiveState, "now", property(lambda self: built.append(1) or build(self)))
        for move in (KeyMove.PRESS, KeyMove.RELEASE, KeyMove.PRESS):
            built.clear()
            console.on_key_moved(KeyMoved("w", "w", move))
            count = len(built)
            await desk.until(lambda d=move is KeyMove.PRESS: (desk.robot.speeds[-1] > 0.0) == d)
        assert count == 1  # the first command after a choice is recorded, from another state

    play(script)


def test_a_key_is_handled_between_the_parts_of_a_frame(
    play: Callable[[Script], None], monkeypatch: pytest.MonkeyPatch
):
    async def script(desk: Desk) -> None:
        console, held = desk.console, []
        await desk.report_releases()
        draw, compose = View.draw, View.compose

        def draw_late(view: View, state: ConsoleState) -> DrawnLayers | None:
            drawn = draw(view, state)
            if drawn is not None:
                console.post_message(KeyMoved("w", "w", KeyMove.PRESS))
            return drawn

        def compose_after(view: View, drawn: DrawnLayers) -> Cells | None:
            held.append("w" in console.inputs.keyboard.held)
            return compose(view, drawn)

        monkeypatch.setattr(View, "draw", draw_late)
        monkeypatch.setattr(View, "compose", compose_after)
        console.effects.run((Notify.now(console.state, "something to draw"),))
        await desk.until(lambda: held)
        assert all(held)

    play(script)
