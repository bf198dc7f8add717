"""The tables `[[range]]` and `[[camera]]` of a robot, from a message of each topic; pure."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from hub.gcm.body import MOST_PARTS, RangeGroup, RangeKind
from hub.plain_text import plain
from hub.robots.body_tables import MOST_BEAMS_IN_ALL
from hub.robots.ros.asking.findings import RosFindings, frame_name
from hub.robots.ros.asking.parts import CameraTopics, RosParts
from hub.robots.ros.topic_reader import UNFIT
from hub.ros import messages
from hub.ros.frame_tree import FramePlace
from hub.ros.values import RosValue
from hub.values import dataclass

Table = dict[str, object]
"""A table of a robot file: values by key."""
_GROUNDS: Final = ("base_footprint", "base_link")
_FARTHEST: Final = 10.0
_ALL_AROUND: Final = 0.02
_USUAL_RATE: Final = 10.0
_OPTICAL: Final = np.array([(0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)])
"""Forward, left, up (columns) in a frame of optics, whose z points forward, x right, y down."""
_ODD: Final = re.compile(r"[^A-Za-z0-9_-]+")
_LONGEST: Final = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyTables:
    """The tables of a robot's sensors.

    Attributes:
        ranges: `[[range]]`.
        cameras: `[[camera]]`.
        doubts: What is not known or not used of them, a sentence each.
    """

    ranges: tuple[Table, ...]
    cameras: tuple[Table, ...]
    doubts: tuple[str, ...]


def tables_of(found: RosFindings, parts: RosParts) -> BodyTables:
    """The tables of a robot."""
    made = _SensorTables(found, parts)
    return BodyTables(
        ranges=tuple(made.ranges()), cameras=tuple(made.cameras()), doubts=tuple(made.doubts)
    )


def base_frame(found: RosFindings, parts: RosParts) -> str:
    """The frame of the base: that which the odometry moves."""
    value = found.of(parts.odometry).value
    frame = frame_name(value, "child_frame_id")
    if frame:
        return frame
    known = found.frames.names
    return next((each for each in _GROUNDS if each in known), "base_link")


class _SensorTables:
    def __init__(self, found: RosFindings, parts: RosParts) -> None:
        self._found, self._parts = found, parts
        base = base_frame(found, parts)
        within = found.frames
        ground = _GROUNDS[0]
        self._base = ground if within.place(base, ground) is not None else base
        self._names: set[str] = {"base_link"}
        self.doubts: list[str] = []

    def ranges(self) -> Iterator[Table]:
        """A table for each scan and range sensor that has sent a message."""
        beams = count = 0
        reads = {
            **dict.fromkeys(self._parts.scans, messages.laser_scan),
            **dict.fromkeys(self._parts.ranges, messages.single_range),
        }
        for topic, read in reads.items():
            heard = self._found.of(topic)
            if heard.value is None:
                self._doubt(f"{topic} is not used: {heard.fault or 'nothing came on it'}")
                continue
            try:
                group, _ = read(heard.value, topic.rpartition("/")[2][:_LONGEST])
            except UNFIT as fault:
                self._doubt(f"{topic} is not used: {fault}")
                continue
            if not group.nearest <= group.farthest or not group.farthest:
                self._doubt(f"{topic} is not used: its largest range is {group.farthest:g} m")
                continue
            if beams + group.beams > MOST_BEAMS_IN_ALL or count == MOST_PARTS:
                self._doubt(f"{topic} is not used: there are too many range sensors")
                continue
            beams, count = beams + group.beams, count + 1
            yield self._range(topic, group, heard.value, heard.rate_hz)

    def _range(self, topic: str, group: RangeGroup, value: RosValue, rate: float) -> Table:
        spread = group.step * (group.beams - 1)
        if math.isclose(abs(group.step) * group.beams, math.tau, rel_tol=_ALL_AROUND):
            spread = math.copysign(math.tau, group.step)
        frame = frame_name(value)
        table: Table = {
            "name": self._name(frame if frame and frame != self._base else group.name),
            "topic": topic,
            "kind": RangeKind(group.kind).name.lower().replace("_", " "),
        }
        if group.beams > 1:
            table |= {
                "beams": group.beams,
                "first_deg": _rounded(math.degrees(group.first)),
                "spread_deg": _rounded(math.degrees(spread)),
            }
        if group.opening > 0.0:
            table["opening_deg"] = _rounded(math.degrees(group.opening))
        table |= {"nearest": _rounded(group.nearest), "farthest": _rounded(group.farthest)}
        table["rate_hz"] = round(min(1000.0, max(0.1, rate)) if rate > 0.0 else _USUAL_RATE, 1)
        place = self._place(frame, topic)
        return table | (_pose(place) if place is not None else {})

    def cameras(self) -> Iterator[Table]:
        """A table for each camera."""
        for camera in self._parts.cameras[:MOST_PARTS]:
            heard = self._found.of(camera.pictures)
            if heard.fault:
                self._doubt(f"{camera.pictures} is not used: {heard.fault}")
            else:
                yield self._camera(camera, heard.value)

    def _camera(self, camera: CameraTopics, picture: RosValue | None) -> Table:
        base = camera.pictures.removesuffix("/compressed")
        table: Table = {"name": self._name(_camera_name(base)), "topic": camera.pictures}
        table |= {"info": camera.info} if camera.info else {}
        info = self._found.of(camera.info).value if camera.info else None
        view, size = math.nan, (0, 0)
        sized = info if info is not None else None if camera.compressed else picture
        try:
            if info is not None:
                view = messages.field_of_view(info)
            if sized is not None:
                size = int(sized.get("width")), int(sized.get("height"))
        except UNFIT as fault:
            self._doubt(f"{camera.info or camera.pictures} makes no sense: {fault}")
        if math.radians(1.0) <= view <= math.radians(170.0):
            table["fov_deg"] = _rounded(math.degrees(view))
        else:
            self._doubt(f"the field of view of {camera.pictures} is not known: correct `fov_deg`")
            table["fov_deg"] = 60
        if all(0 < each <= 10_000 for each in size):
            table |= {"width_px": size[0], "height_px": size[1]}
        frame = frame_name(info) or frame_name(picture)
        place = self._place(frame, camera.pictures)
        if place is None or not 0.0 <= place.origin[2] <= _FARTHEST:
            return table
        if "optical" in frame:
            place = FramePlace(place.turn @ _OPTICAL, place.origin)
        return table | _pose(place)

    def _place(self, frame: str, topic: str) -> FramePlace | None:
        """The place of a frame on the body; None: it is not known, which is said."""
        place = self._found.frames.place(frame, self._base) if frame else None
        if place is None or max(map(abs, place.origin.tolist())) > _FARTHEST:
            way = f"no frame joins {frame!r} and {self._base!r}" if frame else "it names no frame"
            self._doubt(f"the place of {topic} on the body is not known: {way}")
            return None
        return place

    def _name(self, wanted: str) -> str:
        """A name that no other table has."""
        name = _ODD.sub("_", wanted).strip("_")[:_LONGEST] or "sensor"
        number = 1
        while name in self._names:
            number += 1
            name = f"{name[: _LONGEST - 5].rstrip('0123456789').rstrip('_')}_{number}"
        self._names.add(name)
        return name

    def _doubt(self, sentence: str) -> None:
        self.doubts.append(plain(sentence)[:400])


def _camera_name(base: str) -> str:
    """A name for a camera, from that of its topic."""
    usual = ("image_raw", "image", "image_color", "image_rect", "image_rect_color", "preview")
    words = [word for word in base.strip("/").split("/") if word not in usual]
    return words[-1] if words else "camera"


def _pose(place: FramePlace) -> Table:
    """The keys of a place; what is 0 is left out."""
    forward, left, height = place.origin.tolist()
    roll, pitch, yaw = (math.degrees(each) for each in place.roll_pitch_yaw)
    keys: Mapping[str, float] = {
        "forward": forward,
        "left": left,
        "height": height,
        "roll_deg": roll,
        "pitch_deg": pitch,
        "yaw_deg": yaw,
    }
    return {key: _rounded(value) for key, value in keys.items() if _rounded(value)}


def _rounded(value: float) -> float:
    """A number as it is written."""
    return round(float(value), 3) + 0.0
