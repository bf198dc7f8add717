"""Handler names of layouts and the widgets behind them."""

from __future__ import annotations

from collections.abc import Mapping

from rune_tui.widgets.ptz import AdjustPan, AdjustTilt, AdjustZoom, HomePTZ
from rune_tui.widgets.quit import Quit
from rune_tui.widgets.speed import SetSpeed, StopRobot
from rune_tui.widgets.widget import Widget

WIDGETS: Mapping[str, type[Widget]] = {
    "widgetSetSpeed": SetSpeed,
    "widgetStop": StopRobot,
    "widgetAdjustPan": AdjustPan,
    "widgetAdjustTilt": AdjustTilt,
    "widgetAdjustZoom": AdjustZoom,
    "widgetHomePTZ": HomePTZ,
    "widgetQuit": Quit,
}
