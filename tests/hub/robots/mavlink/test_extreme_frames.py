"""Any frames through the body and the driver: what is published is valid, and nothing is driven."""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from hub.gcm.catalog import BY_NAME
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import DRIVE_COMMAND
from hub.modules.driver import __main__ as driver
from hub.robots.mavlink import body
from hub.robots.mavlink.body import MavlinkBody
from hub.robots.mavlink.link.byte_link import ByteLink
from hub.robots.mavlink.link.vehicle_claim import VehicleClaim
from hub.robots.mavlink.wire import definitions
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from hub.robots.robot_file import read_description
from tests.hub.modules.timed_bus import TimedBus
from tests.hub.robots.mavlink.robot_parts import PARTS
from tests.misbehaving.hostile_vehicle import ATTACKS
from tests.support.mavlink_relay import moves

QUICK, SOAK = 2_000, 100_000
AT_ONCE = 40
"""Frames between two looks of the driver."""
ROBOT = """
name = "vehicle"
kind = "mavlink"
[mavlink]
address = "udp://127.0.0.1:9"
[body]
arming = "disarmed"
[limits]
linear = 1.0
[[range]]
name = "around"
kind = "laser"
beams = 72
spread_deg = 360
farthest = 1000.0
"""
DRIVING = {10: 15, 12: 16, 7: 2, 2: 4}
"""Types of vehicles, and a mode that follows velocities of each."""


class HostileLink(ByteLink):
    """A link on which a test puts bytes.

    Attributes:
        came: Bytes that wait.
        sent: The frames of the driver.
    """

    def __init__(self) -> None:
        super().__init__()
        self.came: list[bytes] = []
        self.sent: list[MavlinkFrame] = []
        self._parser = FrameParser()

    def _open(self) -> None: ...

    def _receive(self) -> bytes:
        if not self.came:
            raise BlockingIOError
        return self.came.pop(0)

    def _send(self, data: bytes) -> int:
        self.sent += self._parser.feed(data)
        return len(data)

    def _file(self) -> int:
        return 0

    def _shut(self) -> None: ...


class Scene:
    """A driver of a vehicle that says it is armed, in a mode that follows velocities."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path, kind: int) -> None:
        path = folder / "robot.toml"
        path.write_text(ROBOT + PARTS)
        robot, problems = read_description(path)
        assert not problems
        self.kind, self.link = kind, HostileLink()
        self.bus = TimedBus(monkeypatch)
        self.bus.watched = True
        monkeypatch.setattr(body, "link_to", lambda _: self.link)
        monkeypatch.setattr(VehicleClaim, "take", lambda _: True)  # others test at this address
        self.body = MavlinkBody(robot, clock=lambda: self.bus.now)
        made = SimpleNamespace(open_body=lambda _: self.body)
        monkeypatch.setattr(driver, "kind_of", lambda _: made)
        driver.build(self.bus, robot)  # type: ignore[arg-type]
        self._packer = FramePacker(1, 1)
        self._beat_at = 0.0
        self._answered = 0
        self.faults: set[str] = set()

    def step(self, frames: Iterator[bytes]) -> None:
        """One look of the driver at the next frames, while the stick is deflected."""
        self.link.came = [b"".join((*self._honest(), *frames))]
        stick = Twist() if self.bus.now % 1.0 < 0.1 else Twist.planar(0.5, 0.2)
        self.bus.send(DRIVE_COMMAND, TwistStamped.of(stick), "navigation")
        self.bus.wait(0.05)
        for _, name, value in self.bus.published:
            definition = BY_NAME[name]
            try:
                definition.decode(b"".join(definition.encode(value)), self.faults.add)
            except ValueError as fault:
                self.faults.add(str(fault))
        self.bus.published.clear()

    def _honest(self) -> Iterator[bytes]:
        if self.bus.now >= self._beat_at:
            self._beat_at = self.bus.now + 0.5
            mode = {"base_mode": 129, "custom_mode": DRIVING[self.kind], "system_status": 4}
            yield self._packer.pack("HEARTBEAT", type=self.kind, autopilot=3, **mode)
        for frame in self.link.sent[self._answered :]:
            if frame.name == "TIMESYNC":
                yield self._packer.pack("TIMESYNC", tc1=1, ts1=frame["ts1"])
        self._answered = len(self.link.sent)


def extreme(code: str, chance: random.Random) -> float | int:
    """A number at an edge of its type, or a usual one."""
    if code in "fd":
        edges = (0.0, -0.0, 1.0, -1.0, 0.3, 3.2, -6.3, 99.0, 1e6, -1e7, 3e38, -3e38, 1e-45)
        return chance.choice((*edges, float("nan"), float("inf"), float("-inf")))
    bits = 8 * struct.calcsize(code)
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if code.islower() else (0, (1 << bits) - 1)
    return chance.choice((0, 1, low, high, high // 2, chance.randint(0, min(high, 200))))


def mixed(chance: random.Random) -> Iterator[bytes]:
    """Every message that is read, each field usual or at an edge."""
    packer = FramePacker(1, 1)
    forms = [each for each in definitions.BY_NAME.values() if each.fields]
    forms = [each for each in forms if each.name not in ("HEARTBEAT", "TIMESYNC")]
    while True:
        form = chance.choice(forms)
        codes = re.findall(r"[a-zA-Z]", form.wire.format)
        values: dict[str, object] = {}
        for field, code in zip(form.fields, codes, strict=True):
            if field.text:
                texts = ("", "a", "\x1b]0;x\x07" * 9, "Leak", "PreArm: x", "PilotGain", "Lights1")
                values[field.name] = chance.choice(texts)
            elif field.count:
                values[field.name] = tuple(extreme(code, chance) for _ in range(field.count))
            else:
                values[field.name] = extreme(code, chance)
        yield packer.pack(form.name, **values)


SOURCES = {**{name: ATTACKS[name] for name in ("numbers", "mutated")}, "mixed": mixed}


@pytest.mark.parametrize("kind", DRIVING)
@pytest.mark.parametrize(
    ("source", "count"),
    [
        ("mixed", QUICK),
        *(pytest.param(name, SOAK, marks=pytest.mark.soak) for name in SOURCES),
    ],
)
def test_all_that_is_published_is_valid_and_nothing_is_driven(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kind: int, source: str, count: int
) -> None:
    scene = Scene(monkeypatch, tmp_path, kind)
    frames = SOURCES[source](random.Random(20))
    for _ in range(count // AT_ONCE):
        scene.step(next(frames) for _ in range(AT_ONCE))
    scene.step(iter(()))
    assert scene.faults == set()
    assert not [each for each in scene.link.sent if moves(each)]
    orders = {each["command"] for each in scene.link.sent if each.name == "COMMAND_LONG"}
    assert not orders & {176, 400}
