"""Joint states: names and values side by side, as sensor_msgs/JointState has them."""

from __future__ import annotations

import math

import numpy as np

from hub.gcm.joints import JOINT_STATES, JointState, JointStates
from hub.gcm.standard import Header, Time

HEADER = Header(stamp=Time(sec=3))
FRONT = JointState(name="front flippers", position=0.5, velocity=1.0)
REAR = JointState(name="rear flippers", position=-0.25)


def test_names_and_angles_pass_the_wire() -> None:
    sent = JointStates.of((FRONT, REAR), HEADER)
    received = JOINT_STATES.decode(b"".join(JOINT_STATES.encode(sent)))
    assert received.name == ("front flippers", "rear flippers")
    assert received.position_of("rear flippers") == -0.25
    assert math.isnan(received.effort[0])


def test_a_joint_without_a_reported_angle_is_not_known() -> None:
    states = JointStates(
        name=("a", "b"), position=np.ones(1), velocity=np.ones(0), effort=np.ones(0)
    )
    assert math.isnan(states.position_of("b"))
    assert math.isnan(states.position_of("c"))


def test_control_characters_in_a_name_are_not_taken() -> None:
    notes: list[str] = []
    sent = JointStates.of((JointState(name="\x1b[2J"),), HEADER)
    received = JOINT_STATES.decode(b"".join(JOINT_STATES.encode(sent)), notes.append)
    assert "\x1b" not in received.name[0]
    assert notes
