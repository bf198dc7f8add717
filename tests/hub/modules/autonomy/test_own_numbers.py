"""A new connection to the hub gives autonomy another number, and its goal stays its own."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time
from random import Random
from typing import Any

import pytest

from hub.gcm.autonomy import AUTONOMY_COMMAND, AUTONOMY_STATE, AutonomyCommand, Behaviour, Phase
from hub.gcm.navigation import (
    GOAL_COMMAND,
    NAVIGATION_STATUS,
    ROBOT_STATE,
    MotionState,
    NavigationStatus,
    Point,
    Task,
)
from hub.ipc.message_info import MessageInfo
from hub.modules.autonomy.__main__ import Autonomy
from tests.hub.modules.extremes_bus import ExtremesBus
from tests.support.bodies import robot_of
from tests.support.messages import robot_state


class Bus(ExtremesBus):
    """Keeps what the module publishes; handlers get fresh messages of another client."""

    def __init__(self) -> None:
        super().__init__(time.monotonic, Random(1))
        self.sent: dict[str, Any] = {}

    def subscribe(self, definition: Any, handler: Any, **_: Any) -> None:
        def take(value: Any) -> None:
            handler(value, MessageInfo(2, 1, 0, 0.0, self.clock()))

        self.handlers[definition.name].append(take)

    def publish(self, definition: Any, value: Any, **_: Any) -> None:
        self.sent[definition.name] = value

    def tell(self, definition: Any, value: Any) -> None:
        for handler in self.handlers[definition.name]:
            handler(value)

    def work(self) -> None:
        for timer in self.timers:
            timer()


GOES = NavigationStatus(
    number=1,
    task=Task.GOING,
    sender=ExtremesBus.number,
    driver=0,
    points_left=1,
    distance_left=3.0,
    why="",
    path=(),
    x=3.0,
    y=0.0,
    seconds=1.0,
)


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> Bus:
    """Autonomy on the way to a point."""
    ticks = itertools.count(1000)
    monkeypatch.setattr(time, "monotonic", lambda: next(ticks) * 0.001)
    made = Bus()
    Autonomy(made, robot_of("magellan"))  # type: ignore[arg-type]
    made.tell(ROBOT_STATE, robot_state(motion=MotionState.STANDING))
    idle = dataclasses.replace(GOES, number=0, task=Task.NONE, sender=0, x=math.nan, y=math.nan)
    made.tell(NAVIGATION_STATUS, idle)
    order = AutonomyCommand(behaviour=Behaviour.GO, points=(Point(x=3.0, y=0.0),))
    made.tell(AUTONOMY_COMMAND, order)
    made.work()
    assert GOAL_COMMAND.name in made.sent, made.sent
    assert made.sent[GOAL_COMMAND.name].points
    made.tell(ROBOT_STATE, robot_state(motion=MotionState.GOING))
    return made


@pytest.mark.parametrize("number", [0, 77], ids=["not connected", "connected anew"])
@pytest.mark.parametrize("before", [(), (GOES,)], ids=["not heard", "accepted"])
def test_its_goal_is_not_that_of_somebody_else(
    bus: Bus, number: int, before: tuple[NavigationStatus, ...]
) -> None:
    for status in before:
        bus.tell(NAVIGATION_STATUS, status)
    bus.number = number
    bus.tell(NAVIGATION_STATUS, GOES)
    bus.work()
    assert bus.sent[AUTONOMY_STATE.name].phase is Phase.ACTIVE, bus.sent[AUTONOMY_STATE.name].why


def test_a_goal_of_another_client_ends_the_task(bus: Bus) -> None:
    bus.tell(NAVIGATION_STATUS, GOES)
    bus.tell(NAVIGATION_STATUS, dataclasses.replace(GOES, number=2, sender=9))
    bus.work()
    assert bus.sent[AUTONOMY_STATE.name].phase is Phase.TAKEN_OVER
