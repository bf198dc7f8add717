"""All visualizers by their names in layouts."""

from __future__ import annotations

from typing import Final

from rune_tui.visualizers.gauges.attitude import Attitude
from rune_tui.visualizers.gauges.battery import Battery
from rune_tui.visualizers.gauges.depth import Depth
from rune_tui.visualizers.gauges.environment import EnvironmentGauge
from rune_tui.visualizers.gauges.heading import Compass, Heading
from rune_tui.visualizers.gauges.plot import Plot
from rune_tui.visualizers.gauges.speed_gauge import Speed
from rune_tui.visualizers.gauges.topic_plot import TopicPlot
from rune_tui.visualizers.maps.map_data import MapData
from rune_tui.visualizers.maps.range_data import RangeData
from rune_tui.visualizers.video.angle_bars import PanData, TiltData
from rune_tui.visualizers.video.camera_image import CameraImage
from rune_tui.visualizers.video.ground_plane import GroundPlane
from rune_tui.visualizers.video.night_mode import NightMode
from rune_tui.visualizers.visualizer import Visualizer
from rune_tui.visualizers.words.alarms import Alarms
from rune_tui.visualizers.words.attention import Attention
from rune_tui.visualizers.words.autonomy import VisualizeAutonomy
from rune_tui.visualizers.words.autopilot import VisualizeAutopilot
from rune_tui.visualizers.words.button import Button
from rune_tui.visualizers.words.capabilities import Capabilities
from rune_tui.visualizers.words.control import Control
from rune_tui.visualizers.words.event_log import EventLog
from rune_tui.visualizers.words.joystick import Joystick
from rune_tui.visualizers.words.label import Label
from rune_tui.visualizers.words.link_words import Link
from rune_tui.visualizers.words.marks import Marks
from rune_tui.visualizers.words.mission import VisualizeMission
from rune_tui.visualizers.words.modules import Modules
from rune_tui.visualizers.words.status import Status
from rune_tui.visualizers.words.team import Team
from rune_tui.visualizers.words.topic_words import TopicFields, TopicTree
from rune_tui.visualizers.words.vehicle import VisualizeVehicle

VISUALIZERS: Final[dict[str, type[Visualizer]]] = {
    "visualizeCameraImage": CameraImage,
    "visualizeGroundPlane": GroundPlane,
    "visualizeLabel": Label,
    "visualizeMapData": MapData,
    "visualizeNightMode": NightMode,
    "visualizePanData": PanData,
    "visualizeRangeData": RangeData,
    "visualizeStatus": Status,
    "visualizeTeam": Team,
    "visualizeTiltData": TiltData,
    "visualizeAttitude": Attitude,
    "visualizeBattery": Battery,
    "visualizeCompass": Compass,
    "visualizeDepth": Depth,
    "visualizeEnvironment": EnvironmentGauge,
    "visualizeHeading": Heading,
    "visualizeSpeed": Speed,
    "visualizeAlarms": Alarms,
    "visualizeAttention": Attention,
    "visualizeAutonomy": VisualizeAutonomy,
    "visualizeAutopilot": VisualizeAutopilot,
    "visualizeCapabilities": Capabilities,
    "visualizeControl": Control,
    "visualizeEventLog": EventLog,
    "visualizeJoystick": Joystick,
    "visualizeLink": Link,
    "visualizeMarks": Marks,
    "visualizeMission": VisualizeMission,
    "visualizeVehicle": VisualizeVehicle,
    "visualizeModules": Modules,
    "visualizeButton": Button,
    "visualizePlot": Plot,
    "visualizeTopics": TopicTree,
    "visualizeFields": TopicFields,
    "visualizeTopicPlot": TopicPlot,
}
