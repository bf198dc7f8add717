"""A robot with ROS stops when its commands end, and stands until driven from neutral.

The cases are those of `cases.py`, and what can happen to the bridge and to the line: it is held
and comes back with all that waited, it is reset, the bridge pauses, or starts again. `make soak`
plays all cases; `make test` plays one.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable

import pytest

from tests.support.fake_hid import needs_virtual_devices
from tests.support.held_relay import TO_HUB, TO_ROBOT
from tests.system.driven_ros import OPTIONS, RecordedRos
from tests.system.stale_stick import cases
from tests.system.stale_stick.actions import (
    Action,
    Scene,
    insist,
    linked,
    module,
    signal_module,
    started_again,
)
from tests.system.stale_stick.cases import Case, once_and_often, play

pytestmark = needs_virtual_devices

REPETITIONS = 2
REST_S = 1.5
"""Longest time from the event to rest: 0.5 s of the robot's own watchdog, then it brakes [s]."""
PAUSED_S = 2.0
CATCHES_UP_S = 0.05
"""Time in which a bridge that goes on hands over what waited for it; the last of it is zero [s]."""


def record(scene: Scene) -> RecordedRos:
    found = scene.robot.record
    assert isinstance(found, RecordedRos)
    return found


def hold(*ways: str) -> Action:
    return lambda scene: record(scene).relay.hold(*ways)


def go_on(seconds: float) -> Action:
    """The line is back after a while, and the stick was deflected all the time."""

    def back(scene: Scene) -> None:
        insist(scene, seconds)
        record(scene).relay.go_on()
        insist(scene)

    return back


def pause(scene: Scene) -> float:
    """The bridge stands still for a while, as the robot does; the time is when it has caught up."""
    process = record(scene).robot.process
    process.send_signal(signal.SIGSTOP)
    insist(scene, PAUSED_S)
    process.send_signal(signal.SIGCONT)
    return time.monotonic() + CATCHES_UP_S


def driver_again(scene: Scene) -> None:
    started_again("driver")(scene)
    linked(scene)
    insist(scene)


def driver_goes_on(scene: Scene) -> None:
    """It was silent for a while; the hub may have ended it."""
    insist(scene, 1.0)
    for pid in module(scene, "driver"):
        os.kill(pid, signal.SIGCONT)
    driver_again(scene)


PAUSED = Case(name="bridge paused", strike=pause, mend=insist)
CASES = (
    cases.UNPLUGGED,
    cases.KILLED,
    cases.ASLEEP,
    cases.NETWORK_CUT,
    cases.NAVIGATION_KILLED,
    cases.NAVIGATION_FROZEN,
    cases.HUB_KILLED,
    cases.STOPPED,
    Case(
        name="driver killed",
        strike=signal_module("driver", signal.SIGKILL),
        mend=driver_again,
    ),
    Case(
        name="driver frozen",
        strike=signal_module("driver", signal.SIGSTOP),
        mend=driver_goes_on,
    ),
    Case(name="line held shortly", strike=hold(TO_ROBOT, TO_HUB), mend=go_on(0.2)),
    Case(name="line held", strike=hold(TO_ROBOT, TO_HUB), mend=go_on(PAUSED_S)),
    Case(name="line held for long", strike=hold(TO_ROBOT, TO_HUB), mend=go_on(6.0)),
    Case(name="commands held", strike=hold(TO_ROBOT), mend=go_on(4.0)),
    Case(name="topics held", strike=hold(TO_HUB), mend=go_on(PAUSED_S), stopped_s=0.9),
    Case(name="line reset", strike=lambda scene: record(scene).relay.reset(), mend=insist),
    PAUSED,
    Case(
        name="bridge restarted",
        strike=lambda scene: record(scene).robot.start_again(),
        mend=insist,
    ),
)
QUICK = {"ros-stamped": PAUSED}
"""The case in `make test`."""


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("scene", "body", "case", "count"),
    once_and_often(QUICK, OPTIONS, CASES, REPETITIONS),
    indirect=["scene"],
)
def test_it_stops_and_stands_until_it_is_driven_from_neutral(
    scene: Scene, body: str, case: Case, count: int, tell: Callable[..., None]
) -> None:
    del body
    play(scene, case, count, REST_S, tell)
