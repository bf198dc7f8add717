"""Goals for the navigation that a body has itself: from navigation to the body, and its reports."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

from hub.gcm.own_navigation import DRIVE_GOAL, OWN_NAVIGATION, DriveGoal
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.modules.driver.publishing_rate import PublishingRate
from hub.robots.interfaces import Body, BodyNavigates

_LAST_WAIT_S: Final = 0.9
"""Longest time that a driver that ends waits for the end of a goal: less than modules have once the
hub is dead [s]."""
_STEP_S: Final = 0.01


class BodyGoals:
    """The goals of one body; without navigation of its own it has none."""

    def __init__(
        self, client: Client, body: Body, allows: Callable[[MessageInfo, float], bool]
    ) -> None:
        """Take goals.

        Args:
            client: The driver's connection.
            body: The hardware.
            allows: Whether the driver follows a goal of this reception at a monotonic time [s].
        """
        self._client, self._allows = client, allows
        self._body = body if isinstance(body, BodyNavigates) else None
        self._rate = PublishingRate(OWN_NAVIGATION.rate_hz)
        if self._body is not None:
            client.define(OWN_NAVIGATION)
            client.subscribe(DRIVE_GOAL, self._go)

    def publish(self, now: float) -> None:
        """Publish the state when it is due [s, monotonic]."""
        if self._body is not None:
            state = self._body.own_navigation()
            goal = (state.number, state.goal, state.why)
            key = (state.available, *goal, state.others, state.unanswered)
            if self._rate.due(key, now):
                self._client.publish(OWN_NAVIGATION, state, measured=now)

    def finish(self, advance: Callable[[float], object]) -> None:
        """Wait for the end of a goal that was cancelled, but not for long.

        Args:
            advance: Advances the body by a time [s].
        """
        end = time.monotonic() + _LAST_WAIT_S
        while self._body is not None and self._body.own_navigation().ending:
            if time.monotonic() >= end:
                break
            time.sleep(_STEP_S)
            advance(_STEP_S)

    def _go(self, goal: DriveGoal, reception: MessageInfo) -> None:
        if self._body is not None and self._allows(reception, time.monotonic()):
            self._body.go(goal)
