"""The text of a robot file for a robot with ROS; pure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final

from hub.plain_text import plain
from hub.robots.footprint import FARTHEST_CORNER
from hub.robots.ros.asking.findings import frame_name, plain_type
from hub.robots.ros.asking.parts import RosParts
from hub.robots.ros.asking.proposal import RosProposal
from hub.robots.ros.asking.tables import Table

_UNKNOWN_RADIUS: Final = 0.3
_HALF_PART: Final = 0.1
"""Half the size of a part whose place alone is known [m]."""
_UNKNOWN_HEIGHT: Final = 0.4
_MODULES: Final = {
    "driver": {},
    "navigation": {},
    "vision": {},
    "mapping": {"start": "on demand", "capabilities": ["PRO_MAP", "PRO_POINTS"]},
    "autonomy": {"start": "on demand", "capabilities": ["AUT_PILOT"]},
    "recorder": {"start": "on demand", "capabilities": ["REC_LOG"]},
}


def robot_file(
    proposal: RosProposal, *, name: str = "", today: str = "", certificates: str = ""
) -> str:
    """The text of a robot file.

    Args:
        proposal: The robot.
        name: Its name; empty: what it calls itself.
        today: The date, for the first line; empty: none.
        certificates: Folder with certificates for its router; empty: none.
    """
    when = f" on {today}" if today else ""
    lines = [
        f"# A {proposal.title}, adopted{when}.",
        f"name = {_value(name or proposal.name)}",
        'kind = "ros"',
        "",
        *_ros(proposal, certificates),
        "",
        *_limits(proposal),
        "",
        *_body(proposal),
    ]
    for header, tables in (
        ("range", proposal.tables.ranges),
        ("camera", proposal.tables.cameras),
        ("light", [{"name": name, "topic": topic} for name, topic in proposal.lights().items()]),
    ):
        for table in tables:
            lines += ["", f"[[{header}]]", *_table(table)]
    for joint, topic in proposal.joints().items():
        lines += ["", "[[joint]]", *_table({"name": joint, "topic": topic})]
        lines += ["lowest_deg = -90.0    # its true limits are not known", "highest_deg = 90.0"]
    for module, keys in _MODULES.items():
        if module == "vision" and not proposal.tables.cameras:
            continue
        run = {"run": f"hub.modules.{module}"}
        lines += ["", f"[modules.{module}]", *_table({**run, **keys})]
    return "\n".join(lines) + "\n"


def _ros(proposal: RosProposal, certificates: str) -> Iterator[str]:
    """The table `[ros]`."""
    parts, found = proposal.parts, proposal.found
    yield "[ros]"
    yield f"address = {_value(found.address.text)}"
    if certificates:
        yield f"certificates = {_value(certificates)}"
    yield from _velocities(proposal)
    yield from _own_abilities(parts)
    yield f"odom = {_value(parts.odometry)}"
    yield f"tf = {_value(parts.transforms)}"
    odometry = found.of(parts.odometry).value
    if frame := frame_name(odometry):
        yield f"odom_frame = {_value(frame)}"
    yield f"base_frame = {_value(proposal.base_frame)}"
    for key, topic in parts.single.items():
        if topic and (key != "map" or found.of(topic).value is not None):
            yield f"{key} = {_value(topic)}"
            if key == "battery" and proposal.battery_percent:
                yield "battery_percent = true    # it counts to 100"
        elif topic:
            yield f"# {key} = {_value(topic)}    # nothing came on it"
        elif key == "diagnostics":
            yield 'diagnostics = ""'
    if parts.single["map"] and (frame := frame_name(found.of(parts.single["map"]).value)):
        yield f"map_frame = {_value(frame)}"


def _own_abilities(parts: RosParts) -> Iterator[str]:
    """What it does by itself."""
    if parts.stop_service:
        yield f"stop_service = {_value(parts.stop_service)}"
    if parts.navigation is not None:
        comment = "drives to goals; without this key Rune's own navigation does"
        yield f"navigation = {_value(parts.navigation.name)}    # {comment}"


def _velocities(proposal: RosProposal) -> Iterator[str]:
    """The keys of `[ros]` about velocities."""
    command, assumed = proposal.parts.command, proposal.parts.assumed
    if command is not None:
        kind = f"type not known: {assumed}" if assumed else plain_type(command.schema_name)[:60]
        yield f"cmd_vel = {_value(command.name)}    # {plain(kind)}"
    if proposal.hold:
        yield f"hold = true    # {plain(proposal.stopping.words)[:200]}"


def _limits(proposal: RosProposal) -> Iterator[str]:
    most = proposal.limits
    yield "[limits]"
    yield f"linear = {most.linear:g}    # [m/s]"
    if most.sway:
        yield f"sway = {most.sway:g}"
    yield f"angular = {most.angular:g}    # [rad/s]"


def _body(proposal: RosProposal) -> Iterator[str]:
    """The table `[body]`: the outline by its URDF, else the radius of its planner."""
    yield "[body]"
    (outline, fault), radius = proposal.outline, proposal.radius
    reach = math.ceil(100.0 * outline.reach) / 100.0 if outline is not None else 0.0
    if outline is not None and not fault:
        yield f"footprint = {_value([[*corner] for corner in outline.footprint])}"
    elif radius >= reach:
        yield f"radius = {radius:g}    # as its planner has it"
    else:
        least = _unknown_radius(reach)
        why = f"; {plain(fault)[:300]}" if fault else ""
        yield f"radius = {least:g}    # not known: measure the circle that encloses it{why}"
    yield f"height = {_UNKNOWN_HEIGHT:g}    # not known: measure it"


def _unknown_radius(reach: float) -> float:
    """A radius for a robot whose outline is not known, around its known parts [m]."""
    return min(FARTHEST_CORNER, max(_UNKNOWN_RADIUS, reach + _HALF_PART if reach else 0.0))


def _table(table: Table | Mapping[str, object]) -> Iterator[str]:
    for key, value in table.items():
        yield f"{key} = {_value(value)}"


def _value(value: object) -> str:
    """A value as TOML has it."""
    if isinstance(value, str):
        shown = plain(value).replace("\\", "\\\\").replace('"', '\\"')
        return f'"{shown}"'
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)
