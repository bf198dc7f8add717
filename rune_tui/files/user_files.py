"""Files on the operator's machine, and outcomes of the operator's orders."""

from __future__ import annotations

import datetime
import importlib.metadata
import logging
import platform
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

import platformdirs

from hub.command_line import DISTRIBUTION
from hub.files import replace
from hub.gcm.mapping import INTEREST_POINTS
from hub.ipc.definition import Keep
from hub.values import dataclass
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.seen_pictures import SeenPicture
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.effects import (
    ControlEffect,
    MissionEffect,
    OrderEffect,
    RobotRecordEffect,
    SendEffect,
)
from rune_tui.model.lacks import why_unsupported
from rune_tui.model.robot_state import LinkPhase, RobotState

if TYPE_CHECKING:
    from rune_tui.files.console_recording import ConsoleRecording

_logger = logging.getLogger(__name__)

NO_LZ4 = "recording needs lz4; install it with pip install 'robot-user-nexus[record]'"
_FOLDER = "Rune"
_MOST_AT_ONCE = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """The outcome of an order.

    Attributes:
        text: One sentence for the operator.
        alarm: Whether the order failed.
        robot: Its robot; empty: the console itself.
        routine: Whether it only confirms the order.
    """

    text: str
    alarm: bool = False
    robot: str = ""
    routine: bool = False


def undelivered(effect: OrderEffect, robot: RobotState) -> Outcome | None:
    """Why an order has no effect now; None if it has, or if the next one follows soon."""
    if isinstance(effect, ControlEffect):
        what = "request for control"
    elif isinstance(effect, MissionEffect):
        what = "mission"
    elif isinstance(effect, RobotRecordEffect):
        what = "order to record"
    elif effect.definition.keep is Keep.ALL:
        what = effect.definition.name.removeprefix("GCM_").replace("_", " ").lower()
    else:
        return None
    may_send = robot.link.may_command
    if isinstance(effect, SendEffect):
        may_send = robot.link.may_send(effect.definition.name)
    if not may_send:
        text = f"{what} not sent: your key may watch and stop it, not drive it"
    elif robot.link.phase is not LinkPhase.CONNECTED:
        text = f"{what} not sent: there is no link"
    elif isinstance(effect, SendEffect) and (why := why_unsupported(robot, effect.definition.name)):
        text = f"{what} has no effect: {why}"
    else:
        return None
    return Outcome(text=text, alarm=True, robot=robot.name)


def write_screenshot(
    cells: Cells, pictures: Collection[SeenPicture], now: datetime.datetime
) -> Outcome:
    """Write the view into the user's pictures folder, as PNG and as text."""
    from rune_tui.compositor.picture import PictureFile

    base = platformdirs.user_pictures_path() / _FOLDER / f"rune-{now:%Y%m%d-%H%M%S}"
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        for suffix in (".png", ".txt"):
            file = PictureFile(base.with_suffix(suffix))
            file.write(file.draw(cells, pictures))
    except OSError as error:
        return _not_written("screenshot", error)
    return Outcome(text=f"the screenshot is {base}.png and .txt", routine=True)


def write_marks(robot: RobotState, now: datetime.datetime) -> Outcome:
    """Write a robot's marks into the user's documents folder: CSV, GeoJSON and a page."""
    from rune_tui.export.points import csv_table, geojson
    from rune_tui.export.report import html_page

    newest = robot.newest(INTEREST_POINTS)
    if newest is None:
        text = "marks not written: the robot has not reported its marks"
        return Outcome(text=text, alarm=True, robot=robot.name)
    points = newest.value.points
    if not points:
        return Outcome(text="nothing is marked on its map", robot=robot.name)
    grid = robot.map.value if robot.map is not None else None
    files = {
        "csv": csv_table(points),
        "geojson": geojson(points, robot.title),
        "html": html_page(robot.title, points, grid, f"{now:%Y-%m-%d %H:%M}"),
    }
    folder = platformdirs.user_documents_path() / _FOLDER
    base = folder / f"{_as_file_name(robot.title)}-{now:%Y%m%d-%H%M%S}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for suffix, text in files.items():
            replace(Path(f"{base}.{suffix}"), text.encode(), sync=False)
    except OSError as error:
        return _not_written("marks", error)
    text = f"the marks ({len(points)}) are in {base}.csv, .geojson and .html"
    return Outcome(text=text, robot=robot.name, routine=True)


def write_calibrations(store: CalibrationStore) -> Outcome:
    """Write the calibrations of joysticks into the user's configuration folder."""
    try:
        store.save()
    except OSError as error:
        return _not_written("the calibration", error)
    return Outcome(text=f"the calibration is in {store.path}", routine=True)


def begin_recording(
    layout: LayoutSpec, operator: str, now: datetime.datetime, folder: Path | None = None
) -> tuple[ConsoleRecording | None, Outcome]:
    """Begin a recording; None, and the reason, if that fails.

    Args:
        layout: The open layout.
        operator: The operator's name.
        now: The time for the file's name.
        folder: Its folder; None: in the user's documents.
    """
    try:
        from rune_tui.files.console_recording import ConsoleRecording
    except ModuleNotFoundError:
        return None, Outcome(text=NO_LZ4, alarm=True)
    folder = folder or platformdirs.user_documents_path() / _FOLDER
    name = f"run{layout.run_number}-{now:%Y%m%d-%H%M%S}"
    about = {
        "layout": layout.path,
        "run": str(layout.run_number),
        "operator": operator,
        "host": platform.node(),
        "version": importlib.metadata.version(DISTRIBUTION),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = _free(folder, name, ".mcap")
        recording = ConsoleRecording(path, about)
    except OSError as error:
        return None, _not_written("the recording", error)
    return recording, Outcome(text=f"recording into {path}", routine=True)


def _free(folder: Path, name: str, suffix: str) -> Path:
    """A free file name: two files can begin in one second."""
    numbered = (f"{name}-{number}" for number in range(2, _MOST_AT_ONCE))
    paths = [folder / f"{each}{suffix}" for each in (name, *numbered)]
    return next((path for path in paths if not path.exists()), paths[0])


def end_recording(recording: ConsoleRecording, patience: float = 60.0) -> Outcome:
    """End a recording; returns the outcome after at most this time [s]."""
    fault = recording.close(patience)
    state = recording.state
    text = f"{state.messages} messages are recorded in {recording.path}"
    if fault := fault or state.fault:
        return Outcome(text=f"{text}; then it ended: {fault}", alarm=True)
    lost = sum(state.lost.values())
    if lost:
        text += f"; {lost} were left out, as the disk was too slow"
    return Outcome(text=text, alarm=lost > 0, routine=True)


def _not_written(what: str, error: OSError) -> Outcome:
    _logger.warning("%s not written: %s", what, error)
    return Outcome(text=f"{what} not written: {error.strerror or error}", alarm=True)


def _as_file_name(name: str) -> str:
    return "".join(letter if letter.isalnum() else "-" for letter in name)[:64] or "robot"
