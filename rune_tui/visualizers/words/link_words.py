"""visualizeLink: the state of the connection to the robot, and its traffic."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from typing import ClassVar

from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.vision import ImageCoding
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.display_state import DisplayState
from rune_tui.model.robot_state import LinkPhase, LinkState, PictureFlow, RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.parts.rows import GAP, TextRow, cut, flowing, wrapped
from rune_tui.visualizers.parts.severity import Severity, ink_of
from rune_tui.visualizers.parts.staleness import (
    ALARM_AFTER_S,
    Staleness,
    age_text,
    staleness,
    usual_age,
)
from rune_tui.visualizers.visualizer import PlainVisualizer

_KILO = 1000.0
_LONG_S = 120.0
_TENS = 10
"""Step of the shown latency [ms]."""
_COARSE = 5
"""Least visible coarseness."""


class Link(PlainVisualizer):
    """Words side by side: phase, ages of state and picture, losses, pictures, rates."""

    rule: ClassVar = VisualizerRule(
        meaning="the connection in words: phase, ages, losses, pictures, round trip, rates",
        others=(ROBOT_STATE.name,),
    )

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the words that fit, from the start."""
        canvas.fill(state.theme.panel)
        lines = [*flowing(_not_in_banner(robot, state), canvas.width)]
        if robot.link.detail:
            lines += [(row,) for row in wrapped(TextRow(robot.link.detail), canvas.width)]
        for index, line in enumerate(lines[: canvas.rows]):
            column = 0
            for word in line:
                text = cut(word.text, canvas.width)
                canvas.text(column, index, text, ink_of(word.severity, state.theme))
                column += len(text) + GAP

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word."""
        return tuple(_not_in_banner(robot, state)), robot.link.detail, state.theme.name


def _words(robot: RobotState, state: ConsoleState) -> Iterator[TextRow]:
    link, now = robot.link, state.now
    yield _phase(link, now)
    if not link.may_command:
        yield TextRow("may watch and stop", Severity.WARNING)
    if link.missed:
        yield TextRow(
            f"{link.missed} message{'s' if link.missed > 1 else ''} lost", Severity.WARNING
        )
    if robot.navigation is not None:
        age = robot.navigation.age(now)
        fresh = staleness(age) is Staleness.FRESH
        yield TextRow(f"state {age_text(age)} old", Severity.PLAIN if fresh else Severity.ALARM)
    if robot.picture is not None:
        age = robot.picture.age(now) + state.latency
        late = age > max(ALARM_AFTER_S, usual_age(robot.picture.value))
        text = f"PICTURE {age_text(age)} OLD" if late else f"picture {age_text(age)} old"
        yield TextRow(text, Severity.ALARM if late else Severity.PLAIN)
    if state.display is not None:
        yield from _display(state.display)
    # Counts are valid while central answers.
    connected = link.phase is LinkPhase.CONNECTED
    if connected and link.pictures is not None:
        yield from _pictures(link.pictures)
    if connected and math.isfinite(link.round_trip):
        yield TextRow(f"round trip {_KILO * link.round_trip:.0f} ms")
    if connected and math.isfinite(link.messages_per_s):
        yield TextRow(f"{link.messages_per_s:.0f} messages/s")
    if connected and math.isfinite(link.bytes_per_s):
        yield TextRow(_amount(link.bytes_per_s))


def _display(display: DisplayState) -> Iterator[TextRow]:
    """The state of the line from the console to the terminal."""
    latency = display.latency
    if math.isfinite(latency):
        late = latency > ALARM_AFTER_S
        shown = f"{_TENS * round(_KILO * latency / _TENS):.0f} ms"
        text = f"TERMINAL {shown} BEHIND" if late else f"terminal {shown} behind"
        yield TextRow(text, Severity.ALARM if late else Severity.PLAIN)
    if display.coarseness >= _COARSE:
        yield TextRow("drawn coarser for the terminal", Severity.WARNING)


def _pictures(flow: PictureFlow) -> Iterator[TextRow]:
    if flow.shrunk:
        yield TextRow("pictures made smaller for the link", Severity.WARNING)
    yield TextRow(f"{flow.per_s:.0f} pictures/s")
    kind = f"{flow.width_px}x{flow.height_px} {flow.coding.name}"
    yield TextRow(kind if flow.coding is ImageCoding.RAW else f"{kind} {flow.quality}")


def _not_in_banner(robot: RobotState, state: ConsoleState) -> Iterator[TextRow]:
    """All words that the banner does not show."""
    banner = state.banner
    said = banner.text if banner is not None and banner.robot == robot.name else ""
    return (row for row in _words(robot, state) if not said.startswith(row.text))


def _phase(link: LinkState, now: float) -> TextRow:
    seconds = max(0.0, now - link.since)
    since = f"{int(seconds)} s" if seconds < _LONG_S else age_text(seconds)
    if link.phase is LinkPhase.CONNECTED:
        return TextRow("linked", Severity.GOOD)
    if link.phase is LinkPhase.CONNECTING:
        return TextRow(f"connecting {since}", Severity.WARNING)
    return TextRow(f"LINK LOST {since}", Severity.ALARM)


def _amount(bytes_per_s: float) -> str:
    if bytes_per_s < _KILO:
        return f"{bytes_per_s:.0f} B/s"
    if bytes_per_s < _KILO**2:
        return f"{bytes_per_s / _KILO:.0f} kB/s"
    return f"{bytes_per_s / _KILO**2:.1f} MB/s"
