"""Limits of waits grow on a slow or busy machine, and end on one that is neither."""

from __future__ import annotations

import time

import pytest

from tests.support import waiting
from tests.support.waiting import Limit, until


def test_a_limit_grows_with_slowness_and_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    monkeypatch.setattr(waiting, "slowness", lambda: slow)
    limit, slow = Limit(2.0), 3.0
    for later, over in ((1.9, False), (2.1, False), (5.9, False), (6.1, True)):
        now = 100.0 + later
        assert limit.over == over, later
    slow = 4.0
    assert not limit.over
    slow, now = 1.0, 108.1
    assert limit.over


def test_a_condition_that_came_while_this_process_was_held_up_counts() -> None:
    asked: list[int] = []
    until(lambda: asked.append(1) or len(asked) == 2, timeout=-1.0)
    with pytest.raises(AssertionError, match="never"):
        until(lambda: False, timeout=-1.0, why="never")
