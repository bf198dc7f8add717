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
from rune_tui.visualizers.parts.fitting import forms_of
from rune_tui.visualizers.parts.rows import GAP, TextRow, cut, fitting_form, flowing, wrapped
from rune_tui.visualizers.parts.severity import Part, Severity, ink_of
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
        parts = _not_in_banner(robot, state)
        words = (TextRow(fitting_form(canvas.width, *forms_of(p)), p.severity) for p in parts)
        lines = [*flowing(words, canvas.width)]
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


def _words(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    link, now = robot.link, state.now
    yield _phase(link, now)
    if not link.may_command:
        yield Part("may watch and stop", 0, Severity.WARNING)
    if link.missed:
        plural = "s" if link.missed > 1 else ""
        yield Part(f"{link.missed} message{plural} lost", 0, Severity.WARNING)
    if robot.navigation is not None:
        age = robot.navigation.age(now)
        fresh = staleness(age) is Staleness.FRESH
        severity = Severity.PLAIN if fresh else Severity.ALARM
        yield Part(f"state {age_text(age)} old", 0, severity, short=f"{age_text(age)} old")
    if robot.picture is not None:
        age = robot.picture.age(now) + state.latency
        late = age > max(ALARM_AFTER_S, usual_age(robot.picture.value))
        text = f"PICTURE {age_text(age)} OLD" if late else f"picture {age_text(age)} old"
        severity = Severity.ALARM if late else Severity.PLAIN
        yield Part(text, 0, severity, short=f"pic {age_text(age)}")
    if state.display is not None:
        yield from _display(state.display)
    # Counts are valid while central answers.
    connected = link.phase is LinkPhase.CONNECTED
    if connected and link.pictures is not None:
        yield from _pictures(link.pictures)
    if connected and math.isfinite(link.round_trip):
        yield Part(f"round trip {_KILO * link.round_trip:.0f} ms", 0)
    if connected and math.isfinite(link.messages_per_s):
        yield Part(f"{link.messages_per_s:.0f} messages/s", 0)
    if connected and math.isfinite(link.bytes_per_s):
        yield Part(_amount(link.bytes_per_s), 0)


def _display(display: DisplayState) -> Iterator[Part]:
    """The state of the line from the console to the terminal."""
    latency = display.latency
    if math.isfinite(latency):
        late = latency > ALARM_AFTER_S
        shown = f"{_TENS * round(_KILO * latency / _TENS):.0f} ms"
        text = f"TERMINAL {shown} BEHIND" if late else f"terminal {shown} behind"
        yield Part(text, 0, Severity.ALARM if late else Severity.PLAIN)
    if display.coarseness >= _COARSE:
        yield Part("drawn coarser for the terminal", 0, Severity.WARNING)


def _pictures(flow: PictureFlow) -> Iterator[Part]:
    if flow.shrunk:
        yield Part("pictures made smaller for the link", 0, Severity.WARNING)
    yield Part(f"{flow.per_s:.0f} pictures/s", 0)
    kind = f"{flow.width_px}x{flow.height_px} {flow.coding.name}"
    yield Part(kind if flow.coding is ImageCoding.RAW else f"{kind} {flow.quality}", 0)


def _not_in_banner(robot: RobotState, state: ConsoleState) -> Iterator[Part]:
    """All words that the banner does not show."""
    banner = state.banner
    said = banner.text if banner is not None and banner.robot == robot.name else ""
    return (part for part in _words(robot, state) if not said.startswith(part.text))


def _phase(link: LinkState, now: float) -> Part:
    seconds = max(0.0, now - link.since)
    since = f"{int(seconds)} s" if seconds < _LONG_S else age_text(seconds)
    if link.phase is LinkPhase.CONNECTED:
        return Part("linked", 0, Severity.GOOD)
    if link.phase is LinkPhase.CONNECTING:
        return Part(f"connecting {since}", 0, Severity.WARNING)
    return Part(f"LINK LOST {since}", 0, Severity.ALARM, short=f"LOST {since}")


def _amount(bytes_per_s: float) -> str:
    if bytes_per_s < _KILO:
        return f"{bytes_per_s:.0f} B/s"
    if bytes_per_s < _KILO**2:
        return f"{bytes_per_s / _KILO:.0f} kB/s"
    return f"{bytes_per_s / _KILO**2:.1f} MB/s"
