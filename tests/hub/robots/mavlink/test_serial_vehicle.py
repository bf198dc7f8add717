"""A vehicle on a serial port that loses bytes and vanishes: real pseudo terminals."""

from __future__ import annotations

import contextlib
import os
import pty
import random
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.gcm.geometry import Twist
from hub.robots.mavlink.body import MavlinkBody
from hub.robots.mavlink.link.address import vehicle_address
from hub.robots.mavlink.link.opening import link_to
from hub.robots.mavlink.wire.frames import MavlinkFrame
from tests.hub.robots.mavlink.test_body import TICK_S, robot
from tests.hub.robots.mavlink.udp_vehicle import UdpVehicle
from tests.support.mavlink_numbers import GUIDED
from tests.support.mavlink_relay import moves

pytest.importorskip("serial", reason="pyserial is not installed")
_CLOSED = -1


class SerialVehicle(UdpVehicle):
    """The same on a serial port, whose path stays the same when it is plugged in again.

    Attributes:
        harm: Changes the bytes on their way to the hub.
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._socket.close()
        self._path = path
        self._ours = self._theirs = _CLOSED
        self.harm: Callable[[bytes], bytes] = bytes
        self.plug()

    @property
    def address(self) -> str:
        return f"serial://{self._path}?baud=57600"

    def plug(self) -> None:
        self._ours, self._theirs = pty.openpty()
        os.set_blocking(self._ours, False)
        self._path.symlink_to(os.ttyname(self._theirs))

    def unplug(self) -> None:
        self._path.unlink()
        os.close(self._ours)
        os.close(self._theirs)
        self._ours = _CLOSED

    def close(self) -> None:
        if self._ours != _CLOSED:
            self.unplug()

    def send(self, name: str, **fields: object) -> None:
        if self._ours != _CLOSED:
            os.write(self._ours, self.harm(self._packer.pack(name, **fields)))

    def answer(self) -> list[MavlinkFrame]:
        came: list[MavlinkFrame] = []
        with contextlib.suppress(OSError):
            while self._ours != _CLOSED:
                came += self._parser.feed(os.read(self._ours, 65536))
        for frame in came:
            self._answer(frame)
        self.received += came
        return came


class Scene:
    """A vehicle that drives; the stick is deflected all the time."""

    def __init__(self, folder: Path) -> None:
        self._now, self._twist = 100.0, Twist()
        self.vehicle = SerialVehicle(folder / "ttyUSB0")
        self.body = MavlinkBody(robot(folder, self.vehicle.address), clock=lambda: self._now)
        self.wait(5.0)
        self.body.arm(armed=True)
        self.wait(2.0)
        self._twist = Twist.planar(0.5, 0.0)
        self.wait(0.5)
        assert self.vehicle.velocities()[-1] == 0.5
        self.vehicle.received.clear()

    def wait(self, seconds: float) -> None:
        for tick in range(round(seconds / TICK_S)):
            if tick % 10 == 0:
                self.vehicle.heartbeat()
            self.vehicle.attitude()
            self.body.command(self._twist)
            self.body.advance(TICK_S)
            self.vehicle.answer()
            self._now += TICK_S

    def release(self) -> None:
        """Release the stick, and deflect it again."""
        deflected, self._twist = self._twist, Twist()
        self.wait(0.2)
        self._twist = deflected
        self.wait(0.2)

    @property
    def phase(self) -> AutopilotPhase:
        return self.body.autopilot(0.0).phase

    @property
    def problems(self) -> str:
        return " ".join(each.message for each in self.body.sensors(0.0).diagnostics)

    def stands(self) -> bool:
        """Whether it got no order and no velocity, and drives once the stick was released."""
        came = [*self.vehicle.received]
        orders = {each["command"] for each in came if each.name == "COMMAND_LONG"}
        self.release()
        drives = self.vehicle.velocities()[-1] == 0.5
        return drives and not (any(map(moves, came)) or orders & {176, 400})


@pytest.fixture
def scene(tmp_path: Path) -> Iterator[Scene]:
    scene = Scene(tmp_path)
    yield scene
    scene.body.close()
    scene.vehicle.close()


def test_nothing_moves_when_a_port_that_vanished_is_back(scene: Scene) -> None:
    for _ in range(3):
        scene.vehicle.unplug()
        scene.wait(3.0)
        assert scene.phase is AutopilotPhase.GONE
        assert "plug it in" in scene.problems
        scene.vehicle.received.clear()
        scene.vehicle.plug()
        scene.wait(6.0)
        assert scene.phase is AutopilotPhase.DRIVING
        assert scene.vehicle.mode == GUIDED
        assert scene.stands()


def test_nothing_moves_after_a_port_was_exchanged_between_two_looks(scene: Scene) -> None:
    scene.vehicle.unplug()
    scene.vehicle.plug()
    scene.wait(1.5)
    scene.vehicle.received.clear()
    scene.wait(6.0)
    assert scene.phase is AutopilotPhase.DRIVING
    assert scene.stands()


def halved(data: bytes, chance: random.Random) -> bytes:
    return data[: chance.randrange(len(data))]


def thinned(data: bytes, chance: random.Random) -> bytes:
    return bytes(each for each in data if chance.random() > 0.2)


def at_another_rate(data: bytes, chance: random.Random) -> bytes:
    """As a receiver at half of the sender's rate sees it: each of its bits spans two."""
    bits = "".join(f"0{each:08b}1" for each in data)[:: 2 + chance.randrange(2)]
    return bytes(int(bits[at : at + 8], 2) for at in range(0, len(bits) - 8, 10))


@pytest.mark.parametrize("harm", [halved, thinned, at_another_rate])
@pytest.mark.parametrize("share", [0.1, 1.0])
def test_lost_bytes_drive_nothing_and_the_next_whole_frame_counts(
    scene: Scene, harm: Callable[[bytes, random.Random], bytes], share: float
) -> None:
    chance = random.Random(3)
    scene.vehicle.harm = lambda data: harm(data, chance) if chance.random() < share else data
    scene.wait(10.0)
    lost = scene.phase is AutopilotPhase.GONE
    assert lost is (share == 1.0)
    scene.vehicle.harm = bytes
    scene.vehicle.received.clear()
    scene.wait(6.0)
    assert scene.phase is AutopilotPhase.DRIVING
    assert scene.stands() is lost, "a link that only loses frames still drives"


def opened(path: str) -> str:
    """Why a port cannot be opened."""
    link = link_to(vehicle_address(path))
    link.read(time.monotonic())
    assert not link.state.up
    return link.state.why


def test_what_is_no_serial_port_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "file", tmp_path / "pipe", tmp_path, "/dev/null"):
        assert opened(str(path)) == "it is no serial port; correct the address"


def test_a_port_that_vanishes_while_it_is_opened_is_opened_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def gone(*_: object) -> None:
        raise termios.error(5, "Input/output error")

    ours, theirs = pty.openpty()
    with monkeypatch.context() as patch:
        patch.setattr(termios, "tcsetattr", gone)
        assert opened(os.ttyname(theirs)) == "it was unplugged"
    os.close(ours)
    os.close(theirs)
