"""Rows of numbers of which the newest says all, however many were lost before it."""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.devices.inbox import Inbox
from rune_tui.controls.hid.reading import Value
from rune_tui.controls.remote_pad.pad_values import Row, reports
from tests.console.controls.joystick.pads import BALL, HAT, LEFT_X, LEFT_Y, PAD, REST, A

RAWS: dict[int, st.SearchStrategy[int | None]] = {
    LEFT_X: st.integers(-(1 << 31) + 1, (1 << 31) - 1),
    LEFT_Y: st.integers(0, 255),
    A: st.integers(0, 1),
    HAT: st.one_of(st.none(), st.integers(0, 7)),
    BALL: st.integers(-127, 127),
}
VALUES = st.sampled_from(sorted(RAWS)).flatmap(
    lambda position: st.tuples(st.just(position), RAWS[position])
)
ANY_ROW = st.lists(st.integers(-(1 << 31), (1 << 31) - 1), min_size=len(PAD), max_size=len(PAD))


def replayed(rows: Sequence[Sequence[int]]) -> list[Value]:
    """All that an inbox gives out of these rows, one after the other."""
    inbox, taken, before = Inbox(PAD), [], None
    for row in rows:
        for values in reports(PAD, before, row):
            inbox.put(values)
        taken += inbox.take()
        before = row
    return taken


def ends(values: Sequence[Value]) -> dict[int, int | None]:
    """How each control but the ball stands at last; the ball's turns together."""
    told: dict[int, int | None] = {
        position: raw for position, raw in values if position != BALL and raw is not None
    }
    told |= {HAT: next((raw for position, raw in reversed(values) if position == HAT), None)}
    return told | {BALL: sum(raw or 0 for position, raw in values if position == BALL)}


@given(values=st.lists(VALUES, max_size=40), kept=st.sets(st.integers(0, 40)))
def test_whatever_rows_are_lost_the_last_one_tells_how_all_controls_stand(
    values: list[Value], kept: set[int]
) -> None:
    row = Row(PAD)
    rows = [list(row.values)]
    for value in values:
        row.take([value])
        rows.append(list(row.values))
    came = [rows[0], *(each for number, each in enumerate(rows) if number in kept), rows[-1]]
    rest: list[Value] = [(A, 0), (HAT, None)]
    assert ends(replayed(came)) == ends([*rest, *values])


def test_a_click_between_two_rows_is_pressed_and_released_and_a_third_edge_is_told() -> None:
    row = Row(PAD)
    row.take(REST)
    first = list(row.values)
    for raws, told in (([1, 0], [1, 0]), ([1], [1]), ([0, 1, 0], [0, 1, 0])):
        before = list(row.values)
        row.take([(A, raw) for raw in raws])
        edges = [raw for values in reports(PAD, before, row.values) for p, raw in values if p == A]
        assert edges == told
    assert [*reports(PAD, first, first)] == [(*REST, (BALL, 0))]


def test_of_a_hundred_clicks_one_is_told() -> None:
    row = Row(PAD)
    before = list(row.values)
    row.take([(A, raw) for _ in range(100) for raw in (1, 0)])
    edges = [raw for values in reports(PAD, before, row.values) for p, raw in values if p == A]
    assert edges == [1, 0]


@given(before=st.one_of(st.none(), ANY_ROW), now=ANY_ROW)
def test_any_numbers_are_a_row(before: list[int] | None, now: list[int]) -> None:
    inbox = Inbox(PAD)
    told = list(reports(PAD, before, now))
    for values in told:
        inbox.put(values)
    assert len(told) <= 3
    assert dict(inbox.everything())[A] == now[A] & 1


def test_a_row_says_whether_it_changed() -> None:
    row = Row(PAD)
    assert row.take(REST)
    assert not row.take(REST)
    assert row.take([(A, 1), (A, 0)])
    assert not row.take([(BALL, 0)])
