"""Sentences for people in the log: a few at once, then one a minute."""

from __future__ import annotations

import logging

import pytest

from hub.doors.panels.sentence_log import AT_ONCE, SentenceLog


def test_sentences_that_alternate_for_an_hour_are_one_line_a_minute(
    caplog: pytest.LogCaptureFixture,
) -> None:
    now = 0.0
    log = SentenceLog(logging.getLogger(), lambda: now)
    while now < 3600.0:
        log.note(f"sentence {now}")
        log.note("")
        now += 0.4
    assert caplog.messages[:2] == ["sentence 0.0", "sentence 0.4"]
    assert AT_ONCE < len(caplog.messages) <= AT_ONCE + 60
