"""A robot of a fleet behind a line that is too thin for its states: their twins are fresh."""

from __future__ import annotations

import logging
import statistics
import time
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.doors.fleet.gateway import FleetGateway
from hub.doors.mirror.mirror import Mirror
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.roles import Principal, Role
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.transport.loop import Loop
from hub.robots.fleet_table import FleetTable
from hub.zenoh.fleet_line import ZenohFleetLine
from hub.zenoh.fleet_session import open_fleet_session
from hub.zenoh.settings import RouterPlace, client_settings, router_settings
from tests.support.ports import free_port
from tests.support.thin_link import ADDRESS, ThinLink
from tests.support.waiting import until

_RATE_BIT_S = 100_000.0
"""The states need 240 kbit/s, and their twins 10."""


@pytest.mark.soak
def test_states_are_fresh_again_on_a_line_that_is_too_thin_for_all_of_them(tmp_path: Path) -> None:
    port = free_port()
    place = RouterPlace(scheme="tcp", host="127.0.0.1", port=port)
    with ExitStack() as stack:
        stack.enter_context(
            closing(open_fleet_session(place, router_settings([place]), mode="router"))
        )
        loop = Loop()
        stack.callback(loop.close)
        central = stack.enter_context(closing(Central([f"ipc://{tmp_path}/hub"])))
        gate, source = (
            stack.enter_context(closing(Client(name, central.endpoints[0], loop=loop)))
            for name in ("fleet", "source")
        )
        state = ControlState(operator="ann", why="x" * 400)
        source.define(CONTROL_STATE)
        source.every(0.02, lambda: source.publish(CONTROL_STATE, state))
        gateway = FleetGateway(gate, "rover", FleetTable(place=place))
        stack.callback(gateway.finish)
        stack.enter_context(
            closing(ThinLink(f"tcp://127.0.0.1:{port}", rate=_RATE_BIT_S, room=8000, ports=1))
        )
        near = RouterPlace(scheme="tcp", host=ADDRESS, port=port)
        line = stack.enter_context(closing(ZenohFleetLine(near, client_settings(near), loop)))
        events: list[dict[str, Any]] = []
        mirror = Mirror(
            line,
            "rune",
            Principal(name="ann", role=Role.OPERATE),
            robots=(),
            folder=tmp_path,
            loop=loop,
            faults=FaultCounter(logging.getLogger(), time.monotonic),
            report=events.append,
        )
        stack.enter_context(closing(mirror))

        def wait(condition: Any, why: str) -> None:
            until(condition, 30.0, lambda: f"{why}: {events}", meanwhile=lambda: loop.listen(0.01))

        wait(lambda: events, "the robot is not there")
        endpoint = str(events[0]["endpoint"])
        reader = stack.enter_context(closing(Client("reader", endpoint, loop=loop, near=False)))
        ages: list[float] = []
        reader.subscribe(CONTROL_STATE, lambda _, info: ages.append(info.age))
        wait(lambda: any(event["event"] == "rate" for event in events), "the rate is not chosen")
        full = max(ages)
        ages.clear()
        wait(lambda: len(ages) > 10 and max(ages[-5:]) < 0.2, f"states stay old: {ages[-10:]}")
        print(f"oldest before {full:.2f} s, median then {statistics.median(ages[-5:]):.3f} s")  # noqa: T201
        assert full > 0.4
        assert reader.lost < 100, "what the low rate leaves out is not lost"
