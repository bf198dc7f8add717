"""The attention queue: its order, what raises an entry, what answers it, and where `n` leads."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.model.attention import (
    AGAIN_S,
    KEPT_S,
    ORDER_S,
    AttentionEntry,
    AttentionQueue,
    Problem,
    next_robot,
)


def problem(robot: str, cause: str = "battery", *, alarm: bool = True) -> Problem:
    return Problem(robot=robot, cause=cause, text=f"{cause} of {robot}", alarm=alarm)


def names(entries: tuple[AttentionEntry, ...]) -> list[tuple[str, str]]:
    return [(entry.robot, entry.cause) for entry in entries]


def test_alarms_come_before_warnings_and_older_ones_before_newer() -> None:
    queue = AttentionQueue()
    old = problem("rover", "task", alarm=False)
    queue.look([old], "rov", 0.0)
    queue.look([old, problem("blimp")], "rov", 2.0)
    entries = queue.look([problem("rov", "leak"), old, problem("blimp")], "rov", 4.0)
    assert names(entries) == [("blimp", "battery"), ("rov", "leak"), ("rover", "task")]
    assert [entry.since for entry in entries] == [2.0, 4.0, 0.0]


def test_there_is_one_entry_for_each_cause_at_each_robot() -> None:
    queue = AttentionQueue()
    twice = [problem("rover", alarm=False), problem("rover"), problem("blimp")]
    entries = queue.look(twice, "", 0.0)
    assert names(entries) == [("rover", "battery"), ("blimp", "battery")]
    assert entries[0].alarm


def test_looking_at_a_robot_answers_its_entries() -> None:
    queue = AttentionQueue()
    found = [problem("blimp"), problem("blimp", "hold height"), problem("rover")]
    answered = [entry.answered for entry in queue.look(found, "rover", 0.0)]
    assert answered == [False, False, True]
    assert all(entry.answered for entry in queue.look(found, "blimp", 1.0))
    assert all(entry.answered for entry in queue.look(found, "rover", 60.0)), "it stays answered"


def test_an_entry_without_an_answer_is_raised_again_after_ten_seconds() -> None:
    queue = AttentionQueue()
    found = [problem("blimp")]
    raised = [queue.look(found, "rover", now)[0] for now in (0.0, AGAIN_S - 0.1, AGAIN_S, 19.0)]
    assert [(entry.raised, entry.times) for entry in raised] == [
        (0.0, 1),
        (0.0, 1),
        (AGAIN_S, 2),
        (AGAIN_S, 2),
    ]
    assert {entry.since for entry in raised} == {0.0}
    queue.look(found, "blimp", 19.5)
    assert queue.look(found, "rover", 60.0)[0].times == 2


def test_an_answered_entry_is_raised_again_when_it_is_worse_than_ever() -> None:
    queue = AttentionQueue()
    warning, alarm = [problem("blimp", alarm=False)], [problem("blimp")]
    queue.look(warning, "blimp", 0.0)
    assert queue.look(warning, "rover", 1.0)[0].answered
    worse = queue.look(alarm, "rover", 2.0)[0]
    assert (worse.answered, worse.times, worse.raised) == (False, 2, 2.0)
    queue.look(alarm, "blimp", 3.0)
    queue.look(warning, "rover", 4.0)
    again = queue.look(alarm, "rover", 5.0)[0]
    assert (again.answered, again.times) == (True, 2), "it was as bad before"


def test_a_problem_that_comes_and_goes_is_raised_once() -> None:
    queue = AttentionQueue()
    queue.look([problem("blimp")], "blimp", 0.0)
    for number in range(1, 40):
        found = [problem("blimp")] if number % 2 else []
        for entry in queue.look(found, "rover", 0.5 * number):
            assert (entry.times, entry.answered, entry.since) == (1, True, 0.0)
    assert queue.look([], "rover", 30.0) == ()
    anew = queue.look([problem("blimp")], "rover", 30.0 + KEPT_S)[0]
    assert (anew.since, anew.answered) == (30.0 + KEPT_S, False)


def test_the_words_of_an_entry_are_always_the_newest() -> None:
    queue = AttentionQueue()
    queue.look([problem("blimp")], "", 0.0)
    newer = Problem(robot="blimp", cause="battery", text="9 %", alarm=True)
    assert queue.look([newer], "", 0.1)[0].text == "9 %"


def test_what_ended_stays_in_its_row_until_the_order_may_change() -> None:
    queue = AttentionQueue()
    both = [problem("blimp"), problem("rov")]
    queue.look(both, "", 0.0)
    entries = queue.look(both[1:], "", 0.5)
    assert [(entry.robot, entry.over) for entry in entries] == [("blimp", True), ("rov", False)]
    assert names(queue.look(both[1:], "", 1.0)) == [("rov", "battery")]


@given(
    st.lists(
        st.tuples(
            st.sets(st.tuples(st.sampled_from("abc"), st.sampled_from("xy"), st.booleans())),
            st.floats(0.01, 0.4),
            st.sampled_from("abc"),
        ),
        max_size=60,
    )
)
def test_the_order_changes_at_most_once_a_second(
    steps: list[tuple[set[tuple[str, str, bool]], float, str]],
) -> None:
    order: list[tuple[str, str]] = []
    queue, now, changed = AttentionQueue(), 0.0, -10.0
    for there, pause, seen in steps:
        now += pause
        found = [problem(robot, cause, alarm=alarm) for robot, cause, alarm in there]
        entries = queue.look(found, seen, now)
        assert len(set(names(entries))) == len(entries)
        if names(entries) != order:
            assert now - changed >= ORDER_S
            order, changed = names(entries), now
            alarms = [entry.alarm for entry in entries]
            assert alarms == sorted(alarms, reverse=True)
            assert {key[:2] for key in there} == set(order)


def entry(robot: str, *, answered: bool = False, over: bool = False) -> AttentionEntry:
    return AttentionEntry(
        robot=robot,
        cause="battery",
        text="",
        alarm=True,
        since=0.0,
        raised=0.0,
        times=1,
        answered=answered,
        over=over,
    )


@pytest.mark.parametrize(
    ("queue", "chosen", "wanted"),
    [
        ([], "a", ""),
        ([entry("a")], "a", ""),
        ([entry("a"), entry("b"), entry("c")], "a", "b"),
        ([entry("b", answered=True), entry("c")], "a", "c"),
        ([entry("b", over=True), entry("c", answered=True)], "a", "c"),
        ([entry(each, answered=True) for each in "abc"], "a", "b"),
        ([entry(each, answered=True) for each in "abc"], "b", "c"),
        ([entry(each, answered=True) for each in "abc"], "c", "a"),
        ([entry(each, answered=True) for each in "bc"], "a", "b"),
    ],
)
def test_the_next_alarm_is_the_first_unanswered_one_of_another_robot(
    queue: list[AttentionEntry], chosen: str, wanted: str
) -> None:
    assert next_robot(queue, chosen) == wanted
