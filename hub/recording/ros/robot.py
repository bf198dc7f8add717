"""The robot of a recording of ROS 2: its newest messages, as Rune's own.

It keeps the newest payload of each topic, and decodes when it is asked. Frames need all messages,
and a map needs its changes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from hub.errors import RosMessageError
from hub.gcm.battery import BATTERY
from hub.gcm.body import (
    MOST_PARTS,
    ROBOT_DESCRIPTION,
    USUAL_RADIUS,
    BodyFrame,
    CameraBody,
    RangeGroup,
    RobotBody,
)
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.flight import FLUID_PRESSURE
from hub.gcm.imu import IMU
from hub.gcm.joints import JOINT_STATES
from hub.gcm.navigation import NAVIGATION_STATUS, ROBOT_STATE
from hub.gcm.ranges import RANGES, LaserScan, RangeReadings
from hub.plain_text import plain
from hub.recording.chunks import LoggedMessage
from hub.recording.ros import motion
from hub.recording.ros.batteries import battery_readers
from hub.recording.ros.topic_roles import RosRole
from hub.recording.ros.topic_values import ShownMessage, TopicMessages, TopicValues
from hub.ros import messages
from hub.ros.decoding import RosDecoder
from hub.ros.frame_tree import FrameTree, plain_frame
from hub.ros.occupancy import RosGrid
from hub.ros.values import RosValue
from hub.values import dataclass

MOST_CAMERAS: Final = 8
"""Most topics of pictures that are shown as cameras."""
_BACK_NS: Final = 10_000_000_000
_MOST_BACK: Final = 2_000
"""How far back, and in how many messages, frames are looked for after a jump."""
_MOST_CHANGES: Final = 5_000
_USUAL_FOV: Final = math.radians(60.0)
_SIMPLE: Final[Mapping[RosRole, tuple[str, Callable[[RosValue], Any]]]] = {
    RosRole.PRESSURE: (FLUID_PRESSURE.name, messages.fluid_pressure),
    RosRole.JOINTS: (JOINT_STATES.name, messages.joint_states),
}
"""Messages that need nothing else."""
_SENSORS: Final[Mapping[RosRole, Callable[[RosValue, str], tuple[RangeGroup, LaserScan]]]] = {
    RosRole.SCAN: messages.laser_scan,
    RosRole.RANGE: messages.single_range,
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RosPicture:
    """A picture that is not decoded yet.

    Attributes:
        camera: Name of the camera.
        role: What its message is.
        message: The message.
        decoder: Decodes it.
        horizontal_fov: Field of view from left to right [rad].
    """

    camera: str
    role: RosRole
    message: LoggedMessage
    decoder: RosDecoder
    horizontal_fov: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RosScene:
    """All that is known of the robot at a moment.

    Attributes:
        messages: Messages of Rune by name.
        problems: Diagnostics by the number of their topic.
        pictures: Pictures by the name of their camera; the main one is the first of the body.
        map: The map; None: there is none.
    """

    messages: Mapping[str, ShownMessage]
    problems: Mapping[int, ShownMessage]
    pictures: Mapping[str, RosPicture]
    map: ShownMessage | None


class RosRobot:
    """Takes messages in the order of time; for one thread.

    Attributes:
        values: The newest messages.
        cameras: The topics of pictures that are shown as cameras, the main one first.
    """

    def __init__(self, bag: TopicMessages, name: str) -> None:
        """Look at the topics of a bag.

        Args:
            bag: The recording.
            name: The robot's name.
        """
        self.values = TopicValues(bag)
        roles = (RosRole.PICTURE, RosRole.PACKED_PICTURE, RosRole.CLOUD)
        self.cameras = self.values.of_role(*roles)[:MOST_CAMERAS]
        self._bag = bag
        self._name = plain(name)[:64] or "robot"
        self._roles = {each.channel: each.role for each in self.values.of_role(*RosRole)}
        self._maps = [each.channel for each in self.values.of_role(RosRole.MAP)][:1]
        self._changes = self._channels_of_changes()
        self._body_known: RobotBody | None = None
        self._frames = FrameTree()
        self._batteries = battery_readers(bag, self.values)
        self._waiting: list[LoggedMessage] = []
        self._grid: ShownMessage | None = None
        self._map: tuple[ShownMessage, ShownMessage | None] | None = None
        self._map_frame = ""
        fixed = {each.channel for each in self.values.of_role(RosRole.FIXED_FRAMES)}
        found = bag.messages(channels=fixed) if fixed else iter(())
        self._fixed = list(itertools.islice(found, _MOST_BACK))

    def seek(self, stamp: int) -> None:
        """Go to a time [ns]: take the newest messages at or before it."""
        self.values.newest = dict(self._bag.newest(stamp))
        # Frames that never move count before they were published as well.
        self._frames, self._waiting = FrameTree(), [*self._fixed]
        moving = {each.channel for each in self.values.of_role(RosRole.FRAMES)}
        if moving:
            back = self._bag.messages(max(0, stamp - _BACK_NS), stamp, moving, reverse=True)
            self._waiting += [*itertools.islice(back, _MOST_BACK)][::-1]
        for reader in self._batteries.values():
            reader.restart()
        self._find_map(stamp)

    def take(self, message: LoggedMessage) -> None:
        """Take the next message."""
        self.values.newest[message.channel] = message
        role = self._roles.get(message.channel)
        if role is RosRole.FRAMES:
            self._waiting.append(message)
            del self._waiting[: -2 * _MOST_BACK]
        elif message.channel in self._maps or message.channel in self._changes:
            self._take_map(message)

    def scene(self) -> RosScene:
        """All that is known now."""
        values = self.values
        for message in self._waiting:
            values.converted(message, self._frames.take)
        self._waiting.clear()
        fixed = motion.fixed_frame(values, self._frames, self._map_frame)
        scans = self._scans()
        pictures = self._pictures()
        made = {name: values.first(convert, role) for role, (name, convert) in _SIMPLE.items()}
        made[IMU.name] = values.first(
            lambda value: messages.imu(value, motion.mount(values, self._frames, value)),
            RosRole.IMU,
        )
        made[BATTERY.name] = battery = self._battery()
        made[ROBOT_STATE.name] = motion.robot_state(values, self._frames, fixed, battery)
        made[NAVIGATION_STATUS.name] = values.first(
            lambda value: motion.path_ahead(value, self._frames, fixed), RosRole.PATH
        )
        if scans:
            readings = RangeReadings(scans=tuple(scan.value[1] for _, scan in scans))
            newest = max(scan.stamp for _, scan in scans)
            made[RANGES.name] = ShownMessage(value=readings, stamp=newest)
        body = self._body(scans)
        made[ROBOT_DESCRIPTION.name] = ShownMessage(value=body, stamp=self._bag.start)
        problems = self._problems()
        made[DIAGNOSTICS.name] = max(problems.values(), key=lambda each: each.stamp, default=None)
        return RosScene(
            messages={name: each for name, each in made.items() if each is not None},
            problems=problems,
            pictures=pictures,
            map=self._shown_map(),
        )

    def _battery(self) -> ShownMessage | None:
        """The newest message of the preferred battery."""
        found = (self.values.shown(each, by.read) for each, by in self._batteries.items())
        return next((each for each in found if each is not None), None)

    def _channels_of_changes(self) -> set[int]:
        """The topics with changes of the shown map."""
        names = {f"{self.values.name(channel)}_updates" for channel in self._maps}
        changes = (each.channel for each in self.values.of_role(RosRole.MAP_CHANGE))
        return {channel for channel in changes if self.values.name(channel) in names}

    def _find_map(self, stamp: int) -> None:
        """Make the map at a time: the newest whole one, and its changes since then."""
        self._grid = None
        whole = next(
            (self.values.newest[each] for each in self._maps if each in self.values.newest), None
        )
        if whole is None:
            return
        self._take_map(whole)
        if self._changes:
            since = self._bag.messages(whole.stamp, stamp, self._changes)
            for message in itertools.islice(since, _MOST_CHANGES):
                self._take_map(message)

    def _take_map(self, message: LoggedMessage) -> None:
        grid = self._grid
        if message.channel in self._maps:
            made = self.values.converted(message, self._whole_map)
        elif grid is not None:
            made = self.values.converted(message, grid.value.updated)
        else:
            return
        if made is not None:
            self._grid = ShownMessage(value=made, stamp=message.stamp)

    def _shown_map(self) -> ShownMessage | None:
        """The map with its rows along x of its frame; each is turned once."""
        grid = self._grid
        if grid is None:
            return None
        if self._map is None or self._map[0] is not grid:
            try:
                shown = ShownMessage(value=grid.value.on_axes(), stamp=grid.stamp)
            except RosMessageError as error:
                self.values.note(self._maps[0], error)
                shown = None
            self._map = grid, shown
        return self._map[1]

    def _whole_map(self, value: RosValue) -> RosGrid:
        self._map_frame = plain_frame(str(value.get("header.frame_id")))
        return RosGrid.of(value)

    def _scans(self) -> list[tuple[str, ShownMessage]]:
        """Name, sensor and newest readings of each topic of ranges, and their frame."""
        found = []
        for role, convert in _SENSORS.items():
            for each in self.values.of_role(role)[: MOST_PARTS // 2]:

                def converted(
                    value: RosValue,
                    name: str = each.name,
                    convert: Callable[[RosValue, str], tuple[RangeGroup, LaserScan]] = convert,
                ) -> tuple[RangeGroup, LaserScan, str]:
                    return *convert(value, name), plain_frame(str(value.get("header.frame_id")))

                made = self.values.shown(each.channel, converted)
                if made is not None:
                    found.append((each.name, made))
        return found

    def _body(
        self,
        scans: Sequence[tuple[str, ShownMessage]],
    ) -> RobotBody:
        """The body: its sensors where the frames say."""
        base = motion.base_frame(self.values, self._frames)
        frames = []
        for name, scan in scans:
            place = self._frames.place(scan.value[2], base)
            if place is not None:
                (roll, pitch, yaw), (x, y, z) = place.roll_pitch_yaw, place.origin.tolist()
                frames.append(BodyFrame(name=name, x=x, y=y, z=z, roll=roll, pitch=pitch, yaw=yaw))
        body = RobotBody(
            name=self._name,
            kind="recording of ROS 2",
            radius=USUAL_RADIUS,
            frames=tuple(frames),
            ranges=tuple(scan.value[0] for _, scan in scans),
            cameras=tuple(
                CameraBody(name=each.name, horizontal_fov=self._fov(each.channel))
                for each in self.cameras
            ),
        )
        # The same body again, so that what was made of it counts further.
        if self._body_known is None or self._body_known != body:
            self._body_known = body
        return self._body_known

    def _pictures(self) -> dict[str, RosPicture]:
        """The newest picture of each camera, the main one first."""
        shown: dict[str, RosPicture] = {}
        for each in self.cameras:
            message = self.values.newest.get(each.channel)
            if message is not None:
                shown[each.name] = RosPicture(
                    camera=each.name,
                    role=each.role,
                    message=message,
                    decoder=self.values.decoders[each.channel],
                    horizontal_fov=self._fov(each.channel),
                )
        return shown

    def _fov(self, channel: int) -> float:
        """The field of view of a topic's camera, by the camera_info beside it [rad]."""
        folder = self.values.name(channel).rpartition("/")[0]
        for each in self.values.of_role(RosRole.CAMERA_INFO):
            beside = self.values.name(each.channel).rpartition("/")[0]
            if beside in (folder, folder.rpartition("/")[0]):
                found = self.values.shown(each.channel, messages.field_of_view)
                if found is not None and math.isfinite(found.value):
                    return float(found.value)
        return _USUAL_FOV

    def _problems(self) -> dict[int, ShownMessage]:
        found = {
            each.channel: self.values.shown(each.channel, messages.diagnostics)
            for each in self.values.of_role(RosRole.PROBLEMS)
        }
        return {channel: each for channel, each in found.items() if each is not None}
