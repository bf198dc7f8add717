"""What a robot does that has lost its operator."""

from __future__ import annotations

import pytest

from hub.robots.left_alone import LeftAlone, OperatorWatch

A, B = 1, 2


def lost(wanted: LeftAlone) -> OperatorWatch:
    """The operator has been lost at 100 s."""
    watch = OperatorWatch(wanted)
    watch.controlled_by(A, 50.0)
    watch.controlled_by(0, 100.0)
    return watch


@pytest.mark.parametrize("wanted", LeftAlone)
def test_who_never_had_an_operator_has_lost_none(wanted: LeftAlone) -> None:
    watch = OperatorWatch(wanted)
    watch.controlled_by(0, 1.0)
    assert watch.action(1000.0) is None


def test_what_rolls_stands_and_what_flies_holds_its_height_at_once() -> None:
    assert lost(LeftAlone.STAND).action(100.0) is LeftAlone.STAND
    assert lost(LeftAlone.HOLD_HEIGHT).action(100.0) is LeftAlone.HOLD_HEIGHT


def test_what_dives_keeps_neutral_and_surfaces_after_ten_seconds() -> None:
    watch = lost(LeftAlone.SURFACE)
    assert watch.action(109.9) is LeftAlone.STAND
    assert watch.action(110.0) is LeftAlone.SURFACE
    watch.controlled_by(0, 111.0)
    assert watch.action(112.0) is LeftAlone.SURFACE


def test_a_new_operator_ends_it() -> None:
    watch = lost(LeftAlone.SURFACE)
    watch.controlled_by(B, 120.0)
    assert watch.action(120.0) is None
    watch.controlled_by(0, 130.0)
    assert watch.action(139.9) is LeftAlone.STAND


def test_while_a_task_goes_on_the_time_does_not_run() -> None:
    watch = lost(LeftAlone.SURFACE)
    watch.moved(108.0)
    assert watch.action(117.9) is LeftAlone.STAND
    assert watch.action(118.0) is LeftAlone.SURFACE
