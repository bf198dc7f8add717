"""Velocities go out at once, again while the robot moves, and end some time after a zero."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from hub.gcm.geometry import Twist
from hub.robots.ros.command_stream import PERIOD_S, ZEROS, CommandStream

AHEAD, ZERO = Twist.planar(0.4, 0.0), Twist()
TICK = 0.01


class Wire:
    """A stream, its time, and what it sent."""

    def __init__(self, *, hold=False):
        self.stream = CommandStream(hold=hold)
        self.now = 100.0
        self.sent = []

    def command(self, velocity):
        self.stream.command(velocity, self.now)
        self.look()

    def look(self):
        velocity = self.stream.take(self.now)
        if velocity is not None:
            self.stream.sent(self.now)
            self.sent.append((self.now, velocity))

    def run(self, seconds):
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.now += TICK
            self.look()


def test_nothing_is_sent_before_the_first_zero_and_nothing_for_it():
    wire = Wire()
    wire.command(AHEAD)
    wire.run(1.0)
    assert not wire.sent
    wire.command(ZERO)
    wire.run(1.0)
    assert not wire.sent
    wire.command(AHEAD)
    assert wire.sent == [(wire.now, AHEAD)]


def test_a_velocity_goes_on_twenty_times_a_second():
    wire = Wire()
    wire.command(ZERO)
    wire.command(AHEAD)
    wire.run(2.0)
    assert 39 <= len(wire.sent) <= 41
    assert {velocity for _, velocity in wire.sent} == {AHEAD}


def test_a_zero_is_sent_at_once_and_twenty_times_more_and_then_nothing():
    wire = Wire()
    wire.command(ZERO)
    wire.command(AHEAD)
    wire.run(0.52)
    wire.sent.clear()
    began = wire.now
    wire.command(ZERO)
    assert wire.sent == [(began, ZERO)]
    for _ in range(500):  # the driver and navigation say zero all the time
        wire.command(ZERO)
        wire.run(TICK)
    assert [velocity for _, velocity in wire.sent] == [ZERO] * (ZEROS + 1)
    assert math.isclose(wire.sent[-1][0] - began, ZEROS * PERIOD_S, abs_tol=2 * TICK)


def test_a_base_that_keeps_its_velocity_gets_zeros_for_ever():
    wire = Wire(hold=True)
    wire.run(0.5)
    assert not wire.sent
    wire.command(ZERO)
    wire.run(10.0)
    assert 199 <= len(wire.sent) <= 202


def test_a_velocity_that_could_not_leave_is_due_until_it_leaves():
    stream = CommandStream(hold=False)
    stream.command(ZERO, 0.0)
    stream.command(AHEAD, 0.0)
    stream.sent(0.0)
    stream.command(ZERO, 0.01)
    assert stream.take(0.01) == ZERO
    assert stream.take(0.5) == ZERO
    stream.sent(0.5)
    assert stream.take(0.51) is None or stream.wanted == ZERO


def test_after_a_loss_the_robot_is_stopped_and_waits_for_a_zero():
    wire = Wire()
    wire.command(ZERO)
    wire.command(AHEAD)
    wire.run(0.3)
    wire.stream.interrupt(wire.now)
    wire.sent.clear()
    wire.command(AHEAD)
    assert [velocity for _, velocity in wire.sent] == [ZERO]
    wire.run(3.0)
    wire.command(AHEAD)
    assert [velocity for _, velocity in wire.sent] == [ZERO] * (ZEROS + 1)
    wire.command(ZERO)
    wire.command(AHEAD)
    assert wire.sent[-1][1] == AHEAD


STEPS = st.lists(
    st.tuples(
        st.sampled_from(["command", "interrupt", "wait"]),
        st.sampled_from([ZERO, AHEAD, Twist.planar(0.0, 1.0)]),
        st.floats(0.0, 0.4),
    ),
    max_size=40,
)


@given(STEPS, st.booleans())
@settings(max_examples=200)
def test_what_is_sent_was_commanded_and_movement_ends_with_zeros(steps, hold):
    wire = Wire(hold=hold)
    ready, wanted = False, ZERO
    for what, velocity, seconds in steps:
        if what == "interrupt":
            wire.stream.interrupt(wire.now)
            ready, wanted = False, ZERO
        elif what == "command":
            ready = ready or velocity == ZERO
            wanted = velocity if ready else ZERO
            wire.command(velocity)
        count = len(wire.sent)
        wire.run(seconds)
        assert all(each == wanted for _, each in wire.sent[count:])
        assert wire.stream.wanted == wanted
        assert len(wire.sent) - count <= seconds / PERIOD_S + 2
    moved = any(velocity != ZERO for _, velocity in wire.sent)
    wire.command(ZERO)
    wire.run(2.0)
    if moved:
        assert [velocity for _, velocity in wire.sent[-ZEROS:]] == [ZERO] * ZEROS
    count = len(wire.sent)
    wire.run(1.0)
    assert (len(wire.sent) > count) is hold


def test_nothing_is_sent_while_the_robot_drives_itself_and_zeros_for_a_second_after_it():
    for hold in (False, True):
        wire = Wire(hold=hold)
        wire.command(ZERO)
        wire.command(AHEAD)
        wire.stream.leave()
        wire.sent.clear()
        wire.run(3.0)
        assert not wire.sent
        assert wire.stream.wanted == ZERO
        wire.stream.take_back(wire.now)
        wire.run(3.0)
        assert {velocity for _, velocity in wire.sent} == {ZERO}
        assert (len(wire.sent) == ZEROS + 1) is not hold
        wire.stream.leave()
        wire.sent.clear()
        wire.command(AHEAD)
        assert [velocity for _, velocity in wire.sent] == [AHEAD]
