"""A simulated autopilot starts, streams and drives as measured on ArduPilot's simulator."""

import json
from collections import Counter
from pathlib import Path

import pytest

from hub.robots.mavlink.wire.definitions import BY_NAME
from tests.support.mavlink_numbers import (
    ACRO,
    BLIMP_LOITER,
    BLIMP_VELOCITY,
    DEPTH_HOLD,
    GUIDED,
    POSITION_HOLD,
    SUB_GUIDED,
)
from tests.support.simulated_station import NEUTRAL, World, blimp_sticks, velocity

RATES = json.loads((Path(__file__).parents[3] / "data" / "mavlink" / "rates.json").read_text())
RESULTS = {0: "ACCEPTED", 2: "DENIED"}
COUNTED_S = 5.0
each_kind = pytest.mark.parametrize("kind", RATES)


def streams(world, station):
    """Rates of the messages [Hz]."""
    station.frames.clear()
    world.wait(COUNTED_S)
    counted = Counter(
        frame["name"] if frame.name == "NAMED_VALUE_FLOAT" else frame.name
        for frame in station.frames
        if frame.name not in ("HEARTBEAT", "STATUSTEXT", "TIMESYNC")
    )
    return {name: round(count / COUNTED_S) for name, count in counted.items()}


def expected(rates):
    """The same of the recorded vehicle; it sent nine named values together."""
    return {name: rate for name, rate in rates.items() if name != "NAMED_VALUE_FLOAT"}


def unnamed(rates):
    """Without named values."""
    return {name: rate for name, rate in rates.items() if name in BY_NAME}


@each_kind
def test_its_first_heartbeat_and_streams_come_as_recorded(kind):
    world = World(kind, fast=False)
    station = world.station()
    began = world.now
    while not station.of("HEARTBEAT"):
        world.wait(0.02)
    assert world.now - began == pytest.approx(RATES[kind]["heard"], abs=0.1)
    world.wait(25.0)
    sent = streams(world, station)
    assert unnamed(sent) == expected(RATES[kind]["unasked"])
    assert len(sent) - len(unnamed(sent)) == (9 if kind == "sub" else 0)
    world.wait(43.0 if kind == "blimp" else 0.0)  # the recorded one knew its place before
    fields = {"target_system": 1, "target_component": 1, "req_message_rate": 4, "start_stop": 1}
    station.send("REQUEST_DATA_STREAM", fields)
    assert unnamed(streams(world, station)) == expected(RATES[kind]["all4"])


@each_kind
def test_rates_are_taken_and_denied_as_recorded(kind):
    world = World(kind)
    station = world.station()
    world.wait(2.0)
    for name, (answer, rate) in RATES[kind]["asked40"].items():
        number = BY_NAME[name].number if name in BY_NAME else 9999
        assert RESULTS[station.command(511, number, 25_000.0)] == answer, name
        station.frames.clear()
        world.wait(1.0)
        assert len(station.of(name)) == pytest.approx(rate, abs=5), name
        station.command(511, number, -1.0)


# How it drives: each row is a mode, a message, and the velocity that was measured.


def sub_sticks(**axes):
    return ("MANUAL_CONTROL", {"target": 1, "z": 500, **axes})


def rover_sticks(**axes):
    return ("MANUAL_CONTROL", {"target": 1, **axes})


DRIVES = (
    ("rover", GUIDED, velocity(1.0), {"ahead": 1.03}),
    ("rover", GUIDED, velocity(0.3), {"ahead": 0.32}),
    ("rover", GUIDED, velocity(0.1), {"ahead": 0.12}),
    ("rover", GUIDED, velocity(-1.0), {"ahead": -0.99}),
    ("rover", GUIDED, velocity(0.3, 0.3), {"ahead": 0.32, "turn": 0.30}),
    ("rover", GUIDED, velocity(0.0, 0.5), {"ahead": 0.0, "turn": 0.50}),
    ("rover", GUIDED, velocity(9.0), {"ahead": 2.0}),
    ("rover", ACRO, rover_sticks(z=300), {"ahead": 1.02}),
    ("rover", ACRO, rover_sticks(y=500), {"turn": 1.47}),
    ("sub", POSITION_HOLD, sub_sticks(x=500), {"ahead": 0.26, "right": 0.0}),
    ("sub", POSITION_HOLD, sub_sticks(x=1000), {"ahead": 0.77}),
    ("sub", POSITION_HOLD, sub_sticks(y=500), {"right": 0.26, "ahead": 0.0}),
    ("sub", POSITION_HOLD, sub_sticks(z=750), {"sinking": -0.19}),
    ("sub", POSITION_HOLD, sub_sticks(z=250), {"sinking": 0.19}),
    ("sub", POSITION_HOLD, sub_sticks(r=500), {"turn": 0.59}),
    ("sub", DEPTH_HOLD, sub_sticks(x=500), {"ahead": 0.52}),
    ("sub", DEPTH_HOLD, sub_sticks(x=166), {"ahead": 0.19}),
    ("sub", DEPTH_HOLD, sub_sticks(x=120), {"ahead": 0.0}),
    ("sub", SUB_GUIDED, velocity(vz=0.2), {"sinking": 0.20}),
    ("sub", SUB_GUIDED, velocity(vz=-0.2), {"sinking": -0.20}),
    ("blimp", BLIMP_VELOCITY, blimp_sticks(c2=2000), {"ahead": 0.22, "right": 0.0}),
    ("blimp", BLIMP_VELOCITY, blimp_sticks(c2=1000), {"ahead": -0.22}),
    ("blimp", BLIMP_VELOCITY, blimp_sticks(c1=2000), {"right": 0.22, "ahead": 0.0}),
    ("blimp", BLIMP_VELOCITY, blimp_sticks(c3=2000), {"sinking": -0.19}),
    ("blimp", BLIMP_VELOCITY, blimp_sticks(c4=2000), {"turn": 0.38}),
    ("blimp", BLIMP_LOITER, blimp_sticks(c2=2000), {"ahead": 0.15}),
)
LEAST = 0.02
"""Measured speeds have two digits, and a slow rover was faster than it was asked [m/s]."""


@pytest.mark.parametrize(("kind", "mode", "message", "measured"), DRIVES)
def test_it_drives_as_fast_and_as_far_around_as_measured(kind, mode, message, measured):
    world = World(kind, depth=9.0 if kind == "sub" else 0.0)
    station = world.station()
    station.stream(NEUTRAL[kind])
    world.wait(2.0)
    assert station.mode(mode) == 0
    assert station.arm() == 0
    station.stream(NEUTRAL[kind], message)
    world.wait(6.0)
    for name, speed in measured.items():
        assert getattr(world.motion.state, name) == pytest.approx(speed, rel=0.1, abs=LEAST), name
