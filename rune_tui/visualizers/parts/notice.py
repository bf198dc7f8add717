"""Words in place of a picture or over it: the missing part and the reason."""

from __future__ import annotations

import textwrap

from rune_tui.model.robot_state import LinkPhase, RobotState
from rune_tui.model.theme import Colour, Theme
from rune_tui.raster.canvas import Canvas, printable_text
from rune_tui.raster.shapes import drawing


def link_trouble(robot: RobotState, now: float) -> str:
    """The fault of the link, in one line; empty: central answers."""
    link = robot.link
    seconds = int(max(0.0, now - link.since))
    if link.phase is LinkPhase.CONNECTED:
        return ""
    if link.phase is LinkPhase.CONNECTING:
        return f"connecting to {robot.title} at {link.endpoint}: {seconds} s"
    return f"no link to {robot.title} at {link.endpoint}: retrying, {seconds} s"


def write_notice(canvas: Canvas, text: str, theme: Theme, ink: Colour | None = None) -> None:
    """Write words on a plate in the middle of a canvas, wrapped to its width.

    Rows that do not fit are dropped from the end. Without an ink it is the theme's.
    """
    margin = 1 if canvas.width >= 12 else 0
    lines = textwrap.wrap(printable_text(text), max(1, canvas.width - 2 * margin))
    lines = lines[: canvas.rows]
    if not lines:
        return
    width = min(canvas.width, max(map(len, lines)) + 2 * margin)
    column = (canvas.width - width) // 2
    row = (canvas.rows - len(lines)) // 2
    with drawing(canvas) as pen:
        pen.rectangle(column, 2 * row, column + width, 2 * (row + len(lines)), theme.panel)
    for index, line in enumerate(lines):
        canvas.text((canvas.width - len(line)) // 2, row + index, line, ink or theme.ink)
