"""Every shipped layout, and the one made for it, draws what each of the five bodies reports."""

from __future__ import annotations

import dataclasses
import functools
import logging
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.capability import Capability
from hub.gcm.control import CONTROL_STATE
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.flight import ALTITUDE
from hub.gcm.geometry import Twist, Vector3
from hub.gcm.imu import IMU
from hub.gcm.joints import JOINT_STATES
from hub.gcm.navigation import ROBOT_STATE, MotionState
from hub.gcm.ranges import RANGES, RangeReadings
from hub.gcm.vehicle import VEHICLE_STATE
from hub.modules.driver import reports
from hub.robots.registry import kind_of
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.startup.auto_layout import layout_text
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from tests.console.situations import MINE, ROOT, shipped
from tests.support.bodies import BODIES, robot_of
from tests.support.messages import camera_state, robot_state

NOW = 1000.0
LAYOUTS = sorted(path.stem for path in (ROOT / "layouts").glob("*.xml"))
LINK = LinkState(phase=LinkPhase.CONNECTED, since=NOW - 9.0, endpoint="tcp://127.0.0.1:1381")


@functools.cache
def messages_of(name: str) -> dict[str, object]:
    """What the hub of a robot with this body reports while it drives; None: nothing."""
    robot = robot_of(name)
    body = kind_of(robot).open_body(robot)
    body.command(Twist(linear=Vector3(x=0.3, y=0.1, z=0.1), angular=Vector3(z=0.2)))
    body.advance(1.5)
    sensors = body.sensors(NOW)
    drive = reports.drive_state(sensors, NOW)
    shared = ("x", "y", "theta", "linear", "angular", "bumpers")
    return {
        CONTROL_STATE.name: MINE,
        ROBOT_DESCRIPTION.name: robot.body,
        RANGES.name: RangeReadings(scans=sensors.scans) if sensors.scans else None,
        IMU.name: reports.imu(sensors, NOW),
        ALTITUDE.name: reports.altitude(sensors, NOW),
        VEHICLE_STATE.name: reports.vehicle(sensors, NOW),
        JOINT_STATES.name: reports.joints(sensors, NOW),
        DIAGNOSTICS.name: reports.diagnostics(sensors, NOW),
        ROBOT_STATE.name: dataclasses.replace(
            robot_state(),
            motion=MotionState.MOVING,
            **{each: getattr(drive, each) for each in shared},
        ),
    }


def state_of(layout: LayoutSpec, name: str) -> ConsoleState:
    """A console whose robots all have this body."""
    body = robot_of(name).body
    messages = {
        each: Received(value=value, measured=NOW - 0.1, number=1)
        for each, value in messages_of(name).items()
        if value is not None
    }
    main = body.cameras[0]
    camera = camera_state(name=main.name, horizontal_fov=main.horizontal_fov)
    pixels = np.arange(48 * 64 * 3, dtype=np.uint8).reshape(48, 64, 3)
    picture = Received(value=Picture(pixels=pixels, camera=camera), measured=NOW - 0.1, number=1)
    robots = {
        each.name: RobotState(name=each.name, link=LINK, picture=picture, messages=messages)
        for each in layout.robots
    }
    return dataclasses.replace(ConsoleState.at_start(layout, NOW, "ada"), robots=robots)


def sizes(layout: LayoutSpec) -> Iterator[tuple[int, int]]:
    """The least terminal [cells] of each arrangement, the design's, a tiny and a huge one."""
    for each in layout.view.arrangements:
        yield max(20, each.min_columns), max(6, each.min_rows)
        yield each.xsize, math.ceil(each.ysize / 2)
    yield 20, 6
    yield 300, 90


def draw(layout: LayoutSpec, name: str, caplog: pytest.LogCaptureFixture) -> None:
    """Draw at the sizes that the layout has arrangements for."""
    state = state_of(layout, name)
    view = View(layout, spent=lambda: 0.0)
    for columns, rows in sorted(set(sizes(layout))):
        view.resize(columns, rows)
        cells = view.render(state)
        assert cells is not None
        assert cells.glyphs.shape == (rows, columns)
        for pane in view.panes:
            for layer in pane.layers(state):
                height, width = layer.canvas.pixels.shape[:2]
                where = f"{pane.spec.name} at {columns}x{rows}"
                assert layer.x >= 0, where
                assert layer.y >= 0, where
                assert layer.x + width <= columns, where
                assert layer.y + height <= 2 * rows, where
    failed = [each for each in caplog.records if each.levelno >= logging.ERROR]
    assert not failed, (failed[0].getMessage(), failed[0].exc_text)


@pytest.mark.parametrize("name", BODIES)
def test_every_shipped_layout_draws_it_at_every_size(
    name: str, caplog: pytest.LogCaptureFixture
) -> None:
    for layout in LAYOUTS:
        draw(shipped(layout), name, caplog)


@pytest.mark.parametrize("name", BODIES)
def test_the_layout_made_for_it_draws_it_at_every_size(
    name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "auto.xml"
    able = {capability.value for capability in Capability}
    path.write_text(layout_text(robot_of(name).body, able, LINK.endpoint))
    draw(open_layout(path), name, caplog)
