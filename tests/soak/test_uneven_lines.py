"""Links whose ways up and down differ, between real processes: no old command turns the wheels."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import GROUND_TRUTH, VELOCITY_COMMAND
from hub.ipc.client import Client
from hub.shaper.shaped_link import ShapedLink
from tests.support.waiting import until
from tests.system.harness import HubProcess, Observer

pytestmark = pytest.mark.soak

COMMAND_S, HELD_S, WATCHED_S = 0.05, 2.0, 3.0
LATEST_S = VELOCITY_COMMAND.lifespan_s + 0.1
"""The lifespan, and the time from navigation to a report of the wheels on a busy machine [s]."""
LINES = [
    (50, 0, 0, True),
    (0, 50, 0, True),
    (150, 0, 0, True),
    (20, 130, 0, True),
    (400, 0, 0, False),
    (400, 50, 20, False),
    (250, 250, 30, False),
    (700, 100, 0, False),
    (90, 90, 5, True),
    (600, 300, 0, False),
]
"""Delay up and down, jitter [ms]; whether it drives."""


@pytest.fixture(scope="module")
def hub(tmp_path_factory: pytest.TempPathFactory) -> Iterator[HubProcess]:
    with closing(HubProcess(tmp_path_factory.mktemp("hub"), options=("--listen", "0"))) as running:
        yield running


@pytest.mark.parametrize(("up", "down", "jitter", "drives"), LINES)
def test_the_wheels_turn_for_the_lifespan_after_the_last_command_and_no_longer(
    hub: HubProcess, tmp_path: Path, up: int, down: int, jitter: int, *, drives: bool
) -> None:
    profile = tmp_path / "uneven.toml"
    profile.write_text(
        f"[up]\ndelay_ms = {up}\njitter_ms = {min(jitter, up)}\n"
        f"[down]\ndelay_ms = {down}\njitter_ms = {min(jitter, down)}\n"
    )
    with ExitStack() as stack:
        observer = stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH, DIAGNOSTICS)))
        link = stack.enter_context(ShapedLink(hub.endpoint, str(profile), 1))
        # Not the machine's clock, so it is as on another machine.
        console = stack.enter_context(
            closing(
                Client("far", link.endpoint, clock=lambda: time.monotonic() + 7200.0, near=False)
            )
        )
        console.define(VELOCITY_COMMAND)
        console.wait_connected(30.0)

        def send(linear: float, seconds: float) -> None:
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                console.publish(VELOCITY_COMMAND, TwistStamped.planar(linear, 0.0))
                until_next = time.monotonic() + COMMAND_S
                while time.monotonic() < until_next:
                    console.listen(0.005)
                    observer.client.listen(0.005)

        send(0.0, 2.0 + 2.0 * (up + down) / 1e3)
        observer.history.clear()
        said = observer.seen[DIAGNOSTICS.name]
        said.clear()
        send(0.3, HELD_S)
        released = time.monotonic()
        send(0.0, WATCHED_S)
        turning = [at for at, truth in observer.history if truth.commanded_linear > 0.0]
        assert bool(turning) == drives
        assert max(turning, default=0.0) < released + LATEST_S

        def alarmed() -> bool:
            return any(_is_late(each) for _, each in said)

        if not drives:
            until(alarmed, 5.0, "it says nothing", meanwhile=lambda: observer.client.listen(0.01))


def _is_late(found: Diagnostics) -> bool:
    return any(status.name == "late commands" for status in found.status)
