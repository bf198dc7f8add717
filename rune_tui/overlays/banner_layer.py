"""The banner at the upper edge: the most severe alarm, or a robot that moves by itself."""

from __future__ import annotations

import sys

from rune_tui.compositor.blend import Layer
from rune_tui.layout.placing import Area
from rune_tui.model.console_state import Banner, ConsoleState
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.fitting import clauses
from rune_tui.visualizers.parts.rows import fitting_form

TALL_ROWS = 30
"""Least height of a terminal for a banner of several rows [cells]."""
BANNER_ROWS = 3
"""Height of the banner there [cells]."""


class BannerLayer:
    """Draws the banner when it changes."""

    def __init__(self) -> None:
        self._look: tuple[object, ...] = ()
        self.layers: tuple[Layer, ...] = ()

    @property
    def end(self) -> int:
        """The row below the banner [cells]; 0: there is none."""
        return sum(each.y // 2 + each.canvas.rows for each in self.layers)

    def refresh(self, place: Area, rows: int, state: ConsoleState, *, listed: bool = False) -> bool:
        """Bring `layers` up to date.

        Args:
            place: Its first row and its columns.
            rows: Height of the terminal [cells].
            state: The console's state.
            listed: Whether another pane lists the alarms of all robots. Then those of robots that
                the operator does not look at take one row only: they cover the picture to drive by.

        Returns:
            Whether they changed.
        """
        prefix = state.title(state.banner.robot) if state.banner else ""
        aside = listed and state.banner is not None and state.banner.robot not in {"", state.seen}
        seen = (
            place,
            rows,
            state.theme.name,
            len(state.robots),
            state.banner,
            prefix,
            aside,
        )
        look: tuple[object, ...] = seen if state.banner is not None else ()
        if look == self._look:
            return False
        self._look = look
        self.layers = ()
        if state.banner is not None:
            tall = rows >= TALL_ROWS and not (state.banner.calm or aside)
            canvas = Canvas.blank(place.width, 2 * (BANNER_ROWS if tall else 1))
            _draw(canvas, state.banner, state)
            nearest = sys.maxsize - 1
            layer = Layer(canvas=canvas, x=place.x, y=place.y, zpos=nearest, urgency=Urgency.ALARM)
            self.layers = (layer,)
        return True


def _draw(canvas: Canvas, banner: Banner, state: ConsoleState) -> None:
    theme = state.theme
    plate, ink = (theme.accent, theme.ground) if banner.calm else (theme.alarm, theme.on_alarm)
    canvas.fill(plate)
    prefix = f"{state.title(banner.robot)}: " if banner.robot and len(state.robots) > 1 else ""
    more = f"+{banner.more}" if banner.more else ""
    room = canvas.width - 2 - (len(more) + 2 if more else 0)
    text = f"{prefix}{banner.text}"
    full = " · ".join(filter(None, (text, banner.advice)))
    forms = (full, *banner_forms(text)[2:]) if banner.calm else banner_forms(text)
    words = fitting_form(room, *forms)
    row = canvas.rows // 2
    canvas.text(max(1, (canvas.width - len(words)) // 2), row, words, ink)
    canvas.text(canvas.width - 1 - len(more), row, more, ink)


def banner_forms(text: str) -> tuple[str, ...]:
    """Forms of a text, longest first: with signs, without signs, then with fewer clauses."""
    return (f"!!  {text}  !!", f"!! {text}", *clauses(text))
