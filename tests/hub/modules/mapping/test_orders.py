"""Orders that take disk: maps are saved and missions begun no faster than their rate allows."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path
from random import Random

import pytest

from hub.gcm.mapping import MAP_COMMAND, MapCommand, MapOrder
from hub.gcm.mission import MISSION_COMMAND, MissionAction, MissionCommand
from hub.modules.mapping.__main__ import Mapping
from hub.robots.robot_file import find_robot_file, read_description
from tests.hub.modules.extremes_bus import ExtremesBus


def test_a_flood_of_orders_makes_few_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "monotonic", lambda: 1000.0)
    maps, missions = tmp_path / "maps", tmp_path / "missions"
    robot, _ = read_description(find_robot_file("magellan"))
    robot = dataclasses.replace(robot, map_folder=str(maps), mission_folder=str(missions))
    bus = ExtremesBus(time.monotonic, Random(7))
    Mapping(bus, robot)  # type: ignore[arg-type]
    (save,), (order,) = bus.handlers[MAP_COMMAND.name], bus.handlers[MISSION_COMMAND.name]
    for number in range(100):
        save(MapCommand(order=MapOrder.SAVE, name=f"map{number}"))
        order(MissionCommand(action=MissionAction.BEGIN, by="Eve"))
        order(MissionCommand(action=MissionAction.END, by="Eve"))
    assert 1 <= len(list(maps.glob("*.yaml"))) <= 20
    assert 1 <= len(list(missions.glob("*/*/journal"))) <= 10
