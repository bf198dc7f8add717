"""A layout made from what a robot's hub says: its body and its capabilities; pure.

| the robot has | the layout has |
| --- | --- |
| a camera | its picture in the large viewport, with the directions of its head |
| more cameras | small pictures beside it; a click on one, or a key, changes the large one |
| range sensors | ranges |
| a map, autonomy | the map, what it does by itself, and their keys |
| a degree of freedom | its keys and sticks |
| motion up and down | attitude and height |
| holds, joints, motors that can be disarmed | the vehicle's state, and their keys |
| an autopilot with modes | what it does and says, and keys to follow, to stay, and for its modes |
| lights | a key for the first one |
| sensors of the air | sound and carbon dioxide |

The text is a layout file as people write it, to be edited further.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from xml.sax.saxutils import quoteattr

from hub.gcm.body import Freedom, RobotBody
from hub.gcm.flight import ALTITUDE
from hub.gcm.imu import IMU
from hub.plain_text import is_plain, plain
from hub.values import dataclass
from rune_tui.layout.rules import NumberOption
from rune_tui.widgets.registry import WIDGETS

_CAPABILITIES = (
    ("CON_REAL", 0),
    ("VIS_VID", 66),
    ("VIS_PTZ", 0),
    ("VIS_NIGHT", 0),
    ("NAV_STATE", 0),
    ("NAV_MOVE", 0),
    ("NAV_GOAL", 0),
    ("PRO_MAP", 2000),
    ("PRO_POINTS", 0),
    ("AUT_PILOT", 0),
    ("DRV_HOLD", 0),
    ("DRV_LIGHT", 0),
    ("DRV_JOINT", 0),
    ("DRV_ARM", 0),
    ("DRV_MODE", 0),
)
"""What a console asks of a robot that has it, and how often [ms]; 0: no period."""
_ALWAYS = ("CON_REAL", "NAV_STATE", "NAV_MOVE")
"""What every layout asks for: state, motion and stop; a robot without them says so."""
_SMALL_MS = 333
"""Shortest time between two of the small pictures [ms]."""
_LEFT_OUT = (
    *("log", "autonomy", "attitude"),
    *("camera 4", "camera 3", "camera 2"),
    *("air", "range", "height", "map"),
)
"""Panels that are left out where there is no room for the least height of all, in this order."""
_FREE_ROWS = 8
"""Height of a panel that takes what is left [half rows]."""
_MOST_WORDS = 26
"""Most rows of the vehicle's state [half rows]."""
_LONGEST_TITLE = 40
"""Most characters of a viewport's title."""
_MOST_SMALL = 3
"""Most small pictures beside the large one."""
_KEYS = {
    Freedom.SURGE: ("translate", "w", "s", "W S drive"),
    Freedom.YAW: ("rotate", "a", "d", "A D turn"),
    Freedom.HEAVE: ("climb", "pageup", "pagedown", "PgUp PgDn climb"),
    Freedom.SWAY: ("strafe", ",", ".", ", . sideways"),
}
"""Control of each degree of freedom, its keys for plus and minus, and their piece of the legend.

The first are the most important.
"""
_SPEED_OPTIONS = {
    Freedom.SURGE: "linear",
    Freedom.YAW: "angular",
    Freedom.SWAY: "strafe",
    Freedom.HEAVE: "climb",
}
"""The option with the speed of each degree of freedom."""
_NEXT = '    <widget handler="widgetNextLayout"><event key="f4"/></widget>'
"""The key to the layout of all robots of a fleet, as they have it to this one."""
_HOLD_KEYS = ("g", "y")
"""Keys of the first holds."""
_JOINT_KEYS = (("2", "1"), ("4", "3"), ("6", "5"), ("8", "7"))
"""Keys of the first joints, for up and down."""
_STICKS = {
    Freedom.SURGE: ("lefty", 1),
    Freedom.YAW: ("leftx", -1),
    Freedom.HEAVE: ("righty", 1),
    Freedom.SWAY: ("rightx", -1),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Panel:
    """A viewport beside the large one.

    Attributes:
        name: Its name.
        rows: Its height where there is room [half rows]; 0: a share of what is left.
        least: The least height in which it can be read, with its title [half rows].
        body: Its visualizer and widgets.
        title: Its title; empty: none.
    """

    name: str
    body: str
    rows: int = 0
    least: int = 6
    title: str = ""


def layout_text(
    body: RobotBody,
    capabilities: Collection[str],
    hub: str,
    *,
    robot: str = "robot",
    fleet: str = "",
) -> str:
    """The layout for a robot.

    Args:
        body: What its hub describes.
        capabilities: Names of the capabilities that it has.
        hub: The hub's endpoint.
        robot: Its name in the layout.
        fleet: The fleet in which it has that name; empty: the layout names the hub.
    """
    where = f"fleet={quoteattr(fleet)}" if fleet else f"hub={quoteattr(hub)}"
    panels = [*_panels(body, capabilities)]
    large, *beside = panels
    legend = quoteattr(_legend(body, capabilities))
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f"<!-- Made by `rune layout auto` for {_comment(body.name)}, a {_comment(body.kind)}. -->",
        '<rune run="1">',
        f"  <robot name={quoteattr(robot)} {where}>",
        *_wanted(capabilities),
        "  </robot>",
        '  <joystick name="pad"/>',
        "  <view>",
        '    <widget handler="widgetQuit"><event key="q"/></widget>',
        '    <widget handler="widgetHelp"><event key="f1"/><event key="?"/></widget>',
        '    <widget handler="widgetScreenshot"><event key="f12"/></widget>',
        '    <widget handler="widgetRecord"><event key="f10"/></widget>',
        *([_NEXT] if fleet else []),
        f'    <viewport name="{large.name}">',
        f"      {large.body}",
        *(f"      {line}" for line in _controls(body, capabilities)),
        "    </viewport>",
    ]
    for panel in (*beside, *_gauges()):
        title = f" title={quoteattr(panel.title)}" if panel.title else ""
        lines.append(f"    <viewport name={quoteattr(panel.name)}{title}>{panel.body}</viewport>")
    lines += [
        '    <viewport name="keys" zpos="5">',
        f'      <visualizer function="visualizeLabel" text={legend}/>',
        "    </viewport>",
        '    <viewport name="status" zpos="5"><visualizer function="visualizeStatus"/></viewport>',
        *_arrangement("large", (160, 48), (160, 96), 113, large, beside, gauges=True),
        *_arrangement("wide", (120, 40), (120, 80), 89, large, beside, gauges=True),
        *_arrangement("small", (80, 24), (80, 48), 50, large, beside, gauges=False),
        *_tiny(large),
        "  </view>",
        "</rune>",
    ]
    return "\n".join(lines) + "\n"


def _comment(text: str) -> str:
    return re.sub("-(?=-)", "- ", plain(text))


def _wanted(capabilities: Collection[str]) -> Iterator[str]:
    for name, period in _CAPABILITIES:
        if name in capabilities or name in _ALWAYS:
            interval = f' interval_ms="{period}"' if period else ""
            yield f'    <capability name="{name}"{interval}/>'


def _panels(body: RobotBody, capabilities: Collection[str]) -> Iterator[_Panel]:
    """The large viewport, then those beside it from the top."""
    cameras = body.cameras if "VIS_VID" in capabilities else ()
    if cameras:
        yield _Panel(name="camera", body=_shows("visualizeCameraImage", camera="*"))
    small = [camera.name for camera in cameras[1:] if _can_be_named(camera.name)]
    for number, name in enumerate(small[:_MOST_SMALL], start=2):
        picture = _shows("visualizeCameraImage", camera=name, interval_ms=str(_SMALL_MS))
        picture += '<widget handler="widgetChooseCamera">'
        picture += f'<option name="camera" value={quoteattr(name)}/><event mouse="left"/></widget>'
        title = name[:_LONGEST_TITLE].strip()
        yield _Panel(name=f"camera {number}", body=picture, rows=20, least=12, title=title)
    if "PRO_MAP" in capabilities:
        shown = '<visualizer function="visualizeMapData" option="8"/>'
        shown += '<widget handler="widgetZoomMap"><event mouse="wheel"/></widget>'
        if "NAV_GOAL" in capabilities:
            shown += '<widget handler="widgetGoTo"><event mouse="left"/></widget>'
        yield _Panel(name="map", body=shown, rows=26, least=14, title="map")
    if body.ranges:
        shown = '<visualizer function="visualizeRangeData" option="3"/>'
        yield _Panel(name="range", body=shown, rows=26, least=12, title="ranges")
    yield from _stance(body)
    autopilot = "DRV_MODE" in capabilities
    if autopilot:
        shown = _shows("visualizeAutopilot")
        yield _Panel(name="autopilot", body=shown, rows=_MOST_WORDS, least=16, title="autopilot")
    if body.holds or body.joints or (body.arms and not autopilot):
        words = 2 * (3 + len(body.holds) + len(body.joints) + len(body.lights))
        rows = min(_MOST_WORDS, words)
        shown = _shows("visualizeVehicle")
        yield _Panel(name="vehicle", body=shown, rows=rows, least=rows, title="vehicle")
    if body.senses:
        yield _Panel(name="air", body=_shows("visualizeEnvironment"), rows=4, least=4)
    yield _Panel(name="alarms", body=_shows("visualizeAlarms"), title="problems")
    if "AUT_PILOT" in capabilities:
        yield _Panel(name="autonomy", body=_shows("visualizeAutonomy"), title="by itself")
    yield _Panel(name="log", body=_shows("visualizeEventLog"), title="events")


def _can_be_named(part: str) -> bool:
    """Whether a layout can name this part of the body."""
    return is_plain(part) and part == part.strip() != "" and "${" not in part


def _stance(body: RobotBody) -> Iterator[_Panel]:
    """How the robot stands, flies or dives, as far as it measures that."""
    brought = {each.message for each in body.messages}
    flies = any(motion.freedom is Freedom.HEAVE for motion in body.motions)
    if flies or IMU.name in brought:
        shown = _shows("visualizeAttitude")
        yield _Panel(name="attitude", body=shown, rows=18, least=12, title="attitude")
    if flies or ALTITUDE.name in brought:
        shown = _shows("visualizeDepth")
        yield _Panel(name="height", body=shown, rows=18, least=12, title="{shown}")


def _gauges() -> Iterator[_Panel]:
    yield _Panel(name="heading", body=_shows("visualizeHeading"))
    yield _Panel(name="speed", body=_shows("visualizeSpeed"))
    yield _Panel(name="battery", body=_shows("visualizeBattery"))


def _shows(function: str, **options: str) -> str:
    if not options:
        return f'<visualizer function="{function}"/>'
    inner = "".join(
        f"<option name={quoteattr(name)} value={quoteattr(value)}/>"
        for name, value in options.items()
    )
    return f'<visualizer function="{function}">{inner}</visualizer>'


def _bound(body: RobotBody) -> list[tuple[Freedom, float]]:
    """The degrees of freedom with keys, the most important first, and their limits."""
    known = WIDGETS["widgetSetSpeed"].rule.controls
    limits = {motion.freedom: motion.limit for motion in body.motions}
    return [
        (freedom, limits[freedom])
        for freedom, (control, *_) in _KEYS.items()
        if freedom in limits and control in known
    ]


def _controls(body: RobotBody, capabilities: Collection[str]) -> Iterator[str]:
    """The widgets of the large viewport."""
    if "NAV_MOVE" in capabilities:
        yield from _driving(body)
    yield '<widget handler="widgetStop"><event key="space"/></widget>'
    yield '<widget handler="widgetStop"><event joystick="pad" button="b"/></widget>'
    yield '<widget handler="widgetSpeedLimit">'
    yield '  <event key="]" control="step" value="1"/><event key="[" control="step" value="-1"/>'
    yield "</widget>"
    if _looks(body) and "VIS_PTZ" in capabilities:
        yield from _LOOKING
    yield from _vehicle(body, capabilities)
    keys = [("widgetTakeControl", "t"), ("widgetReleaseControl", "c")]
    keys += [("widgetGrantControl", "p"), ("widgetDenyControl", "b")]
    keys += [("widgetMission", "m")] * ("PRO_POINTS" in capabilities)
    keys += [("widgetChooseCamera", "v")] * (len(body.cameras) > 1)
    keys += [("widgetToggleNightMode", "n")] * ("VIS_NIGHT" in capabilities)
    for handler, key in keys:
        yield f'<widget handler="{handler}"><event key="{key}"/></widget>'
    for order, key in (("explore", "e"), ("return", "r")):
        if "AUT_PILOT" in capabilities:
            yield f'<widget handler="widgetAutonomy"><option name="order" value="{order}"/>'
            yield f'  <event key="{key}"/>'
            yield "</widget>"
    if "PRO_POINTS" in capabilities and body.cameras:
        yield '<widget handler="widgetSetVictim"><event mouse="left"/></widget>'


_LOOKING = (
    '<widget handler="widgetAdjustPanTilt"><option name="camera" value="*"/>',
    '  <event key="j" control="pan" value="1"/><event key="l" control="pan" value="-1"/>',
    '  <event key="i" control="tilt" value="1"/><event key="k" control="tilt" value="-1"/>',
    '  <event joystick="pad" axis="rightx" control="pan" value="-1"/>',
    '  <event joystick="pad" axis="righty" control="tilt" value="1"/>',
    "</widget>",
)


_AUTOPILOT = (
    '<widget handler="widgetAutopilot"><option name="order" value="drive"/>',
    '  <event key="f"/><event joystick="pad" button="y"/>',
    "</widget>",
    '<widget handler="widgetAutopilot"><option name="order" value="hold"/>',
    '  <event key="h"/><event joystick="pad" button="x"/>',
    "</widget>",
    '<widget handler="widgetMode">',
    '  <event key="f2" control="next"/><event key="f3" control="set"/>',
    '  <event joystick="pad" button="leftshoulder" control="next"/>',
    '  <event joystick="pad" button="rightshoulder" control="set"/>',
    "</widget>",
)


def _driving(body: RobotBody) -> Iterator[str]:
    """Keys and sticks of each degree of freedom."""
    bound = dict(_bound(body))
    if not bound:
        return
    yield '<widget handler="widgetSetSpeed">'
    for freedom, limit in bound.items():
        if freedom in _SPEED_OPTIONS:
            yield _speed(_SPEED_OPTIONS[freedom], limit)
    for freedom in bound:
        control, plus, minus, _ = _KEYS[freedom]
        yield f'  <event key="{plus}" control="{control}" value="1"/>'
        yield f'  <event key="{minus}" control="{control}" value="-1"/>'
        axis, sign = _STICKS[freedom]
        if not (_looks(body) and axis.startswith("right")):
            yield f'  <event joystick="pad" axis="{axis}" control="{control}" value="{sign}"/>'
    yield "</widget>"


def _vehicle(body: RobotBody, capabilities: Collection[str]) -> Iterator[str]:
    """Keys of holds, joints, the first light, and the power of the motors."""
    holds = body.holds if "DRV_HOLD" in capabilities else ()
    for hold, key in zip(holds, _HOLD_KEYS, strict=False):
        name = hold.kind.name.lower()
        yield f'<widget handler="widgetHold"><option name="hold" value="{name}"/>'
        yield f'  <event key="{key}"/>'
        yield "</widget>"
    joints = body.joints if "DRV_JOINT" in capabilities else ()
    named = [joint for joint in joints if _can_be_named(joint.name)]
    for joint, (up, down) in zip(named, _JOINT_KEYS, strict=False):
        yield f'<widget handler="widgetJoint"><option name="joint" value={quoteattr(joint.name)}/>'
        yield f'  <event key="{up}" value="1"/><event key="{down}" value="-1"/>'
        yield "</widget>"
    if "REC_LOG" in capabilities:
        yield '<widget handler="widgetRobotRecord"><event key="f6"/></widget>'
        yield '<widget handler="widgetRobotRecord"><option name="do" value="note"/>'
        yield '  <event key="f7"/>'
        yield "</widget>"
    if body.lights and "DRV_LIGHT" in capabilities:
        yield '<widget handler="widgetLight"><event key="o"/></widget>'
    if body.arms and "DRV_ARM" in capabilities:
        for handler, key, button in (("widgetArm", "f8", "start"), ("widgetDisarm", "f9", "back")):
            yield f'<widget handler="{handler}"><event key="{key}"/>'
            yield f'  <event joystick="pad" button="{button}"/>'
            yield "</widget>"
    if "DRV_MODE" in capabilities:
        yield from _AUTOPILOT


def _speed(option: str, limit: float) -> str:
    """An option of `widgetSetSpeed`, within what the option allows."""
    rule = WIDGETS["widgetSetSpeed"].rule.options[option]
    most = rule.most if isinstance(rule, NumberOption) else limit
    value = round(min(most, limit), 3)
    return f'  <option name="{option}" value="{value:g}"/>'


def _looks(body: RobotBody) -> bool:
    """Whether a camera has a head."""
    return any(each.pan_limit or each.tilt_lowest < each.tilt_highest for each in body.cameras)


def _legend(body: RobotBody, capabilities: Collection[str]) -> str:
    """The keys, the most important first: a narrow terminal leaves out the last ones."""
    bound = [freedom for freedom, _ in _bound(body)] if "NAV_MOVE" in capabilities else []
    drives = [_KEYS[freedom][3] for freedom in bound if freedom is not Freedom.SWAY]
    if bound[:2] == [Freedom.SURGE, Freedom.YAW]:
        drives[:2] = ["WASD drive"]
    sideways = [_KEYS[Freedom.SWAY][3]] * (Freedom.SWAY in bound)
    autopilot = "DRV_MODE" in capabilities
    armed = ["F8 F8 arm, F9 off", "F follow"] * (autopilot and body.arms)
    parts = ["Space STOP", *drives, *armed, *["H hold"] * autopilot, "T control", *sideways]
    parts += ["F2 F3 mode"] * autopilot
    if _looks(body) and "VIS_PTZ" in capabilities:
        parts.append("IJKL look")
    if len(body.cameras) > 1:
        parts.append("V camera")
    holds = body.holds if "DRV_HOLD" in capabilities else ()
    for hold, key in zip(holds, _HOLD_KEYS, strict=False):
        parts.append(f"{key.upper()} hold {hold.kind.name.lower()}")
    joints = body.joints if "DRV_JOINT" in capabilities else ()
    named = [joint for joint in joints if _can_be_named(joint.name)]
    for joint, (up, down) in zip(named, _JOINT_KEYS, strict=False):
        parts.append(f"{down} {up} {joint.name}")
    if body.lights and "DRV_LIGHT" in capabilities:
        parts.append("O light")
    if "AUT_PILOT" in capabilities:
        parts.append("E explore")
    return " · ".join([*parts, "F1 help", "Q quit"])


def _arrangement(
    name: str,
    least: tuple[int, int],
    size: tuple[int, int],
    edge: int,
    large: _Panel,
    beside: Sequence[_Panel],
    *,
    gauges: bool,
) -> Iterator[str]:
    """The places for terminals of at least a size; sizes are columns and half rows."""
    (columns, rows), (width, height) = least, size
    bottom = height - 2 - (8 if gauges else 0)
    extent = f'min-columns="{columns}" min-rows="{rows}" xsize="{width}" ysize="{height}"'
    yield f'    <arrangement name="{name}" {extent}>'
    yield _place("keys", 0, 0, width, 2)
    yield _place(large.name, 0, 2, edge - 1, bottom - 2)
    top, right = 2, width - edge
    kept = _with_room(beside, height - 4)
    for panel, share in zip(kept, _heights(kept, height - 4), strict=True):
        yield _place(panel.name, edge, top, right, share)
        top += share
    if gauges:
        yield _place("heading", 0, bottom, 40, 6)
        yield _place("speed", 42, bottom, edge - 43, 4)
        yield _place("battery", 42, bottom + 4, edge - 43, 2)
    yield _place("status", 0, height - 2, width, 2)
    yield "    </arrangement>"


def _tiny(large: _Panel) -> Iterator[str]:
    yield '    <arrangement name="tiny" xsize="40" ysize="24">'
    if large.name == "alarms":
        yield _place("alarms", 0, 0, 40, 20)
    else:
        yield _place(large.name, 0, 0, 40, 18)
        yield _place("alarms", 0, 18, 40, 2)
    yield _place("keys", 0, 20, 40, 2)
    yield _place("status", 0, 22, 40, 2)
    yield "    </arrangement>"


def _place(name: str, x: int, y: int, width: int, height: int) -> str:
    where = f'xpos="{x}" ypos="{y}" xsize="{width}" ysize="{height}"'
    return f"      <place viewport={quoteattr(name)} {where}/>"


def _with_room(panels: Sequence[_Panel], room: int) -> list[_Panel]:
    """The panels whose least heights fit into a height [half rows]; `_LEFT_OUT` go first."""
    kept = list(panels)
    for name in _LEFT_OUT:
        if sum(panel.least for panel in kept) <= room:
            break
        kept = [panel for panel in kept if panel.name != name]
    return kept


def _heights(panels: Sequence[_Panel], room: int) -> list[int]:
    """The height of each panel [half rows], even, in all at most `room`."""
    spare = room - sum(panel.least for panel in panels)
    wishes = [(panel.rows or _FREE_ROWS) - panel.least for panel in panels]
    scale = min(1.0, spare / max(1, sum(wishes)))
    heights = [
        panel.least + int(wish * scale) // 2 * 2 for panel, wish in zip(panels, wishes, strict=True)
    ]
    free = sum(1 for panel in panels if not panel.rows)
    left = (room - sum(heights)) // free // 2 * 2  # the problems are always there
    return [
        height if panel.rows else height + left
        for panel, height in zip(panels, heights, strict=True)
    ]
