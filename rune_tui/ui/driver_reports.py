"""What the driver tells the console of the terminal, beyond what Textual knows."""

from __future__ import annotations

from textual.message import Message

from rune_tui.terminal.input_stream import CursorReport, KeyMove


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


class KeyMoved(Message):
    """A key went down, repeats or went up, on a terminal that tells one from the other.

    Attributes:
        key: What Textual calls it.
        character: The character it types, if any.
        move: What it did.
        keypad: Its own name if it is one of the keypad, else empty.
    """

    def __init__(self, key: str, character: str | None, move: KeyMove, keypad: str = "") -> None:
        """Prepare to tell of a key."""
        super().__init__()
        self.key = key
        self.character = character
        self.move = move
        self.keypad = keypad


class ReleasesReported(Message):
    """The terminal says whether it tells when keys go up.

    Attributes:
        reported: Whether it does.
    """

    def __init__(self, *, reported: bool) -> None:
        """Prepare to tell of it."""
        super().__init__()
        self.reported = reported
