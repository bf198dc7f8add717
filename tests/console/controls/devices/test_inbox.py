from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.devices.inbox import MOST_EDGES, Inbox
from tests.console.controls.joystick.pads import BALL, HAT, LEFT_X, PAD, A


def test_of_an_axis_the_newest_counts_and_of_a_button_every_edge() -> None:
    inbox = Inbox(PAD)
    for x, a in ((1, 1), (2, 0), (3, 1)):
        assert inbox.put(
            (
                (LEFT_X, x),
                (A, a),
            )
        )
    taken = inbox.take()
    assert [raw for position, raw in taken if position == LEFT_X] == [3]
    assert [raw for position, raw in taken if position == A][:3] == [1, 0, 1]
    assert inbox.take() == []


def test_a_report_that_says_the_same_again_is_no_news() -> None:
    inbox = Inbox(PAD)
    assert inbox.put(
        (
            (LEFT_X, 1),
            (HAT, None),
        )
    )
    inbox.take()
    assert not inbox.put(
        (
            (LEFT_X, 1),
            (HAT, None),
        )
    )
    assert inbox.take() == []
    assert dict(inbox.everything()) == {LEFT_X: 1, HAT: None}


def test_what_a_ball_turned_is_added_up() -> None:
    inbox = Inbox(PAD)
    for turned in (3, -1, 0, 5):
        inbox.put(((BALL, turned),))
    assert inbox.take() == [(BALL, 7)]
    assert not inbox.put(((BALL, 0),))


@given(st.lists(st.tuples(st.sampled_from((A, HAT)), st.integers(0, 1)), max_size=700))
def test_of_too_many_edges_the_oldest_are_counted_and_the_last_state_is_known(
    reports: list[tuple[int, int]],
) -> None:
    inbox = Inbox(PAD)
    for report in reports:
        inbox.put((report,))
    taken = inbox.take()
    assert dict(taken) == dict(reports)
    assert len(taken) <= MOST_EDGES + len(PAD)
    changes = sum(
        raw != dict(reports[:number]).get(position)
        for number, (position, raw) in enumerate(reports)
    )
    assert inbox.dropped == max(0, changes - MOST_EDGES)
