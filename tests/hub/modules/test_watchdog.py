"""The driver's own stop."""

from __future__ import annotations

from hub.modules.driver.watchdog import SILENCE_S, CommandWatchdog


def test_is_expired_until_the_first_command() -> None:
    assert CommandWatchdog().expired(0.0)


def test_expires_when_commands_stop_coming() -> None:
    watchdog = CommandWatchdog()
    watchdog.fed(10.0)
    assert not watchdog.expired(10.0 + SILENCE_S - 0.001)
    assert watchdog.expired(10.0 + SILENCE_S)


def test_a_late_command_feeds_for_the_rest_of_its_time_only() -> None:
    watchdog = CommandWatchdog()
    watchdog.fed(10.0 - 0.2)
    assert watchdog.expired(10.0 + SILENCE_S - 0.2)
