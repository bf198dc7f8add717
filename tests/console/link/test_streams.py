"""Broadcasts that come too late are asked for instead, until the link carries them again."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityReports
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from rune_tui.link.streams import Streams
from tests.support.messages import robot_state
from tests.support.waiting import until


class Rig:
    """A robot that tells its state, so many seconds late, and a console's streams."""

    def __init__(self, endpoint: str, stack: ExitStack, *, near: bool = False) -> None:
        self.robot = stack.enter_context(closing(Client("robot", endpoint)))
        self.console = stack.enter_context(closing(Client("console", endpoint, near=near)))
        self.came: list[tuple[str, Any]] = []
        self.streams = Streams(
            self.console, lambda name, value, _: self.came.append((name, value)), time.monotonic
        )
        self.late = 0.0
        self.number = 0
        self.robot.every(0.02, self._tell)
        self.robot.define(ROBOT_STATE, CAPABILITY_REPORTS)
        self.console.every(0.01, self.streams.step)

    def _tell(self) -> None:
        self.number += 1
        measured = time.monotonic() - self.late
        self.robot.publish(ROBOT_STATE, robot_state(x=float(self.number)), measured=measured)

    def serve(self) -> None:
        self.robot.listen(0.005)
        self.console.listen(0.005)

    def wait(self, condition: Any) -> None:
        until(condition, 15.0, meanwhile=self.serve)

    def wait_for_states(self, count: int = 5) -> None:
        """Until so many more have come."""
        told = self.number
        self.came.clear()
        self.wait(lambda: len(self.came) >= count)
        assert self.came[-1][1].x >= told

    def fall_behind(self) -> None:
        """Until streams are asked for."""
        self.late = 1.0
        self.wait(lambda: self.streams.asking)


@pytest.fixture(params=[False])
def rig(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Rig]:
    with ExitStack() as stack:
        central = stack.enter_context(closing(Central([f"ipc://{tmp_path}/c"])))
        yield Rig(central.endpoints[0], stack, near=request.param)


def test_states_that_come_late_are_asked_for_and_broadcast_to_nobody(rig: Rig) -> None:
    rig.streams.follow({ROBOT_STATE.name})
    rig.wait_for_states()
    assert not rig.streams.asking
    rig.fall_behind()
    rig.wait(lambda: not rig.robot.has_subscribers(ROBOT_STATE))
    rig.wait_for_states()


def test_what_comes_seldom_or_on_change_is_broadcast_all_the_same(rig: Rig) -> None:
    rig.streams.follow({ROBOT_STATE.name, CAPABILITY_REPORTS.name})
    rig.wait_for_states()
    rig.fall_behind()
    rig.robot.publish(CAPABILITY_REPORTS, CapabilityReports(robot="m", capabilities=()))
    rig.wait(lambda: any(name == CAPABILITY_REPORTS.name for name, _ in rig.came))
    rig.wait(lambda: not rig.robot.has_subscribers(ROBOT_STATE))
    assert rig.robot.has_subscribers(CAPABILITY_REPORTS)


def test_a_few_late_ones_are_no_thin_link(rig: Rig) -> None:
    rig.streams.follow({ROBOT_STATE.name})
    rig.wait_for_states()
    for _ in range(4):
        rig.late = 1.0
        rig.wait_for_states(2)
        rig.late = 0.0
        rig.wait_for_states(3)
    assert not rig.streams.asking


def test_when_the_link_carries_them_again_they_are_broadcast_again(rig: Rig) -> None:
    rig.streams.follow({ROBOT_STATE.name})
    rig.wait_for_states()
    rig.fall_behind()
    rig.late = 0.0
    rig.wait_for_states()
    assert rig.streams.asking  # not at once, or it would go to and fro
    rig.streams.asked_until = -math.inf
    rig.wait(lambda: not rig.streams.asking)
    rig.wait(lambda: rig.robot.has_subscribers(ROBOT_STATE))
    rig.wait_for_states()


def test_another_layout_is_followed_while_streams_are_asked_for(rig: Rig) -> None:
    rig.streams.follow({ROBOT_STATE.name})
    rig.wait_for_states()
    rig.fall_behind()
    rig.streams.follow(set())
    for _ in range(20):
        rig.serve()
    rig.came.clear()
    for _ in range(20):
        rig.serve()
    assert rig.came == []
    rig.streams.follow({ROBOT_STATE.name})
    rig.wait_for_states()
    assert rig.streams.asking
    assert not rig.robot.has_subscribers(ROBOT_STATE)


@pytest.mark.parametrize("rig", [True], indirect=True)
def test_on_the_robots_own_machine_what_comes_late_waited_in_no_link(rig: Rig) -> None:
    rig.streams.follow({ROBOT_STATE.name})
    rig.late = 1.0
    began = time.monotonic()
    while time.monotonic() < began + 0.8:
        rig.wait_for_states()
    assert not rig.streams.asking


class AnswersByHand:
    """A client of a far hub; the test answers its requests."""

    near, connected, round_trip = False, True, 0.1

    def __init__(self) -> None:
        self.requests: list[Callable[..., None]] = []
        self.arrives: Callable[..., None] = lambda *_: None

    def subscribe(self, _: object, handler: Callable[..., None], **__: object) -> None:
        self.arrives = handler

    def unsubscribe(self, *_: object) -> None:
        """Nothing more arrives."""

    def last_notify(self, *_: object, answered: Callable[..., None], **__: object) -> None:
        self.requests.append(answered)


def test_one_slow_answer_does_not_hold_back_the_next_requests() -> None:
    now = [0.0]
    client = AnswersByHand()
    streams = Streams(cast(Client, client), lambda *_: None, lambda: now[0])
    streams.follow({ROBOT_STATE.name})
    late = SimpleNamespace(age=2.0)
    for _ in range(10):
        now[0] += 0.2
        client.arrives(robot_state(), late)
    assert streams.asking
    times = []
    for wait in (5.0, 0.15, 0.15, 0.15):
        while not client.requests:
            now[0] += 0.01
            streams.step()
        times.append(now[0])
        now[0] += wait
        client.requests.pop()(robot_state(), SimpleNamespace(age=wait))
    assert times[2] - times[1] < 1.2, "the slow answer counts for a second at most"
    assert times[3] - times[2] < 0.5, "fast answers show that the link is free"
