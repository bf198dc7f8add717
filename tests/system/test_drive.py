"""`rune drive`: one command from a vehicle's address to the console, and nothing stays behind."""

from __future__ import annotations

import socket
import tomllib
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from tests.support.command_line import rune
from tests.support.fake_vehicle import FakeVehicle, served
from tests.support.ports import free_port
from tests.support.waiting import until
from tests.system.autopilot_site import SimulatedVehicle
from tests.system.harness import ConsoleProcess, family, gone, press


def rover() -> FakeVehicle:
    vehicle = FakeVehicle()
    vehicle.parameters = {"FS_GCS_ENABLE": (0.0, 2)}
    return vehicle


def test_it_says_what_is_unsafe_opens_the_console_and_ends_its_hub(
    stack: ExitStack, tmp_path: Path
) -> None:
    path = tmp_path / "found.toml"
    address = stack.enter_context(served(rover()))
    command = ["drive", f"mavlink:{address}", "-o", str(path)]
    console = stack.enter_context(closing(ConsoleProcess(command, columns=120, rows=40)))
    console.wait(lambda: "Enter opens the console" in console.text, 30.0)
    assert "a rover with ArduPilot 4.7.0" in console.text
    assert "unsafe: FS_GCS_ENABLE is 0 in place of 1" in console.text
    assert "DISARMED" not in console.text, "the operator reads first"
    console.type("\r")
    console.wait(lambda: {"DISARMED", "autopilot"} <= {*console.text.split()}, 20.0)
    processes = family(console.process.pid)
    assert console.quit() == ExitCode.OK
    until(lambda: gone(processes), 10.0, "processes are left")
    assert tomllib.loads(path.read_text())["mavlink"]["address"] == address


def test_end_of_input_is_no_answer(stack: ExitStack) -> None:
    address = stack.enter_context(served(rover()))
    console = stack.enter_context(closing(ConsoleProcess(["drive", f"mavlink:{address}"])))
    console.wait(lambda: "Enter opens the console" in console.text, 30.0)
    console.type("\x04")  # Ctrl-D
    assert console.wait_ended(20.0) == ExitCode.FAULT
    assert "nobody answered; --yes opens the console all the same" in " ".join(console.text.split())


@pytest.mark.parametrize("address", ["udp://:14550", "ws:robot", "mavlink", "mavlink:", "hub:a"])
def test_an_address_without_a_kind_of_link_is_refused(address: str) -> None:
    with closing(ConsoleProcess(["drive", address])) as console:
        assert console.wait_ended() == ExitCode.USAGE
        said = " ".join(console.text.split())
        assert "has no kind of link: write mavlink:udp://:14550 for an autopilot, ws://HOST" in said


def test_a_host_without_a_kind_of_link_gets_both() -> None:
    with closing(ConsoleProcess(["drive", "robot:8765"])) as console:
        assert console.wait_ended() == ExitCode.USAGE
        said = "".join(console.text.split())
        assert "writemavlink:tcp://robot:8765foranautopilot,ws://robot:8765forROS" in said


def test_an_address_without_a_kind_of_network_gets_both() -> None:
    with closing(ConsoleProcess(["drive", "mavlink:127.0.0.1:5760"])) as console:
        assert console.wait_ended() == ExitCode.USAGE
        said = "".join(console.text.split())
        assert "mavlink:tcp://127.0.0.1:5760ormavlink:udp://127.0.0.1:5760" in said


def test_without_a_vehicle_it_says_so_and_starts_nothing() -> None:
    silent = f"mavlink:tcp://127.0.0.1:{free_port()}"
    with closing(ConsoleProcess(["drive", silent])) as console:
        assert console.wait_ended(20.0) == ExitCode.NO_HUB
        assert "rune-hub: " in console.text


def test_without_a_terminal_it_does_not_begin() -> None:
    done = rune("drive", "mavlink:udp://:14550")
    assert done.returncode == ExitCode.USAGE
    assert "needs a terminal" in done.stderr


KEYS = {"arm": "\x1b[19~", "disarm": "\x1b[20~", "next mode": "\x1bOQ", "set mode": "\x1bOR"}


def driven(vehicle: SimulatedVehicle) -> ConsoleProcess:
    command = ["drive", "--yes", f"mavlink:tcp://127.0.0.1:{vehicle.port}"]
    return ConsoleProcess(command, columns=120, rows=40)


def other_station(vehicle: SimulatedVehicle, mode: int) -> None:
    """Another station sets a mode."""
    order = FramePacker(254, 190).pack(
        "COMMAND_LONG", target_system=1, target_component=1, command=176, param1=1.0, param2=mode
    )
    parser, answers = FrameParser(), []
    with socket.create_connection(("127.0.0.1", vehicle.port), 5.0) as link:
        link.sendall(order)
        while "COMMAND_ACK" not in answers:
            answers += [frame.name for frame in parser.feed(link.recv(4096))]


def test_keys_arm_drive_hold_and_disarm_and_another_station_takes_the_vehicle(
    stack: ExitStack,
) -> None:
    vehicle = stack.enter_context(closing(SimulatedVehicle("rover")))
    console = stack.enter_context(closing(driven(vehicle)))

    def shows(text: str, seconds: float = 15.0) -> None:
        console.wait(lambda: text in " ".join(console.text.split()), seconds, f"no {text!r}")

    shows("arm it", 40.0)
    press(console, KEYS["arm"])
    shows("ARM the motors?")
    press(console, KEYS["arm"])
    shows("ARMED · guided · follows you")
    console.hold_until("w", lambda: "MOVING" in console.text)
    press(console, "h")
    shows("ARMED · hold · does not follow")
    press(console, "f")
    shows("ARMED · guided · follows you")
    other_station(vehicle, 4)
    shows("ARMED · hold · does not follow")
    shows("not asked for")
    press(console, KEYS["next mode"])
    shows("MODE guided?")
    press(console, KEYS["set mode"])
    shows("ARMED · guided · follows you")
    press(console, KEYS["disarm"])
    shows("DISARMED · guided")


@pytest.mark.soak
def test_a_vehicle_that_refuses_to_arm_says_why(stack: ExitStack) -> None:
    vehicle = stack.enter_context(closing(SimulatedVehicle("rover", booted=False)))
    console = stack.enter_context(closing(driven(vehicle)))
    console.wait(lambda: "DOES NOT KNOW ITS PLACE" in console.text, 40.0)
    press(console, KEYS["arm"])
    console.wait(lambda: "ARM the motors?" in console.text, 5.0)
    press(console, KEYS["arm"])
    console.wait(lambda: "was refused" in " ".join(console.text.split()), 10.0)
    assert "DISARMED ·" in console.text
