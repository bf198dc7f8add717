"""What each camera of a robot sees of the ground, from above.

| the camera | its state is that of |
| --- | --- |
| the main one | its newest message |
| shown in a viewport | its newest picture |
| fixed | the description |
| another one with a head | not known: it has no cone |
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Hashable, Iterator
from typing import Final

import numpy as np

from hub.gcm.body import CameraBody, RobotBody
from hub.gcm.frames import in_base
from hub.gcm.vision import CameraState
from hub.values import dataclass
from rune_tui.layout.spec import CHOSEN
from rune_tui.model.cameras import MAIN, camera_names, camera_of
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.geometry import PictureGeometry
from rune_tui.model.robot_state import RobotState
from rune_tui.model.sightings import Floats

_FAR_M: Final = 2.0
"""Length of the cone of a robot that stands [m]."""
_FARTHEST_M: Final = 8.0
_FAR: Final = 2.0
"""Length of the cone of a robot that flies, as a multiple of the distance to its nearest ground."""
_STEPS: Final = 9
_STEEP: Final = math.sin(math.radians(60.0))
"""A camera that looks down or up more steeply has no direction."""
_SHAPE: Final = (4, 3)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ViewCone:
    """What one camera sees.

    Attributes:
        outline: Corners of the ground in the picture, in the robot's frame [m], shape (n, 2).
        sides: The lines at its sides [m], shape (m, 2).
        bearing: The camera's direction from straight ahead [rad]; NaN: it looks down or up.
        width: Its field of view [rad].
        chosen: Whether viewports with the camera `*` show it.
    """

    outline: Floats
    sides: Floats
    bearing: float
    width: float
    chosen: bool

    def seen_at(self, turn: float, step: float) -> Hashable:
        """Changes with turns of this size [rad] and steps of this size [m]."""
        bearing = None if math.isnan(self.bearing) else round(self.bearing / turn)
        edge = tuple(np.round(self.outline[:: len(self.outline) - 1] / step).ravel().tolist())
        return bearing, round(self.width / turn), edge, self.chosen


def view_cones(robot: RobotState, state: ConsoleState) -> list[ViewCone]:
    """The cones of all cameras whose direction is known, the chosen one last."""
    chosen = camera_of(CHOSEN, robot, state)
    cones = [_cone(seen, chosen=name == chosen) for name, seen in _states(robot)]
    return sorted((cone for cone in cones if cone is not None), key=lambda cone: cone.chosen)


def _states(robot: RobotState) -> Iterator[tuple[str, CameraState]]:
    """The known states of the cameras, by name; the main one's is empty."""
    main = robot.camera.value if robot.camera is not None else None
    if main is not None:
        yield MAIN, main
    body = robot.body
    if body is None:
        return
    for number, (camera, name) in enumerate(zip(body.cameras, camera_names(robot), strict=True)):
        if not number:
            if main is None and (known := _fixed(camera, body, None)) is not None:
                yield MAIN, known
        elif (picture := robot.pictures.get(name)) is not None:
            yield name, picture.value.camera
        elif (known := _fixed(camera, body, main)) is not None:
            yield name, known


def _fixed(camera: CameraBody, body: RobotBody, main: CameraState | None) -> CameraState | None:
    """The state of a camera that cannot turn; None: it can, or its place is not described."""
    frame = in_base(body.frames, camera.name)
    if frame is None or camera.pan_limit or camera.tilt_lowest != camera.tilt_highest:
        return None
    state = CameraState(
        stamp=0.0,
        pan=0.0,
        tilt=camera.tilt_lowest,
        zoom=0.0,
        horizontal_fov=camera.horizontal_fov,
        vertical_fov=camera.horizontal_fov,
        mount_forward=frame.x,
        mount_left=frame.y,
        mount_height=frame.z,
        mount_yaw=frame.yaw,
        mount_pitch=frame.pitch,
        mount_roll=frame.roll,
        pan_limit=0.0,
        tilt_limit=0.0,
        slewing=0,
    )
    if main is None:
        return state
    return dataclasses.replace(
        state,
        robot_roll=main.robot_roll,
        robot_pitch=main.robot_pitch,
        robot_above_ground=main.robot_above_ground,
    )


def _cone(camera: CameraState, *, chosen: bool) -> ViewCone | None:
    middle, width = camera.pan + camera.mount_yaw, camera.horizontal_fov
    apex = np.array((camera.mount_forward, camera.mount_left))
    turns = (middle, camera.tilt, camera.mount_pitch, camera.mount_roll)
    if not (np.isfinite((*turns, *apex)).all() and 0.0 < width < math.tau):
        return None
    upright = camera.stands and camera.mount_pitch == camera.mount_roll == 0.0
    geometry = None
    if not upright or abs(math.sin(camera.tilt)) > _STEEP:  # the rest would only cost time
        geometry = PictureGeometry.of(camera, *_SHAPE)
    steep = geometry is not None and abs(geometry.axes[2]) > _STEEP
    bearing = math.nan if steep else middle
    if geometry is not None and (steep or not camera.stands):
        footprint = _footprint(geometry)
        if footprint is not None:
            closed = np.concatenate((footprint, footprint[:1]))
            return ViewCone(
                outline=footprint, sides=closed, bearing=bearing, width=width, chosen=chosen
            )
    if steep:
        return None
    fan = np.linspace(middle - width / 2.0, middle + width / 2.0, _STEPS)
    rim = apex + _FAR_M * np.stack((np.cos(fan), np.sin(fan)), axis=1)
    return ViewCone(
        outline=np.concatenate((apex[None], rim)),
        sides=np.stack((rim[0], apex, rim[-1])),
        bearing=bearing,
        width=width,
        chosen=chosen,
    )


def _footprint(geometry: PictureGeometry) -> Floats | None:
    """The ground in the picture, cut where it is far; None: it shows none."""
    width, height = _SHAPE
    steps = np.linspace(0.0, 1.0, _STEPS)
    low, high = np.zeros_like(steps), np.ones_like(steps)
    around = ((steps, low), (high, steps), (steps[::-1], high), (low, steps[::-1]))
    pixels = np.concatenate([np.stack((x * width, y * height), axis=1) for x, y in around])
    found = geometry.ground(pixels)
    if not found.on_ground.any():
        return None
    away = found.points - geometry.mount
    distance = np.where(found.on_ground, np.hypot(away[:, 0], away[:, 1]), np.inf)
    far = min(_FARTHEST_M, max(_FAR_M, _FAR * float(distance.min())))
    bearing = geometry.mount_angles(geometry.image_angles(pixels))[:, 0]
    reach = np.minimum(distance, far)[:, None]
    outline: Floats = geometry.mount + reach * np.stack((np.cos(bearing), np.sin(bearing)), axis=1)
    return outline
