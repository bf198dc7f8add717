"""A simulated autopilot moves a body of the simulator, in the frames of MAVLink."""

import math

import pytest

from hub.robots.registry import kind_of
from hub.robots.robot_file import find_robot_file, read_description
from hub.robots.simulated_autopilot.arena_motion import ArenaMotion
from hub.robots.simulated_autopilot.kinds import AUTOPILOT_KINDS, robot_file
from hub.robots.simulated_autopilot.motion import Demand, DemandKind
from hub.sim.arena import load_arena

BODIES = {"rover": ("magellan", "empty"), "sub": ("rov", "pool"), "blimp": ("blimp", "empty")}


def moved(vehicle, seconds=3.0, **demand):
    """The motion of a vehicle after a demand."""
    name, arena = BODIES[vehicle]
    robot, _ = read_description(find_robot_file(name), [f"simulation.arena={arena}"])
    water = load_arena(arena).water
    motion = ArenaMotion(kind_of(robot).open_body(robot), water.surface if water else 0.0)
    start = motion.state.down, motion.state.yaw
    for _ in range(round(seconds / 0.02)):
        motion.step(Demand(**{"kind": DemandKind.VELOCITY} | demand), 0.02)
    return motion.state, start


def test_velocities_have_the_signs_of_ned_and_frd():
    state, _ = moved("rover", ahead=0.3)
    assert state.ahead == pytest.approx(0.3, abs=0.02)
    assert math.atan2(state.east, state.north) == pytest.approx(state.yaw, abs=0.05)
    state, (_, yaw) = moved("rover", seconds=1.0, turn=0.5)
    assert math.remainder(state.yaw - yaw, math.tau) > 0.2
    state, (depth, _) = moved("sub", down=0.2)
    assert state.sinking == pytest.approx(0.2, abs=0.05)
    assert 0.3 < state.down - depth < 0.7
    state, _ = moved("sub", right=0.2)
    assert state.right == pytest.approx(0.2, abs=0.05)
    state, (height, _) = moved("blimp", down=-0.1)
    assert height < -0.5  # it starts in the air
    assert state.down < height - 0.05


def test_without_power_it_does_not_follow():
    state, _ = moved("blimp", kind=DemandKind.OFF, ahead=0.2)
    assert abs(state.ahead) < 0.02


@pytest.mark.parametrize("kind", AUTOPILOT_KINDS)
def test_each_has_a_robot_file_without_mistakes(kind):
    robot, problems = read_description(robot_file(kind))
    assert not problems
    assert robot.has_autopilot
    assert robot.simulated
    assert robot.base.value in (BODIES[kind][0], "wheels")
