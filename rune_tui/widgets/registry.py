"""Handler names of layouts and the widgets behind them."""

from __future__ import annotations

from collections.abc import Mapping

from rune_tui.widgets.autopilot import AutopilotWidget, ModeWidget
from rune_tui.widgets.control import (
    DenyControl,
    GrantControl,
    ReleaseControl,
    TakeControl,
    TakeOver,
)
from rune_tui.widgets.marked import CorrectLandmark, EditMark, ExportMarks, RemoveMark, UndoMark
from rune_tui.widgets.marks import SetLandmark, SetVictim
from rune_tui.widgets.mission import Mission
from rune_tui.widgets.orders import Autonomy, GoTo, Safety
from rune_tui.widgets.ptz import AdjustPan, AdjustPanTilt, AdjustTilt, AdjustZoom, HomePTZ
from rune_tui.widgets.recording import RobotRecordWidget
from rune_tui.widgets.seeing import (
    ChooseCameraWidget,
    SetImageQuality,
    SetImageRequest,
    ToggleNightMode,
)
from rune_tui.widgets.session import Calibrate, NextLayout, Quit, RecordWidget, Screenshot
from rune_tui.widgets.showing import (
    FullScreen,
    Help,
    Messages,
    ShowViewportWidget,
    ThemeWidget,
    ZoomMap,
)
from rune_tui.widgets.speed import SetSpeed, StopRobot
from rune_tui.widgets.speed_limit import SpeedLimit
from rune_tui.widgets.team import ChooseRobotWidget, NextAlarm, PeekWidget
from rune_tui.widgets.vehicle import (
    ArmWidget,
    DisarmWidget,
    HoldWidget,
    JointWidget,
    LightWidget,
    TrimWidget,
)
from rune_tui.widgets.widget import Widget

WIDGETS: Mapping[str, type[Widget]] = {
    "widgetSetSpeed": SetSpeed,
    "widgetSpeedLimit": SpeedLimit,
    "widgetTrim": TrimWidget,
    "widgetStop": StopRobot,
    "widgetHold": HoldWidget,
    "widgetJoint": JointWidget,
    "widgetArm": ArmWidget,
    "widgetDisarm": DisarmWidget,
    "widgetAutopilot": AutopilotWidget,
    "widgetMode": ModeWidget,
    "widgetTakeControl": TakeControl,
    "widgetReleaseControl": ReleaseControl,
    "widgetGrantControl": GrantControl,
    "widgetDenyControl": DenyControl,
    "widgetTakeOver": TakeOver,
    "widgetGoTo": GoTo,
    "widgetAutonomy": Autonomy,
    "widgetSafety": Safety,
    "widgetAdjustPan": AdjustPan,
    "widgetAdjustTilt": AdjustTilt,
    "widgetAdjustPanTilt": AdjustPanTilt,
    "widgetAdjustZoom": AdjustZoom,
    "widgetHomePTZ": HomePTZ,
    "widgetChooseCamera": ChooseCameraWidget,
    "widgetSetImageRequest": SetImageRequest,
    "widgetSetImageQuality": SetImageQuality,
    "widgetToggleNightMode": ToggleNightMode,
    "widgetLight": LightWidget,
    "widgetSetVictim": SetVictim,
    "widgetSetLandmark": SetLandmark,
    "widgetUndoMark": UndoMark,
    "widgetEditMark": EditMark,
    "widgetRemoveMark": RemoveMark,
    "widgetCorrectLandmark": CorrectLandmark,
    "widgetExportMarks": ExportMarks,
    "widgetMission": Mission,
    "widgetShowViewport": ShowViewportWidget,
    "widgetFullScreen": FullScreen,
    "widgetZoomMap": ZoomMap,
    "widgetChooseRobot": ChooseRobotWidget,
    "widgetNextAlarm": NextAlarm,
    "widgetPeek": PeekWidget,
    "widgetNextLayout": NextLayout,
    "widgetTheme": ThemeWidget,
    "widgetHelp": Help,
    "widgetMessages": Messages,
    "widgetScreenshot": Screenshot,
    "widgetRecord": RecordWidget,
    "widgetRobotRecord": RobotRecordWidget,
    "widgetCalibrate": Calibrate,
    "widgetQuit": Quit,
}
