"""How a robot stops that a panel or a node drove through a door."""

from __future__ import annotations

from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import CONTROL_REQUEST, ControlAction, ControlRequest
from hub.ipc.client import Client
from tests.system.harness import Observer

STOP_S = 0.5
"""Silence counts after 0.25 s; the rest is for a busy machine [s]."""


def stopped_after(observer: Observer, since: float) -> float:
    """Time from a moment until the robot was commanded to stand [s]."""
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 5.0, "the wheels are driven on")
    observer.wait(lambda: observer.history[-1][0] > since, 5.0)
    driven = [at for at, truth in observer.history if truth.commanded_linear != 0.0]
    return driven[-1] - since


def free(client: Client) -> None:
    """End control, as an operator at the robot does."""
    request = ControlRequest(action=ControlAction.FREE)
    client.query_response(CONTROL_REQUEST, request, COMMON_RESULT, timeout=5.0)
