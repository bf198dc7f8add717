"""Messages of the driver that Textual does not have."""

from __future__ import annotations

from textual import events
from textual.message import Message

from rune_tui.terminal.input_stream import CursorReport, KeyMove


class UrgentReport(Message):
    """A report that the app's method handles without Textual's queue, which would delay it.

    It keeps its place among all messages of the driver.
    """


class FrameAnswered(UrgentReport):
    """The terminal answers the question after a frame.

    Attributes:
        report: Its answer.
        when: Time of reading [s].
    """

    def __init__(self, report: CursorReport, when: float) -> None:
        """Prepare."""
        super().__init__()
        self.report = report
        self.when = when


class KeyMoved(UrgentReport):
    """A press, repeat or release of a key, on a terminal that reports releases.

    Attributes:
        key: Textual's name of it.
        character: The character it types, if any.
        move: Press, repeat or release.
        keypad: Its name on the keypad; else empty.
        base: What it types on a US keyboard; empty: the same, or not reported.
    """

    def __init__(
        self, key: str, character: str | None, move: KeyMove, keypad: str = "", base: str = ""
    ) -> None:
        """Prepare."""
        super().__init__()
        self.key = key
        self.character = character
        self.move = move
        self.keypad = keypad
        self.base = base


class KeysDropped(Message):
    """Input was dropped because it was not typed key by key; other keys may follow it.

    Attributes:
        keys: The dropped keys; empty: they are not known.
        pasted: Whether they came as fast as pasted text.
    """

    def __init__(self, keys: tuple[events.Key, ...] = (), *, pasted: bool = False) -> None:
        """Prepare."""
        super().__init__()
        self.keys = keys
        self.pasted = pasted

    @property
    def text(self) -> str:
        """The text that they type."""
        return "".join(key.character or "" for key in self.keys if key.is_printable)


class ReleasesReported(Message):
    """The terminal reports releases of keys, or does not.

    Attributes:
        reported: Whether it does.
    """

    def __init__(self, *, reported: bool) -> None:
        """Prepare."""
        super().__init__()
        self.reported = reported
