"""Publishes the state and the texts of a body's autopilot, and the bytes of its link."""

from __future__ import annotations

import math
from typing import Final

from hub.gcm.autopilot import AUTOPILOT_STATE, AUTOPILOT_TEXT, MAVLINK_FRAMES, AutopilotState
from hub.ipc.client import Client
from hub.modules.driver.publishing_rate import PublishingRate
from hub.robots.interfaces import Body, BodyModes

_LOOK_S: Final = 0.09
"""Least time between two states; a little less than a tenth, so that no change waits longer [s]."""


class AutopilotReports:
    """The reports of one body; none without an autopilot."""

    def __init__(self, client: Client, body: Body) -> None:
        self._client = client
        self._body = body if isinstance(body, BodyModes) else None
        self._rate = PublishingRate(AUTOPILOT_STATE.rate_hz)
        self._look_at = -math.inf
        if self._body is not None:
            client.define(AUTOPILOT_STATE, AUTOPILOT_TEXT, MAVLINK_FRAMES)

    def publish(self, stamp: float, now: float) -> None:
        """Publish the texts and bytes that came, and the state when it is due.

        Args:
            stamp: The time now [s since the epoch].
            now: The same on the monotonic clock [s].
        """
        if self._body is None:
            return
        for text in self._body.take_texts():
            self._client.publish(AUTOPILOT_TEXT, text, measured=now)
        wanted = self._client.has_subscribers(MAVLINK_FRAMES)
        for frames in self._body.take_frames(wanted=wanted):
            self._client.publish(MAVLINK_FRAMES, frames, measured=now)
        if now < self._look_at:
            return
        self._look_at = now + _LOOK_S
        state = self._body.autopilot(stamp)
        if self._rate.due(_change_of(state), now):
            self._client.publish(AUTOPILOT_STATE, state, measured=now)


def _change_of(state: AutopilotState) -> tuple[object, ...]:
    """What counts as a change; ages and times always differ a little."""
    return (
        state.phase,
        state.why,
        state.mode,
        state.modes,
        state.armable,
        state.failsafe,
        state.position,
        tuple((each.name, each.value) for each in state.unsafe),
    )
