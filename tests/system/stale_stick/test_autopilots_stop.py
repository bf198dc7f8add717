"""A vehicle with an autopilot stops when its commands end, and stands until driven from neutral.

The cases are those of `cases.py`, and what can happen at the vehicle's own link: it is cut, the
autopilot starts again, another ground station changes the mode. After those, an order of the
operator is needed too. `make soak` plays all cases; `test_autopilot` shows some in `make test`.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable

import pytest

from tests.support.fake_hid import needs_virtual_devices
from tests.support.mavlink_numbers import ARM, RESTART, SET_MODE
from tests.system.driven_autopilot import AUTOPILOTS, DOOR, DRIVING_MODES, RecordedAutopilot
from tests.system.stale_stick import cases
from tests.system.stale_stick.actions import (
    Action,
    Scene,
    insist,
    linked,
    signal_module,
    started_again,
)
from tests.system.stale_stick.cases import Case, once_and_often, play

pytestmark = needs_virtual_devices

REPETITIONS = 2
HOLD_MODES = {"rover": 4, "sub": 2, "blimp": 3}
NEXT_HEARTBEAT_S = 1.3
"""A vehicle that another station disarmed says so with its next heartbeat [s]."""


def autopilot(scene: Scene) -> RecordedAutopilot:
    record = scene.robot.record
    assert isinstance(record, RecordedAutopilot)
    return record


def cut(*ways: str) -> Action:
    def struck(scene: Scene) -> None:
        autopilot(scene).cut(*ways)

    return struck


def join(scene: Scene) -> None:
    """The link is back, and the stick was deflected all the time."""
    insist(scene, 1.5)
    autopilot(scene).join()
    insist(scene)


def order(command: int, *values: float) -> Action:
    """Another ground station gives an order."""
    return lambda scene: autopilot(scene).station.order(command, *values)


def set_mode(modes: dict[str, int]) -> Action:
    def ordered(scene: Scene) -> None:
        order(SET_MODE, 1.0, float(modes[autopilot(scene).kind]))(scene)

    return ordered


def drive_elsewhere_then_here(scene: Scene) -> None:
    """The other station sets the driving mode again; then the operator asks for it too.

    A rover without sticks leaves that mode at once: it is set several times.
    """
    for _ in range(5):
        set_mode(DRIVING_MODES)(scene)
        insist(scene, 0.2)
    scene.robot.console.type("g")
    insist(scene, 1.0)


def restart(scene: Scene) -> float:
    """The other station disarms it, since an armed one does not restart, and has it restart."""
    station = autopilot(scene).station
    struck = time.monotonic()
    station.order(ARM, 0.0)
    scene.robot.wait(lambda: not station.armed, "it is not disarmed")
    station.order(RESTART, 1.0)
    return struck


def arm_restarted(scene: Scene) -> None:
    """The other station arms it as soon as it has started."""
    station, mode = autopilot(scene).station, DRIVING_MODES[autopilot(scene).kind]

    def armed() -> bool:
        set_mode(DRIVING_MODES)(scene)
        station.order(ARM, 1.0)
        insist(scene, 0.2)
        return station.armed and station.mode == mode

    scene.robot.wait(armed, "the other station cannot arm it")
    insist(scene)


def arm_elsewhere(scene: Scene) -> None:
    """The other station arms it again."""
    station = autopilot(scene).station
    scene.robot.wait(lambda: not station.armed, "it is not disarmed")
    set_mode(DRIVING_MODES)(scene)
    station.order(ARM, 1.0)
    scene.robot.wait(lambda: station.armed, "the other station cannot arm it")
    insist(scene, 1.0)


def vehicle_again(scene: Scene) -> None:
    insist(scene)


def driver_again(scene: Scene) -> None:
    started_again("driver")(scene)
    linked(scene)
    insist(scene)


DRIVER_KILLED = Case(
    name="driver killed",
    strike=signal_module("driver", signal.SIGKILL),
    mend=driver_again,
    ends=True,
)
MODE_CHANGED = Case(
    name="mode changed elsewhere",
    strike=set_mode(HOLD_MODES),
    mend=drive_elsewhere_then_here,
    ends=True,  # nothing is sent in another's mode: a blimp without a receiver disarms, and drifts
)
LINK_CUT = Case(name="link cut", strike=cut("to_vehicle", "to_hub"), mend=join, ends=True)
RESTARTED = Case(
    name="autopilot restarted",
    strike=restart,
    mend=arm_restarted,
    ends=True,
    stopped_s=NEXT_HEARTBEAT_S,
)
CASES = (
    cases.UNPLUGGED,
    cases.KILLED,
    cases.ASLEEP,
    cases.NETWORK_CUT,
    cases.NAVIGATION_KILLED,
    cases.NAVIGATION_FROZEN,
    cases.HUB_KILLED,
    cases.STOPPED,
    DRIVER_KILLED,
    LINK_CUT,
    Case(name="commands cut", strike=cut("to_vehicle"), mend=join, ends=True),
    Case(name="telemetry cut", strike=cut("to_hub"), mend=join, ends=True, stopped_s=1.6),
    RESTARTED,
    Case(
        name="autopilot killed",
        strike=lambda scene: autopilot(scene).start_vehicle_again(),
        mend=vehicle_again,
        ends=True,
    ),
    MODE_CHANGED,
    Case(
        name="disarmed elsewhere",
        strike=order(ARM, 0.0),
        mend=arm_elsewhere,
        ends=True,
        stopped_s=NEXT_HEARTBEAT_S,
    ),
)
BODIES = tuple(f"{DOOR}{kind}" for kind in AUTOPILOTS)
QUICK = {f"{DOOR}rover": MODE_CHANGED}
"""The case of a vehicle in `make test`."""
REST_S = {"rover": 2.2, "sub": 4.8, "blimp": 4.0}
"""Longest time from the event to rest [s], where the vehicle brakes; in depth hold a Sub coasts."""
LATER_S = 1.5
"""The same takes longer where the vehicle's commands are not cut, but its answers [s]."""


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("scene", "body", "case", "count"),
    once_and_often(QUICK, BODIES, CASES, REPETITIONS),
    indirect=["scene"],
)
def test_it_stops_and_stands_until_it_is_driven_from_neutral(
    scene: Scene, body: str, case: Case, count: int, tell: Callable[..., None]
) -> None:
    kind = body.removeprefix(DOOR)
    later = LATER_S if case.stopped_s > cases.STOPPED_S else 0.0
    play(scene, case, count, REST_S[kind] + later, tell, rolls=kind != "blimp")
