"""One camera of the robot: its pictures, its direction, its night mode."""

from __future__ import annotations

import dataclasses
import math
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator
from typing import Final

from hub.errors import CameraError
from hub.gcm import vision
from hub.gcm.body import BodyFrame
from hub.gcm.camera_info import CameraInfo
from hub.gcm.diagnostics import DiagnosticStatus, Severity
from hub.gcm.pose_history import PoseHistory
from hub.gcm.standard import Header, Time
from hub.gcm.transforms import optical_frame
from hub.modules.vision.coding import code
from hub.modules.vision.night import NightMode
from hub.modules.vision.picture import brightened, brightness, prepare
from hub.modules.vision.picture_watch import Newness, PictureWatch
from hub.modules.vision.stances import Stances
from hub.modules.vision.travel import HeadTravel, Travel
from hub.robots.cropping import vertical_fov
from hub.robots.interfaces import Camera, Picture

_MOST_SIZES: Final = 4
"""Most sizes of pictures in which repeated ones are found: one for each console."""
_SAME_S: Final = 5.0
"""Time of equal pictures after which they are reported [s]."""
_NONE_S: Final = 5.0
"""Time without pictures after which that is reported [s]: a stream needs some to begin."""
_RECENT_S: Final = 3.0
_LONGEST_NAME, _LONGEST_TEXT = 64, 1000


class CameraService:
    """Takes pictures with a camera, and knows its state."""

    def __init__(
        self,
        frame: BodyFrame,
        camera: Camera,
        poses: PoseHistory,
        stances: Stances,
        size: tuple[int, int] = (0, 0),
        clock: Callable[[], float] = time.monotonic,
        travel: Travel | None = None,
    ) -> None:
        """Take over an open camera.

        Args:
            frame: Its name and its mount on the robot, in `base_link`.
            camera: The camera itself.
            poses: The robot's poses in the last seconds.
            stances: Its tilts and heights in the last seconds.
            size: Largest width and height of a picture [px]; 0: not known.
            clock: Monotonic time [s].
            travel: Motion of the robot, which shows that pictures are repeated; None: each is new.
        """
        self._frame = frame
        self._poses = poses
        self._stances = stances
        self._size = size
        self._clock = clock
        self._night = NightMode()
        self._advanced = clock()
        self._kept: tuple[Picture, vision.CameraState] | None = None
        self._kept_size = (0, 0)
        self._due = 0.0
        self._travel, self._head = travel, HeadTravel()
        self._newness, self._asked_at = Newness(measured=math.nan), -math.inf
        self._fault, self._fault_since = "", math.inf
        self._watches: OrderedDict[tuple[int, ...], PictureWatch] = OrderedDict()
        self.camera = camera

    @property
    def name(self) -> str:
        """Its name in the robot file."""
        return self._frame.name

    def close(self) -> None:
        """Switch the headlight off and release the camera."""
        self.camera.set_headlight(0.0)
        self.camera.close()

    def advance(self) -> None:
        """Let a simulated camera move until now."""
        now = self._clock()
        self.camera.advance(now - self._advanced)
        self._advanced = now

    def picture(
        self, request: vision.ImageRequest, most_per_s: float = 0.0
    ) -> tuple[vision.Image, float]:
        """A picture as requested, and the time at which it was taken [s].

        Args:
            request: What is asked for.
            most_per_s: Limit of the rate of new pictures [1/s]; between them the last one is
                given again. 0: each is new.

        Raises:
            CameraError: There is none; the text gives the reason and the remedy.
        """
        self.advance()
        now = self._clock()
        taken, state = self._take((request.width_px, request.height_px), now, most_per_s)
        gain = self._night.see(brightness(taken.pixels), now)
        pixels = prepare(brightened(taken.pixels, gain), request.kind)
        image = vision.Image(
            camera=dataclasses.replace(state, gain=self._night.gain),
            coding=request.coding,
            width_px=pixels.shape[1],
            height_px=pixels.shape[0],
            channels=1 if pixels.ndim == 2 else pixels.shape[2],
            data=code(pixels, request.coding, request.quality),
        )
        return image, taken.measured

    def _take(
        self, size: tuple[int, int], now: float, most_per_s: float
    ) -> tuple[Picture, vision.CameraState]:
        """A new picture and the camera's state then; within the limit's time the last ones."""
        if self._kept is not None and most_per_s and now < self._due and self._kept_size == size:
            return self._kept
        self._asked_at = now
        try:
            taken = self.camera.take(*size, now)
        except CameraError as fault:
            self._fault, self._fault_since = str(fault), min(self._fault_since, now)
            raise
        self._fault, self._fault_since = "", math.inf
        self._newness = self._judged(taken)
        taken = dataclasses.replace(taken, measured=self._newness.measured)
        state = dataclasses.replace(
            self.state(taken.measured),
            horizontal_fov=taken.horizontal_fov,
            vertical_fov=vertical_fov(taken.horizontal_fov),
        )
        if most_per_s:
            period = 1.0 / most_per_s
            self._due = max(self._due, now - period) + period  # a late request delays no other
            self._kept, self._kept_size = (taken, state), size
        else:
            self._kept = None
        return taken, state

    def problems(self) -> Iterator[DiagnosticStatus]:
        """Whether there are pictures, and new ones, while clients ask for them."""
        newness, now = self._newness, self._clock()
        if now - self._asked_at > _RECENT_S:
            return
        if now - self._fault_since >= _NONE_S:
            level, text = Severity.ERROR, f"camera {self.name}: {self._fault}"[:_LONGEST_TEXT]
        elif self._fault:
            return  # a stream that begins
        elif newness.repeated:
            level, age = Severity.ERROR, now - newness.measured
            text = f"camera {self.name} repeats a picture of {age:.0f} s ago: it is frozen"
        elif newness.same_s >= _SAME_S:
            level = Severity.OK  # so is the picture of a still place without noise
            text = f"camera {self.name}: the same picture for {newness.same_s:.0f} s"
        else:
            return
        name = f"camera {self.name}"[:_LONGEST_NAME]
        yield DiagnosticStatus(level=level, name=name, message=text, hardware_id=self.name)

    def _judged(self, taken: Picture) -> Newness:
        """Whether a picture is new, or an old one with a new stamp."""
        if self._travel is None:
            return Newness(measured=taken.measured)
        self._head.moved(self.camera.camera_state(0.0))
        shape = taken.pixels.shape
        watch = self._watches.setdefault(shape, PictureWatch())
        self._watches.move_to_end(shape)
        if len(self._watches) > _MOST_SIZES:
            self._watches.popitem(last=False)
        return watch.judge(taken.pixels, taken.measured, self._travel.total + self._head.total)

    def state(self, measured: float) -> vision.CameraState:
        """Its state, with the robot's pose and stance at `measured` [s]."""
        frame, place, stance = self._frame, self._poses.at(measured), self._stances.at(measured)
        stamp = time.time() - (self._clock() - measured)
        return dataclasses.replace(
            self.camera.camera_state(stamp),
            name=frame.name,
            mount_forward=frame.x,
            mount_left=frame.y,
            mount_height=frame.z,
            mount_yaw=frame.yaw,
            mount_pitch=frame.pitch,
            mount_roll=frame.roll,
            robot_x=place.x,
            robot_y=place.y,
            robot_theta=place.theta,
            robot_roll=stance.roll,
            robot_pitch=stance.pitch,
            robot_above_ground=stance.above_ground,
            gain=self._night.gain,
        )

    def info(self) -> CameraInfo:
        """How it projects now, in pictures of its largest size."""
        self.advance()
        stamp, (width_px, height_px) = time.time(), self._size
        return CameraInfo.of(
            Header(stamp=Time.of(stamp), frame_id=optical_frame(self.name)),
            width_px=width_px,
            height_px=height_px,
            horizontal_fov=self.camera.camera_state(stamp).horizontal_fov,
        )

    def move(self, command: vision.CameraCommand) -> None:
        """Turn its head, if it has one."""
        self.advance()
        self.camera.move(command)

    def switch_night(self, command: vision.NightCommand) -> None:
        """Switch night mode, and the headlight with it."""
        self._night.command(command)
        self.camera.set_headlight(self._night.headlight)

    def light(self, brightness: float) -> None:
        """Set the headlight, 0 (off) to 1; night mode stays as it is."""
        self._night.light(brightness)
        self.camera.set_headlight(self._night.headlight)
