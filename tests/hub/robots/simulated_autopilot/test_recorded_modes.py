"""A simulated autopilot takes and refuses modes as recorded ones did, in the same words.

`modes_KIND.json.gz` has the answers of a recorded vehicle to each mode: disarmed without and with a
place, to arming in it, and armed.
"""

import gzip
import json
from pathlib import Path

import pytest

from tests.support.simulated_station import NEUTRAL, World

FOLDER = Path(__file__).parents[3] / "data" / "mavlink"
RESULTS = {0: "ACCEPTED", 4: "FAILED"}
START = {"rover": 0, "sub": 19, "blimp": 1}
OTHERS = ("EKF", "GPS", "Field Elevation Set", "Internal Errors")
"""Texts that have another reason than a mode."""


class ModeAsker:
    """Asks a vehicle for modes, and to arm."""

    def __init__(self, kind, depth=10.0):
        self.world = World(kind, fast=False, depth=depth if kind == "sub" else 0.0)
        self.vehicle = self.world.autopilot.vehicle
        self.station = self.world.station()
        self.station.stream(NEUTRAL[kind])

    def ask(self, act):
        """The result of an act, and what the vehicle says."""
        self.world.wait(0.1)
        self.station.frames.clear()
        result = act()
        self.world.wait(0.06)
        return RESULTS[result], [text for text in self.station.texts() if ours(text)]

    def mode(self, number):
        answer, texts = self.ask(lambda: self.station.mode(number))
        return {"ack": answer, "entered": self.vehicle.mode == number, "texts": texts}


def ours(text):
    return not any(other in text for other in OTHERS)


def recorded(answer):
    return answer | {"texts": [text for text in answer["texts"] if ours(text)]}


@pytest.mark.parametrize("kind", START)
def test_each_mode_is_taken_or_refused_as_recorded(kind):
    modes = json.loads(gzip.decompress((FOLDER / f"modes_{kind}.json.gz").read_bytes()))
    asker = ModeAsker(kind)
    asker.world.wait(8.0)
    for number, said in modes.items():
        asker.vehicle.set_mode(START[kind])
        assert asker.mode(int(number)) == recorded(said["disarmed_no_position"]), number
    asker.world.wait(40.0)
    for number, said in modes.items():
        asker.vehicle.set_mode(START[kind])
        assert asker.mode(int(number)) == recorded(said["disarmed_with_position"]), number
        if said["arms"] is not None:
            answer, texts = asker.ask(asker.station.arm)
            assert {"ack": answer, "texts": texts} == recorded(said["arms"]), number
            asker.vehicle.disarm()
    asker.vehicle.set_mode(START[kind])
    asker.ask(asker.station.arm)
    for number, said in modes.items():
        asker.vehicle.set_mode(START[kind])
        assert asker.mode(int(number)) == recorded(said["armed_with_position"]), number


def test_a_mode_that_is_asked_for_during_the_start_is_accepted_and_forgotten():
    asker = ModeAsker("rover")
    asker.world.wait(1.5)
    assert asker.station.mode(15) == 0
    asker.world.wait(2.0)
    assert asker.station.beat()["custom_mode"] == 0


@pytest.mark.parametrize(
    ("kind", "mode", "times"),
    [
        ("rover", 0, (23, 25)),
        ("rover", 15, (41, 43)),
        ("blimp", 1, (23, 25)),
        ("blimp", 2, (42, 43)),
        ("sub", 19, (0, 3)),
    ],
)
def test_it_arms_after_the_recorded_time(kind, mode, times):
    asker = ModeAsker(kind)
    began = asker.world.now
    asker.world.wait(3.0 if kind != "sub" else 0.2)
    asker.vehicle.set_mode(mode)
    while asker.station.arm() != 0:
        asker.world.wait(0.5)
        assert asker.world.now - began < 60.0
        asker.vehicle.set_mode(mode)
    assert times[0] < asker.world.now - began < times[1]
