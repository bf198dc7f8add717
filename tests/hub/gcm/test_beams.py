"""Frames and beams of a body: where each range sensor is and looks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.beams import beams_of
from hub.gcm.body import BodyFrame, RangeGroup, RangeKind, RobotBody
from hub.gcm.frames import poses_of
from hub.gcm.orientation import rotation
from hub.gcm.ranges import RangeReadings, scan_of
from hub.gcm.standard import Time

RING = RangeGroup(
    name="ring", kind=RangeKind.SONAR, beams=4, step=math.tau / 4, ring=0.2, farthest=5.0
)
DOWN = RangeGroup(name="down", kind=RangeKind.LASER, farthest=2.0)
BODY = RobotBody(
    name="a",
    kind="b",
    radius=0.3,
    frames=(
        BodyFrame(name="ring", z=0.2),
        BodyFrame(name="mast", x=0.5, y=0.1, yaw=math.pi / 2),
        BodyFrame(name="down", parent="mast", x=0.3, pitch=math.pi / 4),
    ),
    ranges=(RING, DOWN),
)
ANGLES = st.floats(-math.pi, math.pi)


def test_beams_stand_in_the_order_of_the_description() -> None:
    beams = beams_of(BODY)
    assert beams.groups == {"ring": slice(0, 4), "down": slice(4, 5)}
    assert np.degrees(beams.bearing) == pytest.approx([0.0, 90.0, 180.0, -90.0, 90.0])
    assert np.degrees(beams.elevation) == pytest.approx([0.0, 0.0, 0.0, 0.0, -45.0], abs=1e-9)
    places = np.stack([beams.x, beams.y, beams.z])
    assert places.T[4] == pytest.approx([0.5, 0.4, 0.0])
    assert places.T[0] == pytest.approx([0.0, 0.0, 0.2])
    assert list(beams.of_kind(RangeKind.SONAR)) == [True] * 4 + [False]


def test_ranges_that_are_not_in_the_readings_or_do_not_fit_are_not_known() -> None:
    beams = beams_of(BODY)
    ring = scan_of(RING, np.array([1.0, np.inf, 3.0, 4.0], np.float32), 5.25)
    assert ring.header.stamp == Time(sec=5, nanosec=250_000_000)
    ranges = beams.ranges(RangeReadings(scans=(ring,)))
    assert list(ranges[:4]) == [1.0, math.inf, 3.0, 4.0]
    assert np.isnan(ranges[4])
    short = scan_of(RING, np.ones(3, np.float32), 6.0)
    other = scan_of(RangeGroup(name="x", kind=RangeKind.LASER, farthest=1.0), ring.ranges, 6.0)
    assert np.isnan(beams.ranges(RangeReadings(scans=(short, other)))).all()


def test_a_body_without_range_sensors_has_no_beams() -> None:
    beams = beams_of(RobotBody(name="a", kind="b", radius=0.3))
    assert len(beams.bearing) == len(beams.ranges(RangeReadings(scans=()))) == 0


@given(roll=ANGLES, pitch=ANGLES, yaw=ANGLES)
def test_a_rotation_keeps_lengths_and_turns_yaw_first(
    roll: float, pitch: float, yaw: float
) -> None:
    turn = rotation(roll, pitch, yaw)
    assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    steps = rotation(0.0, 0.0, yaw) @ rotation(0.0, pitch, 0.0) @ rotation(roll, 0.0, 0.0)
    assert turn == pytest.approx(steps, abs=1e-12)


def test_frames_add_up_along_their_parents() -> None:
    poses = poses_of(BODY.frames)
    turn, origin = poses["down"]
    assert origin == pytest.approx([0.5, 0.4, 0.0])
    assert turn @ (1.0, 0.0, 0.0) == pytest.approx([0.0, math.sqrt(0.5), -math.sqrt(0.5)])
