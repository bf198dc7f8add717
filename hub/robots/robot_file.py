"""Reads a robot file, with the body of its kind and its URDF file; all mistakes are gathered."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hub import toml_reader as toml
from hub.errors import EndpointError, RobotFileError
from hub.gcm.body import MOST_PARTS, USUAL_RADIUS, BodyFrame
from hub.nearest import did_you_mean
from hub.recording.live.settings import RecordingTable
from hub.robots.body_tables import (
    MOST_BEAMS_IN_ALL,
    ROBOTS_OWN,
    BumperTable,
    CameraTable,
    FrameTable,
    RangeTable,
    frame_tree,
    range_faults,
    read_each,
)
from hub.robots.description import RobotDescription
from hub.robots.fleet_table import FleetTable
from hub.robots.ros_table import RosTable
from hub.robots.vehicle_tables import VEHICLE, read_vehicle

SHIPPED = Path(__file__).parent / "files"
DEFAULT_ROBOT = "magellan"
"""The shipped robot that commands take if none is named."""
BODIES = Path(__file__).parent / "bodies"
"""The bodies of shipped kinds, a file each: their robot files need not repeat them."""
_SAME_LENGTH = 1e-3
"""Lengths with a smaller difference are equal [m]."""


def find_robot_file(name_or_path: str) -> Path:
    """The robot file at a path, or the shipped one of a name.

    Raises:
        RobotFileError: There is neither.
    """
    path = Path(name_or_path)
    if path.exists():
        return path
    names = sorted(file.stem for file in SHIPPED.glob("*.toml"))
    if name_or_path in names:
        return SHIPPED / f"{name_or_path}.toml"
    hint = did_you_mean(name_or_path, names)
    advice = f"; give the path of a robot file, or the name of a shipped one: {', '.join(names)}"
    raise RobotFileError(name_or_path, [f"there is no such file{hint or advice}"])


def shipped_bodies() -> dict[str, Path]:
    """The file of each shipped kind with a body of its own, by the name of the kind."""
    return {path.stem: path for path in sorted(BODIES.glob("*.toml"))}


def read_description(
    path: Path, settings: Sequence[str] = ()
) -> tuple[RobotDescription, toml.Problems]:
    """The robot in a file, and all mistakes of the file.

    Args:
        path: The robot file.
        settings: Values that replace the file's, each as "TABLE.KEY=VALUE".

    Raises:
        RobotFileError: The file cannot be read or is not TOML.
    """
    data, problems = toml.load(path, RobotFileError)
    toml.apply_settings(data, settings, problems)
    _add_body_of_kind(data)
    tables = dict(toml.tables_of(RobotDescription))
    top = tables.pop("")
    fields = toml.read_table(
        top,
        data,
        toml.TOP,
        problems,
        tables=[*tables, *_BODY, "recording", "ros", "fleet", "modules"],
    )
    for name, keys in tables.items():
        fields |= toml.read_table(keys, data.get(name, {}), f"[{name}]", problems)
    beside = path.absolute().parent
    fields["urdf"] = _located(fields["urdf"], beside)
    fields |= _read_body(data, fields, problems)
    fields["radius"] = _enclosing(fields["radius"], fields["footprint"], problems)
    recording = toml.read_table(
        toml.keys_of(RecordingTable), data.get("recording", {}), "[recording]", problems
    )
    for name in ("folder", "file"):
        recording[name] = _located(recording[name], beside)
    fields["recording"] = RecordingTable(**recording)
    ros = toml.read_table(toml.keys_of(RosTable), data.get("ros", {}), "[ros]", problems)
    ros["certificates"] = _located(ros["certificates"], beside)
    fields["ros"] = RosTable(**ros)
    fields["fleet"] = _fleet(data, beside, problems)
    modules = data.get("modules", {})
    if not isinstance(modules, dict):
        problems.add(toml.TOP, "modules has to be tables: [modules.NAME]", "modules")
        modules = {}
    for name in ("keys", "logs", "map_folder", "mission_folder", "signing_key"):
        fields[name] = _located(fields[name], beside)
    if fields["arena"].endswith(".toml"):
        fields["arena"] = _located(fields["arena"], beside)
    fields["cameras"] = tuple(
        dataclasses.replace(camera, source=_located(camera.source, beside))
        if camera.source != ROBOTS_OWN and "://" not in camera.source
        else camera
        for camera in fields["cameras"]
    )
    return RobotDescription(
        path=path, settings=tuple(settings), modules=modules, **fields
    ), problems


_BODY = ("frame", "range", "bumper", "camera", *VEHICLE)
"""The tables of the body that may occur several times."""
_APART = ("recording", "ros", "fleet")
"""The tables with a dataclass of their own."""


def _add_body_of_kind(data: dict[str, Any]) -> None:
    """Add the body of a shipped kind where the robot file has none of its own."""
    kind = data.get("kind")
    file = shipped_bodies().get(kind) if isinstance(kind, str) else None
    if file is None:
        return
    for name, values in toml.load(file, RobotFileError)[0].items():
        own = data.setdefault(name, values)
        if isinstance(own, dict) and isinstance(values, dict) and not _is_another(name, own):
            data[name] = {**values, **own}


def _is_another(name: str, table: dict[str, Any]) -> bool:
    """Whether a table of a robot file describes another part than that of its kind."""
    if name == "camera":
        return bool(table.get("source", ROBOTS_OWN) != ROBOTS_OWN)
    return not table.keys().isdisjoint({"radius", "footprint", "urdf"})


def _read_body(
    data: dict[str, Any], fields: dict[str, Any], problems: toml.Problems
) -> dict[str, Any]:
    """The fields of the body's tables that may occur several times, and of its URDF file."""
    given: Mapping[str, BodyFrame] = {}
    outline: dict[str, Any] = {}
    if fields["urdf"]:
        from hub.robots.urdf import read_urdf

        try:
            model = read_urdf(Path(fields["urdf"]))
        except RobotFileError as error:
            problems.add("[body]", f"[body], key 'urdf': {error}", "urdf")
        else:
            given = model.frames
            if not fields["footprint"] and not model.fault:
                outline = {"footprint": model.footprint}
            elif not fields["footprint"] and "radius" not in data.get("body", {}):
                text = f"{fields['urdf']}: {model.fault}; give 'footprint' or 'radius' too"
                problems.add("[body]", f"[body], key 'urdf': {text}", "urdf")
    cameras = _cameras(data.get("camera", []), problems)
    ranges = read_each(RangeTable, data.get("range", []), "range", problems, range_faults)
    beams = sum(table.beams for table in ranges.values())
    if beams > MOST_BEAMS_IN_ALL:
        text = f"{beams} beams of all [[range]] are more than the {MOST_BEAMS_IN_ALL} allowed"
        problems.add(toml.TOP, text, "range")
    bumpers = read_each(BumperTable, data.get("bumper", []), "bumper", problems)
    if sum(table.count for table in bumpers.values()) > MOST_PARTS:
        problems.add(toml.TOP, f"more than {MOST_PARTS} bumpers", "bumper")
        bumpers = {}
    own = read_each(FrameTable, data.get("frame", []), "frame", problems)
    return outline | {
        "frames": frame_tree({**own, **ranges, **cameras}, given, problems),
        "ranges": tuple(ranges.values()),
        "bumpers": tuple(bumpers.values()),
        "cameras": tuple(cameras.values()),
        **read_vehicle(data, cameras.values(), problems),
    }


def _cameras(values: object, problems: toml.Problems) -> dict[str, CameraTable]:
    """The camera of [camera], or those of each [[camera]], by their place in the file."""
    if not isinstance(values, dict):
        return read_each(CameraTable, values, "camera", problems)
    before = len(problems)
    fields = toml.read_table(toml.keys_of(CameraTable), values, "[camera]", problems)
    return {"[camera]": CameraTable(**fields)} if len(problems) == before else {}


def _fleet(data: dict[str, Any], folder: Path, problems: toml.Problems) -> FleetTable | None:
    """The table [fleet]; None: the robot joins none."""
    if "fleet" not in data:
        return None
    fields = toml.read_table(toml.keys_of(FleetTable), data["fleet"], "[fleet]", problems)
    fields["certificates"] = _located(fields["certificates"], folder)
    table = FleetTable(**fields)
    try:
        table.client_settings(table.name)
    except EndpointError as error:
        problems.add("[fleet]", f"[fleet], key 'router': {error}", "router")
    return table


def _enclosing(
    radius: float, corners: tuple[tuple[float, float], ...], problems: toml.Problems
) -> float:
    """The radius of the circle that encloses the body [m]."""
    farthest = max((math.hypot(x, y) for x, y in corners), default=0.0)
    if math.isnan(radius):
        return farthest or USUAL_RADIUS
    if radius < farthest - _SAME_LENGTH:
        text = (
            f"[body], key 'radius': {radius:g} m does not enclose the footprint, whose farthest "
            f"corner is {farthest:.3f} m off; leave the radius out"
        )
        problems.add("[body]", text, "radius")
    return radius


def _located(named: str, folder: Path) -> str:
    """A path in a robot file: relative to its folder; empty: none."""
    return str(folder / os.path.expanduser(named)) if named else ""  # noqa: PTH111 - never raises
