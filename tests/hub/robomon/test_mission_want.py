"""The robot's own want: mapping runs while a mission runs, whoever wants it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

from hub.gcm.mission import MissionState
from hub.missions.folder import MissionFolder
from hub.missions.keeper import MissionKeeper, MissionLimits
from hub.robomon.mission_want import MissionWant
from hub.robomon.wants import Wants
from hub.robots.description import MissionBegin, RobotDescription
from hub.robots.robot_file import find_robot_file, read_description

HOLDS = {"PRO_MAP": ["mission"], "PRO_POINTS": ["mission"]}


class Bus:
    """Hands messages to who subscribes."""

    def __init__(self) -> None:
        self.tell: Any = None

    def subscribe(self, _: object, handler: Any) -> None:
        self.tell = lambda state: handler(state, None)

    def every(self, *_: object) -> None:
        pass


@pytest.fixture
def robot(tmp_path: Path) -> RobotDescription:
    described, _ = read_description(find_robot_file("magellan"))
    return dataclasses.replace(described, mission_folder=str(tmp_path))


def want(robot: RobotDescription, bus: Bus, controlled: list[int]) -> tuple[MissionWant, Wants]:
    wants = Wants()
    made = MissionWant(
        bus, wants, robot, controlled=lambda: bool(controlled), clock=lambda: 1.0  # type: ignore[arg-type]
    )  # fmt: skip
    return made, wants


def test_who_has_control_and_a_mission_that_runs_want_mapping(robot: RobotDescription) -> None:
    controlled: list[bool] = []
    bus = Bus()
    made, wants = want(robot, bus, controlled)
    assert wants.current(1.0) == {}
    controlled.append(1)
    made.renew()
    assert wants.current(1.0) == HOLDS
    bus.tell(MissionState(running=1))
    controlled.clear()
    made.renew()
    assert wants.current(1.0) == HOLDS
    bus.tell(MissionState(running=0, fault="the disk cannot be read"))
    made.renew()
    assert wants.current(1.0) == HOLDS
    bus.tell(MissionState(running=0))
    made.renew()
    assert wants.current(1.0) == {}


def test_missions_by_hand_are_not_begun_by_control(robot: RobotDescription) -> None:
    by_hand = dataclasses.replace(robot, mission_begin=MissionBegin.BY_HAND)
    _, wants = want(by_hand, Bus(), [1])
    assert wants.current(1.0) == {}


def test_a_mission_of_before_the_start_wants_mapping(
    robot: RobotDescription, tmp_path: Path
) -> None:
    keeper = MissionKeeper(MissionFolder(tmp_path, robot.name), MissionLimits())
    keeper.open()
    keeper.begin("", "Ada")
    keeper.close()
    _, wants = want(robot, Bus(), [])
    assert wants.current(1.0) == HOLDS
    other = dataclasses.replace(robot, name="another")
    assert want(other, Bus(), [])[1].current(1.0) == {}
