"""What operators have put on file: recordings, pictures of the screen, marks, calibrations."""

from __future__ import annotations

import asyncio
import datetime
from collections.abc import Callable, Collection, Coroutine
from typing import Any

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.files import user_files
from rune_tui.files.recorder import Recorder
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import ExportEffect, RecordEffect, ScreenshotEffect
from rune_tui.model.robot_state import RobotState


class Filing:
    """Writes files without holding up the robots' commands, and tells what became of them.

    Attributes:
        recorder: What is being recorded.
    """

    def __init__(
        self,
        links: RobotLinks,
        run: Callable[[Coroutine[Any, Any, None]], object],
        report: Callable[[user_files.Outcome], None],
    ) -> None:
        """Prepare; nothing is recorded.

        Args:
            links: What comes and goes there is recorded.
            run: Runs a coroutine beside what the console does.
            report: Tells the operator.
        """
        self.recorder = Recorder(links)
        self._run, self._report = run, report

    def do(
        self,
        effect: RecordEffect | ScreenshotEffect | ExportEffect,
        layout: LayoutSpec,
        state: ConsoleState,
        cells: Cells | None,
        pictures: Collection[SeenPicture],
    ) -> None:
        """Write what a widget asks for.

        Args:
            effect: What that is.
            layout: What is shown.
            state: What the console knows.
            cells: What the operator sees; None before the first frame.
            pictures: Those in it that have more pixels than the cells.
        """
        match effect:
            case RecordEffect():
                self.record_or_not(layout, state.operator)
            case ScreenshotEffect() if cells is not None:
                self.keep_screen(cells, pictures)
            case ExportEffect(robot=name):
                self.keep_marks(state.robots[name])

    def record_or_not(self, layout: LayoutSpec, operator: str) -> None:
        """Begin to record, or end it."""
        if self.recorder.path:
            self._write(self.recorder.end())
        else:
            self._report(self.recorder.begin(layout, operator))

    def keep_screen(self, cells: Cells, pictures: Collection[SeenPicture]) -> None:
        """Write a picture of what the operator sees."""
        now = _now()
        self._write(lambda: user_files.write_screenshot(cells, pictures, now))

    def keep_marks(self, robot: RobotState) -> None:
        """Write what is marked."""
        now = _now()
        self._write(lambda: user_files.write_marks(robot, now))

    def keep_calibrations(self, store: CalibrationStore) -> None:
        """Write what is known of joysticks."""
        self._write(lambda: user_files.write_calibrations(store))

    def _write(self, job: Callable[[], user_files.Outcome]) -> None:
        async def written() -> None:
            self._report(await asyncio.to_thread(job))

        self._run(written())


def _now() -> datetime.datetime:
    return datetime.datetime.now().astimezone()
