"""Cameras for tests of geometry."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import strategies as st

from hub.gcm.vision import CameraState
from rune_tui.model.geometry import PictureGeometry

WIDE = math.radians(48.8)
TELE = math.radians(4.3)


def camera(**changes: Any) -> CameraState:
    """A camera of the Magellan's: straight ahead, wide, on a robot at the map's origin."""
    values: dict[str, Any] = {
        "stamp": 0.0,
        "pan": 0.0,
        "tilt": 0.0,
        "zoom": 0.0,
        "horizontal_fov": WIDE,
        "vertical_fov": math.nan,
        "mount_forward": 0.05,
        "mount_height": 0.37,
        "pan_limit": 1.7,
        "tilt_limit": 0.44,
        "slewing": 0,
        "robot_x": 0.0,
        "robot_y": 0.0,
        "robot_theta": 0.0,
    }
    return CameraState(**values | changes)


def geometry(width: int = 160, height: int = 120, **changes: Any) -> PictureGeometry:
    found = PictureGeometry.of(camera(**changes), width, height)
    assert found is not None
    return found


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


CAMERAS = st.builds(
    camera,
    pan=numbers(-math.pi, math.pi),
    tilt=numbers(-1.5, 1.5),
    horizontal_fov=numbers(TELE, 2.0),
    mount_forward=numbers(-0.5, 0.5),
    mount_height=numbers(0.1, 3.0),
    robot_x=numbers(-50.0, 50.0),
    robot_y=numbers(-50.0, 50.0),
    robot_theta=numbers(-math.pi, math.pi),
)
FLYING = st.builds(
    camera,
    pan=numbers(-math.pi, math.pi),
    tilt=numbers(-1.5, 1.5),
    horizontal_fov=numbers(0.3, 2.0),
    mount_forward=numbers(-0.5, 0.5),
    mount_height=numbers(-0.3, 0.3),
    mount_pitch=numbers(-0.5, 0.5),
    mount_roll=numbers(-0.5, 0.5),
    robot_roll=numbers(-0.6, 0.6),
    robot_pitch=numbers(-0.6, 0.6),
    robot_above_ground=numbers(1.0, 30.0),
)
"""Cameras of robots that fly, tilted."""
SIZES = st.sampled_from([(160, 120), (320, 240), (160, 90), (90, 160), (1, 1)])
