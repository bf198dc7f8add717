"""What the cameras of a robot see of the ground."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from hub.gcm.body import ROBOT_DESCRIPTION, BodyFrame, CameraBody, RobotBody
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Picture, RobotState
from rune_tui.model.view_cones import ViewCone, view_cones
from tests.console.visualizers.conftest import Made, received
from tests.support.car import CAR
from tests.support.messages import camera_state

STATE = ConsoleState(now=100.0)
REAR = CameraBody(name="rear", horizontal_fov=1.2)
HEAD = CameraBody(name="head", horizontal_fov=1.2, pan_limit=1.0)


def body(*more: CameraBody) -> RobotBody:
    frames = (
        BodyFrame(name="front", x=0.2, z=0.3),
        BodyFrame(name="rear", x=-0.2, z=0.3, yaw=math.pi),
        BodyFrame(name="head", z=0.5),
    )
    front = CameraBody(name="front", horizontal_fov=1.0, pan_limit=1.5)
    return dataclasses.replace(CAR, cameras=(front, *more), frames=frames)


def robot(*more: CameraBody, **main: Any) -> RobotState:
    """A robot with the main camera `front` and more; only `front` reports its state."""
    state = camera_state(**{"name": "front", "mount_forward": 0.2, "tilt": 0.0} | main)
    messages = {ROBOT_DESCRIPTION.name: received(body(*more))}
    return Made().robot(camera=received(state), messages=messages)


def by_bearing(cones: list[ViewCone]) -> dict[int, ViewCone]:
    return {round(math.degrees(cone.bearing)) % 360: cone for cone in cones}


def test_each_camera_with_a_known_direction_has_a_cone_and_the_chosen_one_is_strong() -> None:
    cones = by_bearing(view_cones(robot(REAR, HEAD, pan=0.5), STATE))
    assert {each: cone.chosen for each, cone in cones.items()} == {29: True, 180: False}
    assert cones[180].width == pytest.approx(1.2)
    assert cones[180].outline[0] == pytest.approx((-0.2, 0.0))
    chosen = dataclasses.replace(STATE, cameras={robot().name: "rear"})
    assert by_bearing(view_cones(robot(REAR, pan=0.5), chosen))[180].chosen


def test_a_camera_with_a_head_is_where_its_newest_picture_looked() -> None:
    seen = camera_state(name="head", pan=-1.0, tilt=0.0)
    picture = Picture(pixels=np.zeros((3, 4, 3), np.uint8), camera=seen)
    known = robot(HEAD).with_(pictures={"head": received(picture)})
    assert {*by_bearing(view_cones(known, STATE))} == {0, 303}


def test_a_camera_that_looks_straight_down_from_the_air_sees_the_ground_around_the_robot() -> None:
    (cone,) = view_cones(robot(tilt=-math.pi / 2.0, robot_above_ground=2.0), STATE)
    assert math.isnan(cone.bearing)
    low, high = cone.outline.min(axis=0), cone.outline.max(axis=0)
    assert (low < 0.0).all()
    assert (high > 0.0).all()
    half = (2.0 + camera_state().mount_height) * math.tan(cone.width / 2.0)
    assert high[1] == pytest.approx(half, rel=0.01)


def test_a_camera_that_looks_ahead_from_the_air_sees_ground_beyond_its_blind_spot() -> None:
    (cone,) = view_cones(robot(tilt=-0.3, robot_above_ground=1.5), STATE)
    assert cone.outline[:, 0].min() > 1.0
    assert np.isfinite(cone.outline).all()


def test_a_cone_changes_only_by_what_is_to_be_seen() -> None:
    def token(**main: Any) -> list[object]:
        return [cone.seen_at(0.02, 0.05) for cone in view_cones(robot(**main), STATE)]

    assert token(pan=0.5) == token(pan=0.501) != token(pan=0.55)
    assert view_cones(robot(pan=math.nan), STATE) == []
