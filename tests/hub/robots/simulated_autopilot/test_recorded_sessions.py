"""A simulated autopilot does what recorded ones did with the same commands."""

import functools
import gzip
import itertools
import json
import math
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.simulated_station import TICK, World

FOLDER = Path(__file__).parents[3] / "data" / "mavlink"
SETTINGS = {
    "rover": {"SIM_RC_FAIL": 1, "FS_GCS_ENABLE": 1, "FS_GCS_TIMEOUT": 2, "RC_OVERRIDE_TIME": 0.5},
    "sub": {"FS_GCS_ENABLE": 4, "FS_GCS_TIMEOUT": 2, "FS_PILOT_INPUT": 1, "FS_PILOT_TIMEOUT": 0.5},
    "blimp": {"RC_OVERRIDE_TIME": 0.5},
}
AXES = ("ahead", "right", "down", "turn")
STILL = 0.05
ARMED_S = 42.0
"""All of them were armed then."""
each_kind = pytest.mark.parametrize("kind", SETTINGS)


def messages_of(session, time, due):
    """Messages that the recorded station sent by a time, and repeats."""
    for place, (first, last, name, fields) in enumerate(session["streams"]):
        if first <= time <= last + TICK and time >= due.get(place, 0.0) - 1e-9:
            due[place] = time + (1.0 if name == "HEARTBEAT" else 0.05) - TICK
            yield name, fields


@functools.cache
def played(kind):
    """A recorded session, and what the simulated vehicle does in it."""
    session = json.loads(gzip.decompress((FOLDER / f"{kind}.json.gz").read_bytes()))
    world = World(kind, fast=False, settings=SETTINGS[kind])
    station = world.station()
    station.alive = False
    began, commands = world.now, list(session["commands"])
    due: dict[int, float] = {}
    done: dict[str, list] = {"heartbeats": [], "truth": []}
    while world.now - began < session["truth"][-1][0]:
        world.wait(TICK)
        time = world.now - began
        for name, fields in messages_of(session, time, due):
            station.send(name, fields)
        while commands and commands[0][0] <= time:
            _, number, one, two = commands.pop(0)
            fields = {"command": number, "param1": one, "param2": two}
            station.send("COMMAND_LONG", fields | {"target_system": 1, "target_component": 1})
        beat = station.of("HEARTBEAT")
        if len(beat) > len(done["heartbeats"]):
            done["heartbeats"] += [(time, frame) for frame in beat[len(done["heartbeats"]) :]]
        state = world.motion.state
        motion = state.ahead, state.right, state.sinking, state.turn, state.down
        done["truth"].append((time, *motion))
    return session, done, station


@each_kind
def test_the_answers_are_the_recorded_ones_in_order(kind):
    session, _, station = played(kind)
    answers = [(frame["command"], frame["result"]) for frame in station.of("COMMAND_ACK")]
    assert answers == [(number, result) for _, number, result in session["answers"]]
    assert len(answers) > 15


@each_kind
def test_the_texts_are_the_recorded_ones_in_order(kind):
    session, _, station = played(kind)
    texts = [
        (frame["severity"], frame["text"])
        for frame in station.of("STATUSTEXT")
        if not frame["text"].startswith("Field Elevation Set")
    ]
    assert texts == [(severity, text) for _, severity, text in session["texts"]]


@each_kind
def test_the_modes_and_states_are_the_recorded_ones_in_order(kind):
    session, done, _ = played(kind)
    shown = [(0.0, 0, 0, 0)]
    for time, frame in done["heartbeats"]:
        state = frame["base_mode"], frame["custom_mode"], frame["system_status"]
        if state != shown[-1][1:]:
            shown.append((time, *state))
    recorded = session["heartbeats"]
    if kind == "sub":  # its filters start twice, which heartbeats show for a second
        recorded = [state for state in recorded if not 2.5 < state[0] < 4.5]
    assert [state[1:] for state in shown[1:]] == [tuple(state[1:]) for state in recorded]
    for mine, its in zip(shown[1:], recorded, strict=True):
        assert mine[0] == pytest.approx(its[0], abs=0.7)  # heartbeats are a second apart


def segments(session) -> Iterator[tuple[float, float]]:
    """Times between which nothing was changed."""
    changes = [state[0] for state in session["heartbeats"]]
    for first, last, name, _ in session["streams"]:
        changes += [first, last] if name != "HEARTBEAT" else []
    kept = [ARMED_S]
    for time in sorted(changes):
        if time - kept[-1] > 0.3:
            kept.append(time)
    return ((one, other) for one, other in itertools.pairwise(kept) if other - one > 2.0)


def mean(truth, axis, start, end):
    values = [each[1 + axis] for each in truth if start <= each[0] <= end]
    return sum(values) / len(values)


def crossings(truth, axis, start, end) -> Iterator[float]:
    """Times after the start at which it comes to rest [s], between two samples."""
    for one, other in itertools.pairwise(each for each in truth if start <= each[0] <= end):
        before, after = abs(one[1 + axis]), abs(other[1 + axis])
        if before >= STILL > after:
            share = (before - STILL) / (before - after)
            yield one[0] + share * (other[0] - one[0]) - start


def compared(recorded, simulated):
    """Both and their difference, in words."""
    return f"{recorded:.3f} recorded, {simulated:.3f} simulated, {simulated / recorded - 1.0:+.0%}"


@each_kind
def test_the_speeds_are_the_recorded_ones(kind):
    session, done, _ = played(kind)
    figures, off = [], []
    for start, end in segments(session):
        for axis, name in enumerate(AXES):
            recorded = mean(session["truth"], axis, end - 0.9, end)
            simulated = mean(done["truth"], axis, end - 0.9, end)
            # The Sub's own estimate of its velocity was up to 0.06 m/s wrong, across its way too.
            if abs(recorded) > (0.08 if kind == "sub" else 0.065):
                figures.append(f"{start:.0f} {name} {compared(recorded, simulated)}")
                off += figures[-1:] if abs(simulated - recorded) > 0.1 * abs(recorded) else []
    assert not off
    assert len(figures) >= 7


@each_kind
def test_the_times_to_rest_are_the_recorded_ones(kind):
    session, done, _ = played(kind)
    figures, off = [], []
    for start, end in segments(session):
        for axis, name in enumerate(AXES):
            steady = mean(session["truth"], axis, start - 0.9, start)
            before = mean(session["truth"], axis, start - 0.2, start + 0.05)
            if abs(before) < 0.08 or abs(steady - before) > 0.1 * abs(before):
                continue
            # A Sub swings about its depth after a climb: it counts when it stands first.
            chosen = min if kind == "sub" and name == "down" else max
            recorded = chosen(crossings(session["truth"], axis, start, end), default=None)
            simulated = chosen(crossings(done["truth"], axis, start, end), default=None)
            if recorded is None and simulated is None:
                continue
            figures.append(f"{start:.0f} {name} {compared(recorded, simulated or math.inf)}")
            # A command reaches it within 0.05 s, which is when the recorded station sent it again.
            late = abs((simulated or math.inf) - recorded) > 0.05 + 0.1 * recorded
            off += figures[-1:] if late else []
    assert not off
    assert len(figures) >= 6
