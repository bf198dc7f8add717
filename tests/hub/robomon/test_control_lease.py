"""Who has control of a robot: what the arbiter decides, by itself and in random histories."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.control import ANSWER_S, LOST_S
from hub.robomon.control_lease import LONGEST_NAME, MAX_REQUESTS, ControlLease

ALICE, BOB, CAROL = 1, 2, 3
NAMES = {ALICE: "alice", BOB: "bob", CAROL: "carol"}
STEP_S = 0.1


class Table:
    """An arbiter, consoles that live until they are told to be silent, and a clock."""

    def __init__(self) -> None:
        self.now = 50.0
        self.arbiter = ControlLease(self.now)
        self.alive = set(NAMES)

    @property
    def owner(self) -> int:
        return self.arbiter.owner.number if self.arbiter.owner else 0

    @property
    def askers(self) -> list[int]:
        return [request.number for request in self.arbiter.requests]

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            self.now += STEP_S
            for number in self.alive:
                self.arbiter.heartbeat(number, self.now, holds=number == self.owner)
            self.arbiter.expire(self.now)

    def take(self, number: int) -> bool:
        return self.arbiter.take(number, NAMES[number], self.now)[0]

    def ask(self, number: int) -> tuple[bool, str]:
        return self.arbiter.ask(number, NAMES[number], self.now)


@pytest.fixture
def table() -> Table:
    made = Table()
    assert made.take(ALICE)
    return made


def test_free_robot_is_whose_who_takes_it_first(table: Table) -> None:
    assert not table.take(BOB)
    assert table.owner == ALICE
    assert table.take(ALICE)
    table.run(20.0)
    assert table.owner == ALICE


def test_owner_grants_and_denies(table: Table) -> None:
    assert "alice" in table.ask(BOB)[1]
    assert not table.arbiter.grant(BOB, table.now)[0]
    assert not table.arbiter.deny(BOB, table.now)[0]
    assert table.arbiter.deny(ALICE, table.now)[0]
    assert (table.owner, table.askers) == (ALICE, [])
    assert not table.arbiter.grant(ALICE, table.now)[0]
    table.ask(BOB)
    assert table.arbiter.grant(ALICE, table.now)[0]
    assert (table.owner, table.askers) == (BOB, [])
    assert table.arbiter.why == "alice handed control to bob"


def test_request_that_is_not_answered_is_denied_and_the_next_one_has_its_whole_time(
    table: Table,
) -> None:
    table.ask(BOB)
    table.run(4.0)
    assert "after 1 other" in table.ask(CAROL)[1]
    assert table.arbiter.left(table.now) == pytest.approx(ANSWER_S - 4.0)
    table.run(ANSWER_S - 4.0 + STEP_S)
    assert (table.owner, table.askers) == (ALICE, [CAROL])
    assert table.arbiter.why == "alice did not answer bob"
    assert table.arbiter.left(table.now) > ANSWER_S - 2 * STEP_S
    table.run(ANSWER_S + STEP_S)
    assert (table.owner, table.askers) == (ALICE, [])


def test_to_ask_twice_gains_no_time_and_no_place(table: Table) -> None:
    table.ask(BOB)
    table.run(5.0)
    done, text = table.ask(BOB)
    assert done
    assert "already" in text
    assert table.askers == [BOB]
    assert table.arbiter.left(table.now) == pytest.approx(5.0)


def test_only_so_many_ask_at_a_time(table: Table) -> None:
    for number in range(10, 10 + MAX_REQUESTS):
        assert table.arbiter.ask(number, "", table.now)[0]
    assert not table.ask(BOB)[0]


def test_owner_who_falls_silent_loses_control_and_not_before(table: Table) -> None:
    table.alive.discard(ALICE)
    table.run(LOST_S - 2 * STEP_S)
    assert table.owner == ALICE
    table.run(3 * STEP_S)
    assert table.owner == 0
    assert "alice fell silent" in table.arbiter.why
    assert table.take(BOB)


def test_console_that_does_not_know_it_has_control_does_not_keep_it(table: Table) -> None:
    for _ in range(round(LOST_S / STEP_S) + 1):
        table.now += STEP_S
        table.arbiter.heartbeat(ALICE, table.now, holds=False)
    assert table.owner == 0


def test_heartbeat_gives_nobody_control() -> None:
    table = Table()
    table.arbiter.heartbeat(ALICE, table.now, holds=True)
    assert table.owner == 0
    assert table.take(BOB)
    table.arbiter.heartbeat(ALICE, table.now, holds=True)
    assert table.owner == BOB


def test_who_asks_gets_a_robot_that_becomes_free(table: Table) -> None:
    table.ask(BOB)
    table.ask(CAROL)
    table.arbiter.release(ALICE, table.now)
    assert (table.owner, table.askers) == (BOB, [CAROL])
    table.arbiter.disconnected(BOB, table.now)
    assert (table.owner, table.askers) == (CAROL, [])
    table.arbiter.disconnected(CAROL, table.now)
    assert table.owner == 0


def test_who_asks_can_withdraw_leave_or_fall_silent(table: Table) -> None:
    table.ask(BOB)
    assert table.arbiter.release(BOB, table.now)[0]
    assert table.askers == []
    table.ask(BOB)
    table.arbiter.disconnected(BOB, table.now)
    assert table.askers == []
    table.ask(BOB)
    table.alive.discard(BOB)
    table.run(LOST_S + STEP_S)
    assert (table.owner, table.askers) == (ALICE, [])
    assert not table.arbiter.release(BOB, table.now)[0]


def test_supervisor_takes_over_and_frees(table: Table) -> None:
    table.ask(CAROL)
    assert table.arbiter.take_over(BOB, "bob", table.now)[0]
    assert (table.owner, table.askers) == (BOB, [CAROL])
    assert table.arbiter.why == "bob took control from alice"
    assert table.arbiter.free(table.now)[0]
    assert (table.owner, table.askers) == (0, [])


def test_pause_of_our_own_frees_nobody_and_ends_no_request(table: Table) -> None:
    table.ask(BOB)
    table.now += 60.0
    table.arbiter.expire(table.now)
    assert (table.owner, table.askers) == (ALICE, [BOB])
    table.alive.clear()
    table.run(LOST_S + STEP_S)
    assert (table.owner, table.askers) == (0, [])


def test_names_are_what_all_may_see() -> None:
    table = Table()
    table.arbiter.take(ALICE, "\x1b[31m al\nice " + "x" * 100, table.now)
    owner = table.arbiter.owner
    assert owner is not None
    assert owner.operator.isprintable()
    assert len(owner.operator) == LONGEST_NAME
    table.arbiter.take_over(BOB, "\n", table.now)
    assert table.arbiter.owner is not None
    assert table.arbiter.owner.operator == "somebody"


def _actions(table: Table, number: int) -> tuple[Callable[[], object], ...]:
    """What a console may ask for, and that it leaves."""
    arbiter, name = table.arbiter, NAMES[number]
    return (
        lambda: table.take(number),
        lambda: table.ask(number),
        lambda: table.ask(number),
        lambda: arbiter.release(number, table.now),
        lambda: arbiter.grant(number, table.now),
        lambda: arbiter.deny(number, table.now),
        lambda: arbiter.take_over(number, name, table.now),
        lambda: arbiter.free(table.now),
        lambda: arbiter.disconnected(number, table.now),
    )


@given(st.integers(0, 2**32))
def test_random_histories(seed: int) -> None:
    """Whatever is asked in whatever order: one owner, no silent one, and every request ends.

    Only the owner's own word, a supervisor, its leaving or its silence takes control from it.
    """
    chance = random.Random(seed)
    table = Table()
    heard = dict.fromkeys(NAMES, table.now)
    for _ in range(chance.randint(20, 100)):
        number, before = chance.choice(list(NAMES)), table.owner
        which = chance.randrange(9)
        _actions(table, number)[which]()
        assert before in (0, number, table.owner) or which in (6, 7)
        if table.owner != before:
            heard[table.owner] = table.now
        table.alive = {each for each in NAMES if chance.random() < 0.6}
        for _ in range(chance.randrange(15)):
            heard |= dict.fromkeys(table.alive, table.now + STEP_S)
            owner = table.owner
            table.run(STEP_S)
            if table.owner != owner:
                heard[table.owner] = table.now
            assert len({table.owner, *table.askers}) == 1 + len(table.askers)
            assert table.owner or not table.askers
            assert not table.owner or table.now - heard[table.owner] < LOST_S
    table.alive = set(NAMES)
    table.run(ANSWER_S * len(NAMES))
    assert table.askers == []
