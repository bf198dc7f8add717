"""Words over the view: a question, a trouble, a prompt or a notice; the first that applies.

| case | words | until |
| --- | --- | --- |
| a question whether to end | the question, on a plate as wide as the view | the answer |
| a trouble of the console | the trouble | its end |
| a joystick that waits for the operator | the prompt | the operator's action |
| a notice that neither the banner nor an event log shows | the notice | a few seconds later |

While a page is open, they stand on its last row, which it leaves to them.
"""

from __future__ import annotations

from rune_tui.compositor.blend import Layer
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.leaving import question
from rune_tui.model.theme import Theme
from rune_tui.overlays.page_layer import FOOT_ROWS
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.parts.rows import cut
from rune_tui.visualizers.words.troubles import REPORT_S

_MOST_ROWS = 4
"""Height of the plate [cells]."""


class NoticeLayer:
    """Draws the words when they change.

    Attributes:
        layers: The words; empty without words.
    """

    def __init__(self) -> None:
        self._look: tuple[object, ...] = ()
        self.layers: tuple[Layer, ...] = ()

    def refresh(
        self,
        size: tuple[int, int],
        top: int,
        zpos: int,
        state: ConsoleState,
        *,
        page_rows: int,
        logged: bool,
    ) -> bool:
        """Bring `layers` up to date.

        Args:
            size: Columns and rows of the terminal [cells].
            top: The first free row [cells].
            zpos: Depth order of the layer.
            state: The console's state.
            page_rows: Rows down to the end of a page over the view [cells].
            logged: Whether an event log is shown.

        Returns:
            Whether they changed.
        """
        columns, rows = size[0], min(FOOT_ROWS if state.paged else _MOST_ROWS, size[1])
        words = question(state.leaving) or state.trouble or _prompt(state)
        notice = None if words or logged else _recent_notice(state)
        if notice is not None:
            words = f"{state.title(notice.robot)}: " if notice.robot else ""
            words += notice.text
        if state.paged:  # a page leaves its last row to them
            top, words = max(0, page_rows - rows), cut(words, columns - 2)
        asks = bool(state.leaving)
        seen = (columns, rows, top, zpos, state.theme.name, asks, words)
        look: tuple[object, ...] = seen if words else ()
        if look == self._look:
            return False
        self._look, self.layers = look, ()
        if words:
            canvas = Canvas.blank(columns, 2 * rows)
            if asks:
                canvas.fill(state.theme.panel)  # the question hides the view below
            write_notice(canvas, words, state.theme, state.theme.warning if asks else None)
            self.layers = (Layer(canvas=canvas, x=0, y=2 * top, zpos=zpos, urgency=Urgency.ALARM),)
        return True


def notice_only(text: str, columns: int, rows: int, theme: Theme) -> Layer:
    """A view of this size [cells] with only a text in its middle."""
    canvas = Canvas.blank(columns, 2 * rows)
    write_notice(canvas, text, theme)
    return Layer(canvas=canvas, x=0, y=0)


def _prompt(state: ConsoleState) -> str:
    """The newest prompt of a joystick; empty if none waits."""
    return next((each.prompt for each in state.joysticks.values() if each.prompt), "")


def _recent_notice(state: ConsoleState) -> Notice | None:
    """The newest notice, unless it is old, quiet, or shown by the banner or a page."""
    newest = state.notices[-1] if state.notices else None
    if (
        newest is None
        or state.log
        or newest.quiet
        or newest.alarm
        or state.now - newest.when > REPORT_S
    ):
        return None
    return newest
