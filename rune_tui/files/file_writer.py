"""Writes files for the operator: recordings, screenshots, marks, calibrations."""

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


class FileWriter:
    """Writes files in threads, so that commands are not delayed, and reports the outcome.

    Attributes:
        recorder: The running recording, if any.
        broken: Whether the disk ended a recording.
    """

    def __init__(
        self,
        links: RobotLinks,
        run: Callable[[Coroutine[Any, Any, None]], object],
        report: Callable[[user_files.Outcome], None],
    ) -> None:
        """Prepare.

        Args:
            links: Links to the robots; recordings contain their messages.
            run: Runs a coroutine in the background.
            report: Shows an outcome to the operator.
        """
        self.recorder = Recorder(links)
        self.broken = False
        self._run, self._report = run, report

    def do(
        self,
        effect: RecordEffect | ScreenshotEffect | ExportEffect,
        layout: LayoutSpec,
        state: ConsoleState,
        cells: Cells | None,
        pictures: Collection[SeenPicture],
    ) -> None:
        """Execute an effect that writes files.

        Args:
            effect: The effect.
            layout: The open layout.
            state: The console's state.
            cells: The newest view; None before the first frame.
            pictures: Pictures in the view with more pixels than the cells.
        """
        match effect:
            case RecordEffect():
                self.toggle_recording(layout, state.operator)
            case ScreenshotEffect() if cells is not None:
                self.write_screenshot(cells, pictures)
            case ExportEffect(robot=name):
                self.write_marks(state.robots[name])

    def toggle_recording(self, layout: LayoutSpec, operator: str) -> None:
        """Begin a recording, or end the running one."""
        if self.recorder.path:
            self._write(self.recorder.end())
        else:
            self._report(self.recorder.begin(layout, operator))

    def look(self) -> None:
        """Report a recording that the disk ended, and close it."""
        if self.recorder.fault:
            self.broken = True
            self._write(self.recorder.end())

    def write_screenshot(self, cells: Cells, pictures: Collection[SeenPicture]) -> None:
        """Write a picture of the view."""
        now = _now()
        self._write(lambda: user_files.write_screenshot(cells, pictures, now))

    def write_marks(self, robot: RobotState) -> None:
        """Write a robot's marks."""
        now = _now()
        self._write(lambda: user_files.write_marks(robot, now))

    def write_calibrations(self, store: CalibrationStore) -> None:
        """Write the calibrations of joysticks."""
        self._write(lambda: user_files.write_calibrations(store))

    def _write(self, job: Callable[[], user_files.Outcome]) -> None:
        async def written() -> None:
            self._report(await asyncio.to_thread(job))

        self._run(written())


def _now() -> datetime.datetime:
    return datetime.datetime.now().astimezone()
