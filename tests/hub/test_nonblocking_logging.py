"""Logging: one place in the program does not fill a log."""

from __future__ import annotations

import logging

from hub.nonblocking_logging import AT_ONCE, PER_S, Bound


def record(line: int, level: int = logging.WARNING) -> logging.LogRecord:
    return logging.LogRecord("hub", level, "a/file.py", line, "refused", (), None)


def test_one_place_logs_no_more_than_its_rate_and_says_what_was_left_out() -> None:
    now = [100.0]
    bound = Bound(lambda: now[0])
    assert [bound.before(record(7)) for _ in range(5000)] == [0] * AT_ONCE + [None] * (
        5000 - AT_ONCE
    )
    # Another place, and what a developer asked for, are not held up by it.
    assert bound.before(record(8)) == 0
    assert bound.before(record(7, logging.DEBUG)) == 0
    now[0] += 1.0 / PER_S
    assert bound.before(record(7)) == 5000 - AT_ONCE
    assert bound.before(record(7)) is None
