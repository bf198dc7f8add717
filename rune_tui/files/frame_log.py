"""Records each frame with all that it was drawn from, so that it can be drawn again."""

from __future__ import annotations

import dataclasses
import math
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from hub.values import dataclass
from rune_tui.compositor.cells import Cells
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.display_state import DisplayState
from rune_tui.model.own_records import (
    RUNE_FRAME,
    RUNE_LINK,
    RUNE_SELECT,
    RUNE_SHOWN,
    RUNE_STATE,
    RUNE_TERMINAL,
    FramePicture,
    FrameRecord,
    FrameRobot,
    LackRecord,
    LinkRecord,
    Selection,
    SelectRecord,
    ShownRecord,
    SlowDrawing,
    StateRecord,
    TerminalRecord,
    UnfitRecord,
)
from rune_tui.model.plain_values import to_json
from rune_tui.model.robot_state import LinkState, RobotState

if TYPE_CHECKING:
    from rune_tui.files.console_recording import ConsoleRecording

CONSOLE = "console"
"""The first part of topics of the console itself."""
OTHERWISE = frozenset(
    {"now", "clock", "robots", "display", "places", "attention", "rows", "banner", "inputs"}
    | {"drawn", "stop_shown"}
)
"""Fields of the state that frames have, or that follow from the layout and the other fields."""
_RECORDED = tuple(
    each.name for each in dataclasses.fields(ConsoleState) if each.name not in OTHERWISE
)
_MOST_UNANSWERED = 64
_NO_DISPLAY = DisplayState(latency=math.nan, frames_per_s=0.0, bytes_per_s=0.0, coarseness=0)


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnFrame:
    """What the view made of a state.

    Attributes:
        columns: Its width [cells].
        rows: Its height [cells].
        arranged: How often it has placed the viewports.
        cells: The cells; None: nothing changed.
        slow: Processor time of slow drawings [s], by viewport.
    """

    columns: int
    rows: int
    arranged: int
    cells: Cells | None
    slow: Mapping[str, float]


class FrameLog:
    """Writes frames into one recording."""

    def __init__(
        self, recording: ConsoleRecording, topics: Mapping[str, str], terminal: TerminalRecord
    ) -> None:
        """Begin.

        Args:
            recording: The recording.
            topics: The name of each robot in topics, by its name in the layout.
            terminal: The terminal; its size comes with the frames.
        """
        self._recording = recording
        self._topics = topics
        self._terminal = terminal
        self._count = 0
        self._known: dict[str, object] = {}
        self._links: dict[str, tuple[LinkState, int]] = {}
        self._robots: dict[str, tuple[RobotState, FrameRobot]] = {}
        self._selected = {record.what: record for record in _selections(ConsoleState(now=0.0))}
        self._handed: OrderedDict[float, tuple[int, float]] = OrderedDict()

    def frame(self, state: ConsoleState, drawn: DrawnFrame) -> None:
        """Record a frame, and what changed since the frame before."""
        self._note_terminal(state, drawn)
        self._note_state(state)
        self._note_selection(state)
        self._count += 1
        record = FrameRecord(
            number=self._count,
            now=state.now,
            clock=state.clock,
            columns=drawn.columns,
            rows=drawn.rows,
            arranged=drawn.arranged,
            drawn=drawn.cells is not None,
            crc32=drawn.cells.checksum if drawn.cells is not None else 0,
            display=state.display or _NO_DISPLAY,
            robots=tuple(self._robot(robot, state.now) for robot in state.robots.values()),
            slow=tuple(
                SlowDrawing(viewport=name, took_s=took) for name, took in drawn.slow.items()
            ),
        )
        self._recording.add(CONSOLE, RUNE_FRAME, record, state.now, self._count)

    def handed(self, sent: float, now: float, *, answers: bool) -> None:
        """Note that the newest frame goes to the terminal.

        Args:
            sent: The time by which the terminal's answer names it [s].
            now: The time [s].
            answers: Whether the terminal answers.
        """
        if not answers:
            self._note_shown(self._count, now, math.nan)
            return
        self._handed[sent] = self._count, now
        while len(self._handed) > _MOST_UNANSWERED:
            self._handed.popitem(last=False)

    def answered(self, sent: float, now: float) -> None:
        """Note that the terminal shows the frame that was sent at a time [s]."""
        if sent in self._handed:
            number, handed = self._handed.pop(sent)
            self._note_shown(number, handed, now)

    def _note_shown(self, number: int, handed: float, answered: float) -> None:
        record = ShownRecord(number=number, handed=handed, answered=answered)
        self._recording.add(CONSOLE, RUNE_SHOWN, record, handed)

    def _note_terminal(self, state: ConsoleState, drawn: DrawnFrame) -> None:
        if (drawn.columns, drawn.rows) != (self._terminal.columns, self._terminal.rows):
            self._terminal = dataclasses.replace(
                self._terminal, columns=drawn.columns, rows=drawn.rows, theme=state.theme.name
            )
            self._recording.add(CONSOLE, RUNE_TERMINAL, self._terminal, state.now)

    def _note_state(self, state: ConsoleState) -> None:
        known = self._known
        for name in _RECORDED:
            value = getattr(state, name)
            if name in known and (value is known[name] or value == known[name]):
                continue
            known[name] = value
            record = StateRecord(field=name, value=to_json(value))
            self._recording.add(CONSOLE, RUNE_STATE, record, state.now, part=name)

    def _note_selection(self, state: ConsoleState) -> None:
        for record in _selections(state):
            if self._selected.get(record.what) != record:
                self._selected[record.what] = record
                self._recording.add(CONSOLE, RUNE_SELECT, record, state.now)

    def _robot(self, robot: RobotState, now: float) -> FrameRobot:
        known = self._robots.get(robot.name)
        if known is not None and known[0] is robot:
            return known[1]
        messages, diagnostics = robot.messages.values(), robot.diagnostics
        record = FrameRobot(
            robot=robot.name,
            link=self._link(robot, now),
            map=robot.map.number if robot.map is not None else 0,
            messages=np.array([each.number for each in messages], np.uint32),
            diagnostics=np.array([each.number for each in diagnostics.values()], np.uint32),
            publishers=np.array(list(diagnostics), np.uint32),
            pictures=tuple(
                FramePicture(camera=name, number=each.number, interval_s=each.value.interval_s)
                for name, each in robot.all_pictures.items()
            ),
        )
        self._robots[robot.name] = robot, record
        return record

    def _link(self, robot: RobotState, now: float) -> int:
        """The number of the record of a robot's link; writes it if it is new."""
        link, number = self._links.get(robot.name, (None, 0))
        if link is not None and (link is robot.link or link == robot.link):
            return number
        number += 1
        self._links[robot.name] = robot.link, number
        record = link_record(robot, self._topics.get(robot.name, robot.name), number)
        self._recording.add(CONSOLE, RUNE_LINK, record, now, number)
        return number


def _selections(state: ConsoleState) -> Iterator[SelectRecord]:
    """What the operator looks at."""
    peeked, full = state.peeked, state.full
    yield SelectRecord(what=Selection.CHOSEN, robot=state.chosen)
    yield SelectRecord(what=Selection.PEEKED, robot=peeked, on=bool(peeked))
    yield SelectRecord(what=Selection.FULL, viewport=full, on=bool(full))
    yield SelectRecord(what=Selection.HELP, on=state.help)
    yield SelectRecord(what=Selection.LOG, on=state.log)


def link_record(robot: RobotState, topic: str, number: int) -> LinkRecord:
    """The record of a robot's link."""
    link = robot.link
    same = {name: getattr(link, name) for name in SAME}
    return LinkRecord(
        robot=robot.name,
        topic=topic,
        number=number,
        phase=link.phase.name,
        console=link.number,
        lacking=tuple(_lacks(link)),
        unfit=tuple(UnfitRecord(message=name, why=why) for name, why in link.unfit.items()),
        **same,
    )


SAME = tuple(
    sorted(
        {each.name for each in dataclasses.fields(LinkState)}
        & {each.name for each in dataclasses.fields(LinkRecord)}
        - {"phase", "number", "lacking", "unfit"}
    )
)
"""Fields that are the same in a `LinkState` and a `LinkRecord`."""


def _lacks(link: LinkState) -> Iterator[LackRecord]:
    for name, lack in link.lacking.items():
        yield LackRecord(capability=name, kind=lack.kind.name, why=lack.why)
