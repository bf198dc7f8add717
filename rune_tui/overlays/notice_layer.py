"""Words over the view: a question, a trouble, a prompt, or what happened just now.

| what there is | words | until |
| --- | --- | --- |
| a question whether to end | the question, on a plate as wide as the view | it is answered |
| a trouble of the console | the trouble | it is over |
| a joystick that waits for the operator | what to do with it | it is done |
| a notice that neither the banner nor an event log shows | the notice | it is a few seconds old |

The first of them counts.
"""

from __future__ import annotations

from rune_tui.compositor.blend import Layer
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.leaving import question
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.notice import write_notice
from rune_tui.visualizers.words.troubles import REPORT_S

_MOST_ROWS = 4
"""Height of the plate [cells]."""


class NoticeLayer:
    """Draws the words, and again only if they would look different.

    Attributes:
        layers: The words; none while there are none.
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
            top: The first row that is free [cells].
            zpos: How near to the eye they are.
            state: What is known.
            page_rows: Rows down to the end of a page over the view [cells].
            logged: Whether an event log is shown.

        Returns:
            Whether they changed.
        """
        columns, rows = size[0], min(_MOST_ROWS, size[1])
        words = question(state.leaving) or state.trouble or _prompt(state)
        notice = None if words or logged else _passing(state)
        if notice is not None:
            words = f"{state.title(notice.robot)}: " if notice.robot else ""
            words += notice.text
            # A page says at its upper edge what its keys do.
            top = max(0, page_rows - rows) if state.paged else top
        asks = bool(state.leaving)
        seen = (columns, rows, top, zpos, state.theme.name, asks, words)
        look: tuple[object, ...] = seen if words else ()
        if look == self._look:
            return False
        self._look, self.layers = look, ()
        if words:
            canvas = Canvas.blank(columns, 2 * rows)
            if asks:
                canvas.fill(state.theme.panel)  # the question hides what is below it
            write_notice(canvas, words, state.theme, state.theme.warning if asks else None)
            self.layers = (Layer(canvas=canvas, x=0, y=2 * top, zpos=zpos, urgency=Urgency.ALARM),)
        return True


def notice_only(text: str, columns: int, rows: int, theme: Theme) -> Layer:
    """Words in the middle of a view of this size [cells] that shows nothing else."""
    canvas = Canvas.blank(columns, 2 * rows)
    write_notice(canvas, text, theme)
    return Layer(canvas=canvas, x=0, y=0)


def _prompt(state: ConsoleState) -> str:
    """What the operator is asked to do with a joystick now."""
    return next((each.prompt for each in state.joysticks.values() if each.prompt), "")


def _passing(state: ConsoleState) -> Notice | None:
    """What happened just now, where neither the banner nor a page of messages shows it."""
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
