"""A layout made from what is in a recording of ROS 2; pure.

| the recording has | the layout has |
| --- | --- |
| pictures, clouds of points | the first as the large viewport, up to three more beside it |
| a map, or a pose | the map with the robot and its trail |
| scans, ranges | the beams around the robot |
| an IMU | attitude |
| diagnostics | the problems |
| a battery, a velocity | gauges |
| any topics | their tree, the fields of one, and a number over time |
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final
from xml.sax.saxutils import quoteattr

from hub.gcm.capability import Capability
from hub.recording.ros.topic_roles import RosRole, TopicRole
from hub.values import dataclass

_MOST_CAMERAS: Final = 4
_MAPPED: Final = {
    *(RosRole.MAP, RosRole.ODOMETRY, RosRole.POSE, RosRole.POSE_WITH_ERROR, RosRole.FRAMES),
}
_MOVING: Final = {RosRole.ODOMETRY, RosRole.COMMAND, RosRole.COMMAND_STAMPED}
_CAPABILITIES: Final = (
    *(Capability.CON_REAL, Capability.VIS_VID, Capability.NAV_STATE, Capability.DRV_BASE),
    *(Capability.PRO_MAP, Capability.PRO_POINTS),
)
_SIZES: Final = (("large", 146, 42), ("wide", 108, 33), ("small", 1, 1))
"""Arrangements, and the least columns and rows for each."""
_BESIDE: Final = {"large": 4, "wide": 3, "small": 2}
"""Most viewports beside the large one."""
_WIDTH: Final = 240
_HEIGHT: Final = 240
"""Size of the view in its own units; edges scale to the terminal."""
_TITLE: Final = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pane:
    """A viewport.

    Attributes:
        name: Its name.
        body: Its visualizer.
        title: Its title; empty: none.
    """

    name: str
    body: str
    title: str = ""


def bag_layout(cameras: Sequence[TopicRole], roles: frozenset[RosRole]) -> str:
    """The text of a layout.

    Args:
        cameras: The topics that are shown as cameras, the main one first.
        roles: What the recording has.
    """
    pictures = [*_panes(cameras, roles)]
    gauges = [*_gauges(roles)]
    topics = (
        _Pane(name="topics", body=_shows("visualizeTopics"), title="topics"),
        _Pane(name="fields", body=_shows("visualizeFields")),
        _Pane(name="plot", body=_shows("visualizeTopicPlot")),
    )
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        "<!-- Made by `rune replay` from the topics of a recording. -->",
        '<rune run="1">',
        '  <robot name="robot" hub="127.0.0.1">',
        *(f'    <capability name="{each}"/>' for each in _CAPABILITIES),
        "  </robot>",
        "  <view>",
    ]
    for pane in (*pictures, *gauges, *topics):
        title = f" title={quoteattr(pane.title)}" if pane.title else ""
        lines.append(f"    <viewport name={quoteattr(pane.name)}{title}>{pane.body}</viewport>")
    for name, columns, rows in _SIZES:
        lines.append(
            f'    <arrangement name="{name}" min-columns="{columns}" min-rows="{rows}" '
            f'xsize="{_WIDTH}" ysize="{_HEIGHT}">'
        )
        shown = gauges if name != "small" else []
        lines += _places(pictures[: 1 + _BESIDE[name]], shown, small=name == "small")
        lines.append("    </arrangement>")
    return "\n".join([*lines, "  </view>", "</rune>", ""])


def _panes(cameras: Sequence[TopicRole], roles: frozenset[RosRole]) -> Iterator[_Pane]:
    """What shows places and pictures, the most important first."""
    names = [each.name for each in cameras[:_MOST_CAMERAS]]
    for name in names[:1]:
        yield _Pane(name="camera", body=_shows("visualizeCameraImage"), title=name[:_TITLE])
    if roles & _MAPPED:
        show = "whole" if RosRole.MAP in roles else "robot"
        yield _Pane(name="map", body=_shows("visualizeMapData", show=show), title="map")
    if roles & {RosRole.SCAN, RosRole.RANGE}:
        yield _Pane(name="range", body=_shows("visualizeRangeData"), title="ranges")
    for number, name in enumerate(names[1:], start=2):
        shown = _shows("visualizeCameraImage", camera=name)
        yield _Pane(name=f"camera {number}", body=shown, title=name[:_TITLE])
    if RosRole.IMU in roles:
        yield _Pane(name="attitude", body=_shows("visualizeAttitude"), title="attitude")
    if RosRole.PROBLEMS in roles:
        yield _Pane(name="alarms", body=_shows("visualizeAlarms"), title="problems")


def _gauges(roles: frozenset[RosRole]) -> Iterator[_Pane]:
    """What shows a number in a row or two."""
    if RosRole.BATTERY in roles:
        yield _Pane(name="battery", body=_shows("visualizeBattery"))
    if roles & _MOVING:
        yield _Pane(name="speed", body=_shows("visualizeSpeed"))


def _shows(function: str, **options: str) -> str:
    inner = "".join(
        f"<option name={quoteattr(name)} value={quoteattr(value)}/>"
        for name, value in options.items()
    )
    return f'<visualizer function="{function}">{inner}</visualizer>'


def _places(panes: Sequence[_Pane], gauges: Sequence[_Pane], *, small: bool) -> Iterator[str]:
    """The large viewport, those beside it, the gauges, and the topics below."""
    if not panes:
        yield _place("topics", 0, 0, 110, _HEIGHT)
        yield _place("fields", 112, 0, _WIDTH - 112, 140)
        yield _place("plot", 112, 140, _WIDTH - 112, _HEIGHT - 140)
        return
    split, edge = (144, 150) if not small else (138, 130)
    large, *beside = panes
    edge = edge if beside else _WIDTH
    yield _place(large.name, 0, 0, edge - 2, split)
    bottom = split - 14 * len(gauges) if beside else split
    top = 0
    for number, pane in enumerate(beside):
        end = bottom * (number + 1) // len(beside)
        yield _place(pane.name, edge, top, _WIDTH - edge, end - top)
        top = end
    for number, gauge in enumerate(gauges if beside else ()):
        yield _place(gauge.name, edge, bottom + 14 * number, _WIDTH - edge, 14)
    yield _place("topics", 0, split, 94, _HEIGHT - split)
    yield _place("fields", 96, split, 70, _HEIGHT - split)
    yield _place("plot", 168, split, _WIDTH - 168, _HEIGHT - split)


def _place(name: str, x: int, y: int, width: int, height: int) -> str:
    where = f'xpos="{x}" ypos="{y}" xsize="{width}" ysize="{height}"'
    return f"      <place viewport={quoteattr(name)} {where}/>"
