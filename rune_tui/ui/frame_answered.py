"""What the driver tells the console of the terminal's answers."""

from __future__ import annotations

from textual.message import Message

from rune_tui.terminal.input_stream import CursorReport


class FrameAnswered(Message):
    """The terminal has come to the question that followed a frame.

    Attributes:
        report: What it says.
        when: When it was read [s].
    """

    def __init__(self, report: CursorReport, when: float) -> None:
        """Prepare to tell of a report."""
        super().__init__()
        self.report = report
        self.when = when
