"""The running console at a real bus: from the mouse to marks, the palette, the help."""

from __future__ import annotations

import asyncio
import dataclasses
import time
from collections.abc import Callable, Coroutine, Hashable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any, ClassVar, Self

import pytest
from textual import events
from textual.events import MouseScrollUp
from textual.pilot import Pilot
from textual.widgets import Input

from hub.gcm.mapping import (
    INTEREST_POINTS,
    POINT_COMMAND,
    InterestPoints,
    PointAction,
    PointCommand,
)
from hub.gcm.navigation import STOP, VELOCITY_COMMAND, Stop, Twist
from hub.ipc.central import Central
from hub.ipc.client import Client
from hub.missions.points import PointBook
from rune_tui.app import Console
from rune_tui.controls.stall_guard import STALL_S
from rune_tui.layout.loader import load_layout
from rune_tui.layout.rules import VisualizerRule, Vocabulary
from rune_tui.layout.spec import VisualizerSpec
from rune_tui.layout.watching import LayoutSource
from rune_tui.link.robot_link import RobotLink
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect, SendEffect
from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.opening import BUILT_IN
from rune_tui.raster.canvas import Canvas
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import traits_of
from rune_tui.ui.driver_reports import KeyMoved, ReleasesTold
from rune_tui.ui.question import Question

LAYOUT = """<rune>
  <robot name="magellan" hub="{hub}">
    <capability name="VIS_VID"/><capability name="VIS_PTZ"/><capability name="VIS_NIGHT"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/><capability name="NAV_GOAL"/>
    <capability name="PRO_MAP"/><capability name="PRO_POINTS"/><capability name="AUT_PILOT"/>
  </robot>
  <view>
    <arrangement name="usual" xsize="60" ysize="40">
      <place viewport="floor" xpos="0" ypos="0" xsize="60" ysize="40"/>
    </arrangement>
    <arrangement name="wide" min-columns="90" xsize="120" ysize="40">
      <place viewport="floor" xpos="60" ypos="0" xsize="60" ysize="40"/>
    </arrangement>
    <widget handler="widgetQuit"><event key="q"/></widget>
    <widget handler="widgetRecord"><event key="r"/></widget>
    <viewport name="floor">
      <visualizer function="visualizeFloor"/>
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/><event mouse="middle" control="translate"/>
      </widget>
      <widget handler="widgetShowViewport"><event key="v"/></widget>
      <widget handler="widgetFullScreen"><event key="f"/></widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetSetVictim"><event mouse="left"/></widget>
      <widget handler="widgetUndoMark"><event key="u"/></widget>
      <widget handler="widgetEditMark"><event mouse="right"/></widget>
    </viewport>
  </view>
</rune>
"""
TIMEOUT = 20.0
TRAITS = traits_of(Answers(truecolour=True), {}, (60, 20))


class Floor:
    """Shows ten by ten metres from above; the upper half is wall."""

    rule: ClassVar = VisualizerRule(meaning="a floor")
    whole_cells: ClassVar[bool] = False

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        del spec
        return cls()

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        del robot
        canvas.fill(state.theme.panel)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        return robot.name, state.theme.name

    def locate(
        self,
        pixel: tuple[float, float],
        size: tuple[int, int],
        robot: RobotState,
        state: ConsoleState,
    ) -> WorldPoint | None:
        del robot, state
        x, y = 10.0 * pixel[0] / size[0], 10.0 * pixel[1] / size[1]
        return WorldPoint(x=x, y=-y, uncertainty=0.1) if y > 5.0 else None


class Robot:
    """The robot's side: a map that takes marks as the mapping module does."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.book = PointBook()
        self.speeds: list[float] = []
        self.stops: list[str] = []
        client.subscribe(POINT_COMMAND, lambda command, _: self._mark(command))
        client.subscribe(VELOCITY_COMMAND, lambda twist, _: self._drive(twist))
        client.subscribe(STOP, lambda stop, _: self._stop(stop))
        client.wait_connected(5.0)

    def _mark(self, command: PointCommand) -> None:
        if command.action is PointAction.REMOVE:
            self.book.drop(command.point.number)
        else:
            self.book.mark(command.point, "somebody", 1.0)
        kept = tuple(dataclasses.replace(point, kept=1) for point in self.book.points)
        self.client.publish(INTEREST_POINTS, InterestPoints(count=len(kept), points=kept))

    def _drive(self, twist: Twist) -> None:
        self.speeds.append(twist.linear.x)

    def _stop(self, stop: Stop) -> None:
        self.stops.append(stop.reason)


class Desk:
    """A console under Textual's pilot, and the robot that it is linked to."""

    def __init__(self, console: Console, link: RobotLink, robot: Robot, pilot: Pilot[Any]) -> None:
        self.console, self.link, self.robot, self.pilot = console, link, robot, pilot

    async def until(self, condition: Callable[[], object]) -> None:
        end = time.monotonic() + TIMEOUT
        while not condition():
            assert time.monotonic() < end, self.told
            self.robot.client.listen(0.005)
            await self.pilot.pause(0.005)

    @property
    def told(self) -> list[str]:
        return [notice.text for notice in self.console.state.notices]

    async def press(self, *keys: str) -> None:
        for key in keys:
            await self.pilot.press(key)
            self.robot.client.listen(0.0)  # a robot never sleeps for as long as a hand types

    async def drive(self) -> None:
        """Press the key for forward until the robot is told to drive.

        Pressed too soon after all was let go it counts as still down, and a machine that is too
        busy loses it.
        """
        end = time.monotonic() + TIMEOUT
        while not self.robot.speeds or self.robot.speeds[-1] <= 0.0:
            assert time.monotonic() < end, self.told
            await self.press("w")
            again = time.monotonic() + 1.0
            while self.robot.speeds[-1:] <= [0.0] and time.monotonic() < again:
                self.robot.client.listen(0.005)
                await self.pilot.pause(0.005)

    async def commands(self, count: int) -> list[float]:
        """The next so many speeds that are commanded."""
        before = len(self.robot.speeds)
        await self.until(lambda: len(self.robot.speeds) >= before + count)
        return self.robot.speeds[before:]


def scrolled_up() -> MouseScrollUp:
    """The wheel turned away from the operator in the middle of the screen."""
    return MouseScrollUp(
        None, 30, 10, 0, 0, 0, shift=False, meta=False, ctrl=False, screen_x=30, screen_y=10
    )


Script = Callable[[Desk], Coroutine[Any, Any, None]]


@pytest.fixture
def play(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Script], None]]:
    """Runs a script at a console that is linked to a robot."""
    monkeypatch.setenv("LOGNAME", "jane")
    with ExitStack() as stack:
        central = stack.enter_context(closing(Central([f"ipc://{tmp_path}/central"])))
        robot = Robot(stack.enter_context(closing(Client("robot", central.endpoints[0]))))
        path = tmp_path / "layout.xml"
        path.write_text(LAYOUT.format(hub=central.endpoints[0]))
        visualizers = {**BUILT_IN.visualizers, "visualizeFloor": Floor}
        vocabulary = Vocabulary(visualizers=visualizers, widgets=BUILT_IN.widgets)
        layout = load_layout(path, vocabulary)
        source = LayoutSource(
            [str(path)], lambda name: load_layout(name, vocabulary), layout, watched=False
        )
        links = RobotLinks(layout)
        link = links["magellan"]
        link.start()
        stack.enter_context(closing(link))

        async def run(script: Script) -> None:
            console = Console(source, links, TRAITS)
            async with console.run_test(size=(60, 20)) as pilot:
                desk = Desk(console, link, robot, pilot)
                await desk.until(lambda: link.state.link.phase is LinkPhase.CONNECTED)
                await desk.until(lambda: robot.speeds)
                await script(desk)

        yield lambda script: asyncio.run(run(script))


def test_a_click_on_the_floor_is_a_mark_on_the_robots_map_and_undo_takes_it_back(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.console.state.ghosts)
        assert desk.robot.book.message.count == 0
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.robot.book.message.count)
        (point,) = desk.robot.book.message.points
        assert (point.x, point.y) == pytest.approx((10 * 29.5 / 60, -10 * 29.5 / 40))
        assert point.by == "jane"
        assert (point.uncertainty, point.note) == (pytest.approx(0.1), "")
        await desk.until(lambda: any("victim 1 is marked" in text for text in desk.told))
        await desk.press("u")
        await desk.until(lambda: desk.robot.book.message.count == 0)

    play(script)


def test_the_words_of_a_mark_are_changed_and_keys_do_not_drive_meanwhile(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.console.state.ghosts)
        assert desk.robot.book.message.count == 0
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.robot.book.message.count)
        await desk.until(lambda: any("victim 1 is marked" in text for text in desk.told))
        await desk.pilot.click(offset=(29, 14), button=3)
        await desk.until(lambda: isinstance(desk.console.screen, Question))
        await desk.until(lambda: desk.console.screen.focused is not None)
        await desk.press("ctrl+u", "w", "e", "t", "enter")
        await desk.until(lambda: desk.robot.book.message.points[0].note == "wet")
        assert not any(desk.robot.speeds)

    play(script)


def test_a_click_on_a_wall_marks_nothing_and_says_so(play: Callable[[Script], None]):
    async def script(desk: Desk) -> None:
        await desk.pilot.click(offset=(29, 3))
        await desk.until(lambda: any("nothing tells how far" in text for text in desk.told))
        await desk.commands(2)
        assert desk.robot.book.message.count == 0

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


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets consoles end without the last resort, which ends the process that runs the test."""
    monkeypatch.setattr("rune_tui.app.end_anyway", lambda: None)


@pytest.mark.usefixtures("ends")
@pytest.mark.parametrize(
    "keys", [("q", "q"), ("q", "enter"), ("ctrl+c", "ctrl+c"), ("ctrl+p", "ctrl+c", "ctrl+c")]
)
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
        assert not desk.console._leaving
        await desk.press("space")
        await desk.until(lambda: desk.robot.stops)
        assert desk.console.state.leaving
        await desk.press("escape")
        assert not desk.console.state.leaving
        await desk.press(*keys)
        assert desk.console._leaving
        desk.console._filing.recorder.end()()

    play(script)


@pytest.mark.usefixtures("ends")
@pytest.mark.parametrize("key", ["q", "ctrl+c"])
def test_where_nothing_is_lost_the_console_ends_at_once(play: Callable[[Script], None], key: str):
    async def script(desk: Desk) -> None:
        await desk.press(key)
        assert desk.console._leaving

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


@pytest.mark.parametrize("key", ["v", "f", "question_mark", "ctrl+p"])
def test_a_button_that_is_held_no_longer_drives_when_what_is_under_it_changes(
    play: Callable[[Script], None], key: str
):
    async def script(desk: Desk) -> None:
        await desk.pilot.mouse_down(offset=(29, 14), button=2)
        await desk.until(lambda: desk.robot.speeds[-1] > 0.0)
        await desk.press(key)
        await desk.until(lambda: desk.robot.speeds[-1] == 0.0)
        assert set(await desk.commands(3)) == {0.0}

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
        await desk.drive()
        before = len(desk.robot.speeds)
        await desk.press("v")
        assert "w" in desk.console.state.held
        await desk.until(lambda: len(desk.robot.speeds) > before)
        assert desk.robot.speeds[before] > 0.0

    play(script)


def test_a_key_drives_on_and_a_button_is_let_go_when_another_size_moves_viewports(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        console = desk.console
        console.post_message(ReleasesTold(told=True))
        await desk.until(lambda: console.state.releases_told)
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


def test_what_is_held_is_let_go_when_the_terminal_tells_of_releases_no_longer(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        console = desk.console
        console.post_message(ReleasesTold(told=True))
        await desk.until(lambda: console.state.releases_told)
        console.post_message(KeyMoved("w", "w", KeyMove.PRESS))
        await desk.until(lambda: "w" in console.state.held)
        console.post_message(ReleasesTold(told=False))
        await desk.until(lambda: not console.state.releases_told)
        assert not console.state.held

    play(script)


def test_a_stop_that_was_typed_while_the_console_was_held_up_is_a_stop_and_nothing_drives(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        await desk.until(lambda: not desk.console._stalls.deaf(time.monotonic()))
        time.sleep(STALL_S + 0.1)  # noqa: ASYNC251 - it is held up
        await desk.press("w", "space")
        await desk.until(lambda: desk.robot.stops)
        assert not desk.console.state.held
        assert [text for text in desk.told if "held up does not count" in text]

    play(script)


def test_keys_of_a_layout_that_the_terminal_does_not_tell_are_named_once(
    play: Callable[[Script], None], tmp_path: Path
):
    async def script(desk: Desk) -> None:
        assert not [text for text in desk.told if "does not tell" in text]
        path = tmp_path / "layout.xml"
        path.write_text(path.read_text().replace('"w" control', '"kp_8" control'))
        for told in (True, False, False):
            desk.console.post_message(ReleasesTold(told=told))
            await desk.until(lambda told=told: desk.console.state.releases_told is told)
            await desk.console._open(load_layout(path, desk.console._shown_layout.vocabulary))
        missed = [text for text in desk.told if "does not tell kp_8" in text]
        assert len(missed) == 1
        assert desk.told.index(missed[0]) > desk.told.index(f"opened {path}")

    play(script)


def test_an_effect_that_cannot_be_done_is_told_once_and_what_comes_after_it_is_done(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        nowhere = SendEffect(robot="nobody", definition=STOP, value=Stop(reason="the test"))
        stop = SendEffect(robot="magellan", definition=STOP, value=Stop(reason="the test"))
        desk.console._execute((nowhere, nowhere, stop))
        await desk.until(lambda: desk.robot.stops)
        assert len([text for text in desk.told if "could not be done" in text]) == 1

    play(script)


def test_an_answer_that_its_widget_cannot_take_leaves_the_console_running(
    play: Callable[[Script], None],
):
    def answer(text: str) -> tuple[Effect, ...]:
        raise ValueError(text)

    async def script(desk: Desk) -> None:
        asked = AskEffect(robot="magellan", asked="Words", text="", answer=answer)
        desk.console._execute((asked,))
        await desk.press("x", "enter")
        await desk.until(lambda: any("could not be done" in text for text in desk.told))
        await desk.drive()

    play(script)


def test_the_click_that_brings_the_terminal_to_the_front_marks_nothing(
    play: Callable[[Script], None],
):
    async def script(desk: Desk) -> None:
        desk.console.post_message(events.AppBlur())
        desk.console.post_message(events.AppFocus())
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: any("click again" in text for text in desk.told))
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
            patch.setattr(desk.console._joysticks, "tick", broken)
            await desk.until(lambda: any("could not be done" in text for text in desk.told))
            await desk.drive()
        assert len([text for text in desk.told if "could not be done" in text]) == 1

    play(script)


def test_two_enters_at_once_answer_a_question_once(play: Callable[[Script], None]):
    async def script(desk: Desk) -> None:
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: desk.console.state.ghosts)
        await desk.pilot.click(offset=(29, 14))
        await desk.until(lambda: any("victim 1 is marked" in text for text in desk.told))
        await desk.pilot.click(offset=(29, 14), button=3)
        await desk.until(lambda: isinstance(desk.console.screen, Question))
        await desk.until(lambda: desk.console.screen.focused is not None)
        line = desk.console.screen.focused
        for _ in range(3):
            line.post_message(Input.Submitted(line, "wet"))
        await desk.until(lambda: desk.robot.book.message.points[0].note == "wet")
        await desk.until(lambda: not isinstance(desk.console.screen, Question))
        assert len(desk.console.screen_stack) == 1

    play(script)
