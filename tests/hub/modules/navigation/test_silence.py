"""Navigation stops the wheels when the operator's silence has lasted long enough."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import DRIVE_COMMAND, DRIVE_STATE, VELOCITY_COMMAND
from hub.modules.navigation.__main__ import Navigation
from hub.modules.navigation.speed_governor import SILENCE_S
from hub.robots.robot_file import find_robot_file, read_description
from tests.hub.modules.navigation.test_lost_place import AT_ORIGIN
from tests.hub.modules.timed_bus import TimedBus


def test_it_commands_zero_at_once_and_not_with_the_next_cycle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    bus = TimedBus(monkeypatch)
    robot, _ = read_description(find_robot_file("magellan"))
    Navigation(bus, robot)  # type: ignore[arg-type]
    bus.wait(0.013)
    bus.send(DRIVE_STATE, AT_ORIGIN, "driver")
    bus.send(VELOCITY_COMMAND, TwistStamped(), "console")
    bus.send(VELOCITY_COMMAND, TwistStamped.planar(0.4, 0.0), "console")
    commanded = bus.now
    bus.wait(1.0)
    commands = [
        (at, twist.neutral) for at, name, twist in bus.published if name == DRIVE_COMMAND.name
    ]
    moving = [at for at, neutral in commands if not neutral]
    stopped = min(at for at, neutral in commands if neutral and at > moving[0])
    assert moving[0] == commanded
    assert stopped == pytest.approx(commanded + SILENCE_S, abs=1e-9)
    assert max(moving) < stopped


def test_after_a_sleep_of_its_computer_the_robot_stands_until_neutral_and_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    bus = TimedBus(monkeypatch)
    robot, _ = read_description(find_robot_file("magellan"))
    Navigation(bus, robot)  # type: ignore[arg-type]

    def drive(speed: float) -> list[bool]:
        """Send a command; whether each of the driver's is neutral."""
        bus.published.clear()
        bus.send(DRIVE_STATE, AT_ORIGIN, "driver")
        bus.send(VELOCITY_COMMAND, TwistStamped.planar(speed, 0.0), "console")
        bus.wait(0.1)
        return [twist.neutral for _, name, twist in bus.published if name == DRIVE_COMMAND.name]

    drive(0.0)
    assert not any(drive(0.4))
    bus.published.clear()
    bus.sleep(12.0)
    commands = [twist.neutral for _, name, twist in bus.published if name == DRIVE_COMMAND.name]
    assert commands
    assert all(commands)
    assert "stopped: the robot's computer slept for 12.0 s" in caplog.text
    assert "the robot's computer slept for 12.0 s" in [
        problem.message
        for _, name, found in bus.published
        if name == DIAGNOSTICS.name
        for problem in found.status
    ]
    assert all(drive(0.4)), "a key that was held through the sleep does not drive"
    drive(0.0)
    assert not any(drive(0.4))
