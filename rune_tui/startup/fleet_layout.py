"""A layout for several robots of a fleet: one is chosen and driven, all are in sight; pure.

It is what `land-sea-air` is for three robots, with the keys that every robot has.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.sax.saxutils import quoteattr

MOST = 9
"""Most robots in sight: each is chosen by a digit."""
_CAPABILITIES = (
    *("CON_REAL", "VIS_PTZ", "NAV_STATE", "NAV_MOVE", "NAV_GOAL", "PRO_POINTS"),
    *("AUT_PILOT", "DRV_HOLD", "DRV_LIGHT", "DRV_JOINT", "DRV_ARM", "DRV_MODE"),
)
_KEYS = (
    "Space STOP · 0 STOPS ALL · WASD drive · {heave}PgUp PgDn climb · {sway}, . sideways · "
    "digits choose · N next alarm · {look}IJKL look · T control · E explore · F1 help · Q quit"
)
_CONTROLS = """
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate" value="1"/><event key="s" control="translate" value="-1"/>
        <event key="a" control="rotate" value="1"/><event key="d" control="rotate" value="-1"/>
        <event key="pageup" control="climb" value="1"/><event key="pagedown" control="climb" value="-1"/>
        <event key="," control="strafe" value="1"/><event key="." control="strafe" value="-1"/>
        <event joystick="pad" axis="lefty" control="translate" value="1"/>
        <event joystick="pad" axis="leftx" control="rotate" value="-1"/>
        <event joystick="pad" axis="righty" control="climb" value="1"/>
        <event joystick="pad" axis="rightx" control="strafe" value="-1"/>
      </widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetStop"><event joystick="pad" button="b"/></widget>
      <widget handler="widgetSpeedLimit">
        <event key="]" control="step" value="1"/><event key="[" control="step" value="-1"/>
      </widget>
      <widget handler="widgetAdjustPanTilt"><option name="camera" value="*"/>
        <event key="j" control="pan" value="1"/><event key="l" control="pan" value="-1"/>
        <event key="i" control="tilt" value="1"/><event key="k" control="tilt" value="-1"/>
      </widget>
      <widget handler="widgetTakeControl"><event key="t"/></widget>
      <widget handler="widgetReleaseControl"><event key="c"/></widget>
      <widget handler="widgetGrantControl"><event key="p"/></widget>
      <widget handler="widgetDenyControl"><event key="b"/></widget>
      <widget handler="widgetMission"><event key="m"/></widget>
      <widget handler="widgetHold"><event key="g"/></widget>
      <widget handler="widgetLight"><event key="o"/></widget>
      <widget handler="widgetDisarm"><event key="f9"/></widget>
      <widget handler="widgetChooseCamera"><event key="v"/></widget>
      <widget handler="widgetAutonomy"><option name="order" value="explore"/><event key="e"/></widget>
      <widget handler="widgetAutonomy"><option name="order" value="return"/><event key="r"/></widget>
"""  # noqa: E501 - a layout file
_VIEW = """
    <widget handler="widgetHelp"><event key="f1"/><event key="?"/></widget>
    <widget handler="widgetQuit"><event key="q"/></widget>
    <widget handler="widgetScreenshot"><event key="f12"/></widget>
    <widget handler="widgetRecord"><event key="f10"/></widget>
    <widget handler="widgetNextLayout"><event key="f4"/></widget>
    <widget handler="widgetChooseRobot"><event key="tab"/></widget>
    <widget handler="widgetNextAlarm"><event key="n"/></widget>
    <viewport name="team" robot="*" zpos="6"><visualizer function="visualizeTeam"/></viewport>
    <viewport name="attention" title="alarms of all" robot="*">
      <visualizer function="visualizeAttention"/>
    </viewport>
    <viewport name="map" title="map of {robot}" robot="*">
      <visualizer function="visualizeMapData" option="8"/>
      <widget handler="widgetGoTo"><event mouse="left"/></widget>
      <widget handler="widgetZoomMap"><event mouse="wheel"/></widget>
    </viewport>
    <viewport name="range" title="ranges" robot="*">
      <visualizer function="visualizeRangeData" option="3"/>
    </viewport>
    <viewport name="speed" robot="*"><visualizer function="visualizeSpeed"/></viewport>
    <viewport name="battery" robot="*"><visualizer function="visualizeBattery"/></viewport>
    <viewport name="log" title="events" robot="*">
      <visualizer function="visualizeEventLog"/>
    </viewport>
    <viewport name="status" robot="*" zpos="5"><visualizer function="visualizeStatus"/></viewport>
"""
_SIZES = (("large", 160, 48, 97), ("wide", 120, 40, 72), ("small", 80, 24, 50))


def fleet_layout_text(robots: Sequence[str], fleet: str) -> str:
    """The layout for the first `MOST` of these robots.

    Args:
        robots: Their names in the fleet.
        fleet: Its name.
    """
    shown = robots[:MOST]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        "<!-- Made by `rune run auto` for robots of a fleet. -->",
        '<rune run="1">',
    ]
    for name in shown:
        lines.append(f"  <robot name={quoteattr(name)} fleet={quoteattr(fleet)}>")
        lines.append('    <capability name="VIS_VID" interval_ms="66"/>')
        lines.append('    <capability name="PRO_MAP" interval_ms="2000"/>')
        lines += [f'    <capability name="{each}"/>' for each in _CAPABILITIES]
        lines.append("  </robot>")
    lines += ['  <joystick name="pad"/>', "  <view>" + _VIEW.rstrip("\n")]
    keys = f'<visualizer function="visualizeLabel" text={quoteattr(_KEYS)}/>'
    lines.append(f'    <viewport name="keys" robot="*" zpos="6">{keys}</viewport>')
    lines.append('    <viewport name="camera" title="{robot}" robot="*">')
    lines.append('      <visualizer function="visualizeCameraImage">')
    lines.append('        <option name="camera" value="*"/>')
    lines.append("      </visualizer>" + _CONTROLS.rstrip("\n"))
    lines.append("    </viewport>")
    for number, name in enumerate(shown, start=1):
        lines += _small(number, name)
    for size in _SIZES:
        lines += _arrangement(*size, len(shown))
    lines += ["  </view>", "</rune>"]
    return "\n".join(lines) + "\n"


def _small(number: int, name: str) -> Iterator[str]:
    robot = quoteattr(name)
    yield f'    <viewport name="picture {number}" title="{number} {{robot}}" robot={robot}>'
    yield '      <visualizer function="visualizeCameraImage">'
    yield '        <option name="interval_ms" value="333"/>'
    yield "      </visualizer>"
    yield f'      <widget handler="widgetChooseRobot"><option name="robot" value={robot}/>'
    yield f'        <event key="{number}"/><event mouse="left"/></widget>'
    yield '      <widget handler="widgetStop"><event key="0"/></widget>'
    yield '      <widget handler="widgetStop"><event joystick="pad" button="x"/></widget>'
    yield "    </viewport>"


def _arrangement(name: str, columns: int, rows: int, edge: int, count: int) -> Iterator[str]:
    """The places for terminals of at least this size; heights are in half rows."""
    height, right = 2 * rows, columns - edge - 1
    across = min(3, count)
    width = (right - across + 1) // across
    tall = max(8, 2 * (width * 3 // 8))
    down = -(-count // across)
    limits = f'min-columns="{columns}" min-rows="{rows}"' if name != "small" else ""
    yield f'    <arrangement name="{name}" {limits} xsize="{columns}" ysize="{height}">'
    yield _place("keys", 0, 0, columns, 2)
    yield _place("team", 0, 2, columns, 6)
    yield _place("camera", 0, 8, edge, height - 14)
    yield _place("speed", 0, height - 6, edge // 2 - 1, 4)
    yield _place("battery", edge // 2, height - 6, edge - edge // 2, 4)
    for at in range(count):
        x, y = edge + 1 + (at % across) * (width + 1), 8 + at // across * tall
        yield _place(f"picture {at + 1}", x, y, width, tall)
    top = 8 + down * tall
    left = height - 2 - top
    share = left // 3 // 2 * 2
    if share >= 6:
        yield _place("attention", edge + 1, top, right, share)
        half = right // 2
        yield _place("map", edge + 1, top + share, half, left - 2 * share)
        yield _place("range", edge + 1 + half, top + share, right - half, left - 2 * share)
        yield _place("log", edge + 1, height - 2 - share, right, share)
    elif left >= 4:
        yield _place("attention", edge + 1, top, right, left)
    yield _place("status", 0, height - 2, columns, 2)
    yield "    </arrangement>"


def _place(viewport: str, x: int, y: int, width: int, height: int) -> str:
    where = f'xpos="{x}" ypos="{y}" xsize="{width}" ysize="{height}"'
    return f'      <place viewport="{viewport}" {where}/>'
