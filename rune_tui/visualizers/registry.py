"""Every visualizer by the name that layouts use."""

from __future__ import annotations

from typing import Final

from rune_tui.visualizers.alarms import Alarms
from rune_tui.visualizers.attitude import Attitude
from rune_tui.visualizers.autonomy import Autonomy
from rune_tui.visualizers.battery import Battery
from rune_tui.visualizers.button import Button
from rune_tui.visualizers.camera_image import CameraImage
from rune_tui.visualizers.capabilities import Capabilities
from rune_tui.visualizers.compass import Compass
from rune_tui.visualizers.control import Control
from rune_tui.visualizers.depth import Depth
from rune_tui.visualizers.event_log import EventLog
from rune_tui.visualizers.ground_plane import GroundPlane
from rune_tui.visualizers.heading import Heading
from rune_tui.visualizers.joystick import Joystick
from rune_tui.visualizers.label import Label
from rune_tui.visualizers.link_words import Link
from rune_tui.visualizers.map_data import MapData
from rune_tui.visualizers.marks import Marks
from rune_tui.visualizers.mission import Mission
from rune_tui.visualizers.modules import Modules
from rune_tui.visualizers.night_mode import NightMode
from rune_tui.visualizers.pan_data import PanData
from rune_tui.visualizers.plot import Plot
from rune_tui.visualizers.range_data import RangeData
from rune_tui.visualizers.speed_gauge import Speed
from rune_tui.visualizers.status import Status
from rune_tui.visualizers.tilt_data import TiltData
from rune_tui.visualizers.visualizer import Visualizer

VISUALIZERS: Final[dict[str, type[Visualizer]]] = {
    "visualizeCameraImage": CameraImage,
    "visualizeGroundPlane": GroundPlane,
    "visualizeLabel": Label,
    "visualizeMapData": MapData,
    "visualizeNightMode": NightMode,
    "visualizePanData": PanData,
    "visualizeRangeData": RangeData,
    "visualizeStatus": Status,
    "visualizeTiltData": TiltData,
    "visualizeAttitude": Attitude,
    "visualizeBattery": Battery,
    "visualizeCompass": Compass,
    "visualizeDepth": Depth,
    "visualizeHeading": Heading,
    "visualizeSpeed": Speed,
    "visualizeAlarms": Alarms,
    "visualizeAutonomy": Autonomy,
    "visualizeCapabilities": Capabilities,
    "visualizeControl": Control,
    "visualizeEventLog": EventLog,
    "visualizeJoystick": Joystick,
    "visualizeLink": Link,
    "visualizeMarks": Marks,
    "visualizeMission": Mission,
    "visualizeModules": Modules,
    "visualizeButton": Button,
    "visualizePlot": Plot,
}
