"""The driver's own stop."""

from __future__ import annotations

from hub.modules.driver.watchdog import SILENCE_S, CommandWatchdog


def driving(at: float = 10.0) -> CommandWatchdog:
    watchdog = CommandWatchdog()
    assert watchdog.allows(at, at, neutral=True)
    return watchdog


def test_nothing_is_followed_before_a_neutral_command_came() -> None:
    watchdog = CommandWatchdog()
    assert watchdog.expired(0.0)
    assert not watchdog.allows(0.0, 0.0, neutral=False)
    assert watchdog.expired(0.0)


def test_fresh_commands_are_followed_after_neutral() -> None:
    assert driving().allows(10.1, 10.1, neutral=False)


def test_expires_when_commands_stop_coming() -> None:
    watchdog = driving(10.0)
    assert not watchdog.expired(10.0 + SILENCE_S - 0.001)
    assert watchdog.expired(10.0 + SILENCE_S)


def test_after_a_silence_neutral_comes_first() -> None:
    watchdog = driving(10.0)
    assert not watchdog.allows(11.0, 11.0, neutral=False)
    assert watchdog.allows(11.1, 11.1, neutral=True)
    assert watchdog.allows(11.2, 11.2, neutral=False)


def test_a_command_that_was_queued_is_not_followed() -> None:
    assert not driving(10.0).allows(10.0 - SILENCE_S, 10.1, neutral=False)


def test_a_late_command_counts_for_the_rest_of_its_time_only() -> None:
    watchdog = driving(10.0)
    assert watchdog.allows(10.05, 10.25, neutral=False)
    assert watchdog.expired(10.05 + SILENCE_S)
