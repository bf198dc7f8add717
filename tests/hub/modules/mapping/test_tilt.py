"""A tilted robot's ranges meet the floor or pass over things: the map takes none of them."""

from __future__ import annotations

import dataclasses
import itertools
import logging
import math
import time
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

from hub.gcm.imu import IMU, Imu
from hub.gcm.mapping import MAP_REQUEST, Map, MapRequest
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.ranges import RANGES, RangeReadings, scan_of
from hub.ipc.message_info import MessageInfo
from hub.modules.mapping.__main__ import Mapping
from hub.robots.robot_file import find_robot_file, read_description
from tests.hub.modules.extremes_bus import ExtremesBus
from tests.support.messages import robot_state


class Bus(ExtremesBus):
    """Hands messages to the handlers at once, and keeps the last answer."""

    answer: Any = None

    def subscribe(self, definition: Any, handler: Callable[..., None], **_: Any) -> None:
        def take(value: Any) -> None:
            handler(value, MessageInfo(2, 1, 0, 0.0, self.clock()))

        self.handlers[definition.name].append(take)

    def check(self, _: Any, value: Any) -> None:
        self.answer = value

    def send(self, definition: Any, value: Any) -> None:
        for handler in self.handlers[definition.name]:
            handler(value)

    def map(self) -> Map:
        self.send(MAP_REQUEST, MapRequest(x=math.nan, y=math.nan))
        assert isinstance(self.answer, Map)
        return self.answer


def test_scans_of_a_tilted_robot_are_left_out_and_the_log_says_so_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    ticks = itertools.count(10_000)
    monkeypatch.setattr(time, "monotonic", lambda: next(ticks) * 0.01)
    robot, _ = read_description(find_robot_file("magellan"))
    robot = dataclasses.replace(robot, map_folder=str(tmp_path), mission_folder=str(tmp_path))
    bus = Bus(time.monotonic, Random(1))
    module = Mapping(bus, robot)  # type: ignore[arg-type]
    empty = bus.map().width_cells
    group = robot.body.ranges[0]
    stamps = itertools.count(1.0)

    def drive(x: float) -> None:
        bus.send(ROBOT_STATE, robot_state(x=x))
        scan = scan_of(group, np.full(group.beams, 2.0, np.float32), next(stamps))
        bus.send(RANGES, RangeReadings(scans=(scan,)))

    for tilt in (
        Imu.of(roll=0.1, pitch=0.0),
        Imu.of(roll=0.0, pitch=-0.1),
    ):
        bus.send(IMU, tilt)
        drive(tilt.roll_pitch_yaw[0])
        assert bus.map().width_cells == empty
    bus.send(IMU, Imu.of(roll=0.01, pitch=0.02))
    drive(0.5)
    assert bus.map().width_cells > empty
    module.finish()
    texts = [record.message for record in caplog.records if record.levelno >= logging.WARNING]
    assert texts == [
        "the robot is tilted: its scans are left out of the map",
        "2 scans were made while the robot was tilted",
    ]
