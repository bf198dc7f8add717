"""The hub's clock on other machines: ages are right however far clocks are apart."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.transport.clock_sync import DRIFT, ClockSync, this_machine
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

OFFSETS = [7200.0, 1e7]
"""Other machines' monotonic clocks begin when they are switched on [s]."""


def ask(hub_time: ClockSync, at: float, up: float, down: float, offset: float) -> None:
    """A question at `at` on the own clock, that long on its way up and down [s]."""
    hub_time.note(at, at + up + offset, at + up + down)


@given(
    offset=st.sampled_from(OFFSETS),
    ways=st.lists(st.tuples(st.floats(0.0, 3.0), st.floats(0.0, 3.0)), min_size=1, max_size=40),
)
def test_the_bounds_hold_on_any_line_and_the_shortest_ways_are_what_they_are_off(
    offset: float, ways: list[tuple[float, float]]
) -> None:
    hub_time = ClockSync(lambda: 0.0)
    hub_time.begin(1)
    for number, (up, down) in enumerate(ways):
        ask(hub_time, 0.5 * number, up, down, offset)
        assert hub_time.least <= offset <= hub_time.most
    drift = DRIFT * (0.5 * len(ways) + 8.0) + 1e-6
    assert offset - hub_time.least <= min(down for _, down in ways) + drift
    assert hub_time.most - offset <= min(up for up, _ in ways) + drift
    assert hub_time.round_trip == pytest.approx(min(map(sum, ways[-20:])), abs=1e-6)


@given(
    st.lists(st.tuples(st.floats(), st.floats()), max_size=9),
    st.floats(0.0, 1e8),
)
def test_no_damaged_answer_makes_a_stamp_that_no_frame_holds(
    damaged: list[tuple[float, float]], now: float
) -> None:
    hub_time = ClockSync(lambda: now)
    hub_time.begin(1)
    for sent, time_there in damaged:
        hub_time.note(sent, time_there, now)
    for bound in (hub_time.least, hub_time.most):
        assert -(2**63) <= int((now + bound) * 1e9) < 2**63
    assert hub_time.least <= hub_time.most
    assert not hub_time.round_trip < 0.0


def test_before_the_first_round_trip_nothing_looks_young() -> None:
    hub_time = ClockSync(lambda: 0.0)
    hub_time.begin(1)
    hub_time.note(0.0, math.nan, 1.0)
    assert hub_time.least < -1e8
    assert hub_time.most > 1e8


def test_a_link_that_is_busy_for_minutes_does_not_make_anything_look_younger() -> None:
    hub_time = ClockSync(lambda: 0.0)
    hub_time.begin(1)
    ask(hub_time, 0.0, 0.02, 0.02, 7200.0)
    for number in range(1, 600):  # what comes down queues behind pictures
        ask(hub_time, 0.5 * number, 0.02, 0.5, 7200.0)
    assert hub_time.least == pytest.approx(7200.0 - 0.02 - DRIFT * 300.0, abs=0.01)
    assert hub_time.most == pytest.approx(7200.0 + 0.02, abs=0.01)
    assert hub_time.round_trip == pytest.approx(0.52)


def test_a_clock_that_stood_still_is_noticed_at_once() -> None:
    hub_time = ClockSync(lambda: 0.0)
    hub_time.begin(1)
    ask(hub_time, 0.0, 0.001, 0.001, 7200.0)
    ask(hub_time, 0.5, 0.3, 0.1, 5000.0)
    assert hub_time.least == pytest.approx(4999.9, abs=0.01)
    assert hub_time.most == pytest.approx(5000.3, abs=0.01)


def test_after_a_sleep_of_this_machine_no_age_is_known_before_the_next_round_trip() -> None:
    hub_time = ClockSync(lambda: 0.0)
    hub_time.begin(1)
    ask(hub_time, 0.0, 0.001, 0.001, 7200.0)
    before = hub_time.least
    hub_time.stood_still(0.0)
    assert hub_time.most < 7201.0, "no sleep changes nothing"
    hub_time.stood_still(5.0)
    assert hub_time.most > 1e8, "what is received counts as too old"
    assert hub_time.least == before, "what is sent is stamped too old, never too young"
    ask(hub_time, 0.5, 0.001, 0.001, 7205.0)
    assert hub_time.most == pytest.approx(7205.001, abs=0.01)


def test_a_sleep_of_the_hubs_own_machine_moves_no_bound() -> None:
    hub_time = ClockSync(time.monotonic)
    hub_time.begin(this_machine())
    hub_time.stood_still(5.0)
    assert (hub_time.least, hub_time.most) == (0.0, 0.0)


@pytest.mark.parametrize("drift", [-DRIFT, DRIFT])
def test_the_bounds_hold_while_clocks_drift(drift: float) -> None:
    hub_time = ClockSync(lambda: 0.0)
    hub_time.begin(1)
    for number in range(20_000):
        at = 0.5 * number
        hub_time.note(at, 100.0 + (1.0 + drift) * (at + 0.02), at + 0.04)
        for now in (at + 0.04, at + 1.5):  # an answer may be lost
            assert hub_time.least <= 100.0 + drift * now <= hub_time.most
    assert hub_time.uncertainty < 0.05


def test_on_the_hubs_machine_there_is_no_offset_and_yet_a_round_trip() -> None:
    hub_time = ClockSync(time.monotonic)
    hub_time.begin(this_machine())
    assert math.isnan(hub_time.round_trip)
    ask(hub_time, 10.0, 0.2, 0.0, 0.0)
    assert (hub_time.least, hub_time.most) == (0.0, 0.0)
    assert hub_time.round_trip == pytest.approx(0.2)


@pytest.fixture
def central() -> Iterator[Central]:
    with closing(Central(["tcp://127.0.0.1:0"])) as running:
        yield running


@pytest.mark.parametrize(("here", "there"), [(0.0, 7200.0), (1e7, 10.0), (7200.0, 1e7)])
def test_what_another_machine_measured_is_as_old_here_as_there(
    central: Central, here: float, there: float
) -> None:
    def far(by: float) -> Callable[[], float]:
        return lambda: time.monotonic() + by

    with ExitStack() as stack:
        robot, console = (
            stack.enter_context(
                closing(Client(name, central.endpoints[0], clock=far(by), near=False))
            )
            for name, by in (("robot", here), ("console", there))
        )
        received: list[MessageInfo] = []
        answers: list[MessageInfo] = []
        console.subscribe(v.LOG, lambda _, how: received.append(how))
        robot.define(v.LOG)
        robot.respond_later(
            v.ASK,
            v.ANSWER,
            lambda asked, reply: reply.answer(asked, measured=robot.loop.clock() - 40.0),
        )

        def serve() -> None:
            robot.listen(0.005)
            console.listen(0.005)

        until(lambda: robot.connected and console.connected, 10.0, meanwhile=serve)

        def told() -> bool:
            robot.publish(v.LOG, Number(value=1), measured=robot.loop.clock() - 30.0)
            serve()
            return bool(received)

        until(told, 10.0)
        console.query_notify(
            v.ASK,
            Number(value=1),
            v.ANSWER,
            timeout=10.0,
            answered=lambda _, how: answers.append(how),
            failed=lambda error: pytest.fail(str(error)),
        )
        until(lambda: answers, 10.0, meanwhile=serve)
        now = console.loop.clock()
        for age, how in ((30.0, received[0]), (40.0, answers[0])):
            # Too old by two round trips, and never too young.
            assert age < how.age < age + 6.0
            assert age < now - how.measured < age + 11.0
