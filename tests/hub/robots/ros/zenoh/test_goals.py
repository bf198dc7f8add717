"""Goals of Nav2 over Zenoh: the hidden services and topics of an action, as rmw_zenoh has them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest

from hub.gcm.own_navigation import OwnGoal
from hub.robots.ros.address import ros_address
from hub.robots.ros.goals.own_goals import OwnGoals
from hub.robots.ros.zenoh.line import ZenohLine
from hub.ros import goal_messages as wire
from hub.ros.goal_messages import GoalPlace, goal_reader, goal_writer
from tests.support.ros_node import RosNode
from tests.support.waiting import until
from tests.support.zenoh_router import ZenohRouter, zenoh_router

ACTION = "/rover/navigate_to_pose"
DRIVES, CANCELLED, ABORTED = 2, 5, 6


class Nav2:
    """The node of an action server; its goals are taken, and end when they are cancelled."""

    def __init__(self, endpoint: str) -> None:
        self.node = RosNode(endpoint, "bt_navigator")
        self.goals: list[str] = []
        self.cancels: list[str] = []
        hidden = f"{ACTION}/_action"
        kinds = {"status": wire.STATUS, "feedback": wire.FEEDBACK}
        made_up = f"RIHS01_{'cd' * 32}"  # the line takes the hash that the node has
        self._status = self.node.publisher(f"{hidden}/status", kinds["status"], latched=True)
        self._feedback = self.node.publisher(f"{hidden}/feedback", wire.FEEDBACK, hashed=made_up)
        self.node.serve(f"{hidden}/send_goal", wire.SEND_GOAL, self._send)
        self.node.serve(f"{hidden}/cancel_goal", wire.CANCEL_GOAL, self._cancel)
        self.node.serve(f"{hidden}/get_result", wire.GET_RESULT, self._explain)

    def _send(self, request: bytes) -> bytes:
        value = goal_reader(f"{wire.SEND_GOAL}_Request", "cdr").decode(request)
        self.goals.append(bytes(value.get("goal_id.uuid")).hex())
        self.says(DRIVES)
        return goal_writer(f"{wire.SEND_GOAL}_Response", "cdr").encode({"accepted": True})

    def _cancel(self, request: bytes) -> bytes:
        value = goal_reader(f"{wire.CANCEL_GOAL}_Request", "cdr").decode(request)
        self.cancels.append(bytes(value.get("goal_info.goal_id.uuid")).hex())
        self.says(CANCELLED)
        return goal_writer(f"{wire.CANCEL_GOAL}_Response", "cdr").encode({"return_code": 0})

    def _explain(self, request: bytes) -> bytes:
        value = goal_reader(f"{wire.GET_RESULT}_Request", "cdr").decode(request)
        name = bytes(value.get("goal_id.uuid")).hex()
        said = {"status": ABORTED, "error_code": 208, "error_msg": f"no path for {name}"}
        return goal_writer(f"{wire.GET_RESULT}_Response", "cdr").encode(said)

    def says(self, status: int) -> None:
        """Publish the state of the newest goal."""
        state = {"goal_info": {"goal_id": self._uuid}, "status": status}
        self._status(goal_writer(wire.STATUS, "cdr").encode({"status_list": [state]}))

    def goes_on(self) -> None:
        values = {"goal_id": self._uuid, "distance_remaining": 1.25}
        self._feedback(goal_writer(wire.FEEDBACK, "cdr").encode(values))

    @property
    def _uuid(self) -> dict[str, object]:
        return {"uuid": np.frombuffer(bytes.fromhex(self.goals[-1]), np.uint8)}


class Hub:
    """The goals of a hub on its line, advanced as a driver does it."""

    def __init__(self, endpoint: str) -> None:
        where = endpoint.removeprefix("tcp/")
        self.line = ZenohLine(ros_address(f"zenoh+tcp://{where}"), node="rune")
        self.goals = OwnGoals(self.line, ACTION, "72756e6500000001")
        self.close = self.line.close

    def turn(self) -> None:
        now = time.monotonic()
        self.line.advance(now)
        self.goals.advance(now)

    def until(self, goal: OwnGoal) -> None:
        until(
            lambda: self.goals.report(0.0).goal is goal,
            10.0,
            lambda: f"{goal} {self.goals.report(0.0)} {self.line.graph}",
            meanwhile=self.turn,
        )

    def available(self) -> None:
        until(lambda: self.goals.report(0.0).available, 10.0, meanwhile=self.turn)

    def go(self, number: int = 1) -> None:
        place = GoalPlace(frame="map", x=1.0, y=2.0, theta=0.0)
        self.goals.go(number, place, time.monotonic())


@pytest.fixture
def router() -> Iterator[ZenohRouter]:
    with zenoh_router() as running:
        yield running


def test_a_goal_goes_to_nav2_its_end_cancels_it_and_nav2_says_why_it_gives_up(
    router: ZenohRouter,
) -> None:
    nav2 = Nav2(router.endpoint)
    with closing(Hub(router.endpoint)) as hub:
        hub.available()
        hub.go()
        hub.until(OwnGoal.DRIVES)
        nav2.goes_on()
        until(
            lambda: hub.goals.report(time.monotonic()).distance_left == 1.25,
            10.0,
            meanwhile=hub.turn,
        )
        hub.goals.end(time.monotonic())
        until(lambda: nav2.cancels == nav2.goals, 10.0, meanwhile=hub.turn)
        until(lambda: not hub.goals.report(time.monotonic()).ending, 10.0, meanwhile=hub.turn)
        hub.go(2)
        hub.until(OwnGoal.DRIVES)
        nav2.says(ABORTED)
        why = f"gave up: no path for {nav2.goals[1]} (error 208)"
        until(lambda: hub.goals.report(0.0).why.endswith(why), 10.0, meanwhile=hub.turn)
    nav2.node.leave()


def test_a_hub_that_comes_back_cancels_the_goal_that_was_left(router: ZenohRouter) -> None:
    """The list of goals is latched: it comes without a change."""
    nav2 = Nav2(router.endpoint)
    with closing(Hub(router.endpoint)) as hub:
        hub.available()
        hub.go()
        hub.until(OwnGoal.DRIVES)
    assert not nav2.cancels
    with closing(Hub(router.endpoint)) as following:
        until(lambda: nav2.cancels == nav2.goals, 10.0, meanwhile=following.turn)
        assert following.goals.report(time.monotonic()).number == 0
    nav2.node.leave()
