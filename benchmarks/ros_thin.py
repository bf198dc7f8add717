"""How old topics of a robot with ROS are on a thin line, and what they cost the driver.

The robot is `rune-hub sim-ros`. Its clock is this machine's, so the times in headers tell the true
ages. On the thin line the driver and the camera have a connection each, as in a hub; the peer has
both topics on one.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

import psutil

from benchmarks.figures import report, say
from hub.errors import CameraError
from hub.robots.ros.address import ros_address
from hub.robots.ros.line import RosLine, RosMessage
from hub.robots.ros.line_loop import LineLoop
from hub.robots.ros.opening import line_to
from hub.robots.ros.picture_feed import PictureFeed
from hub.ros.decoding import RosDecoder
from tests.support.ros_robot import SimulatedRos
from tests.support.thin_link import ThinLink
from tests.system.driven_ros import ros_tables
from tests.system.harness import HubProcess

_ODOMETRY = "/odom"
_PICTURES = "/camera/image_raw"
_RATE = 200_000 * 8
"""Of the thin line, each way [bit/s]."""
_QUEUES = {"ros_odom_thin": 4_000, "ros_odom_deep_queue": 16_000}
"""Bytes that wait in the thin line itself, for each figure: 20 and 80 ms of it."""
_DELAY_S = 0.002
_SECONDS = 15.0
_FIRST_S = 2.0
"""Time for the connection and its definitions, which does not count [s]."""


class Reader:
    """True ages of the messages of a line, by topic [ms]."""

    def __init__(self, line: RosLine, *topics: str) -> None:
        self.ages: dict[str, list[float]] = {each: [] for each in topics}
        self._loop = LineLoop(line)
        for each in topics:
            line.subscribe(each, self._take)

    def read(self, seconds: float, meanwhile: Callable[[], object] = lambda: None) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._loop.advance()
            meanwhile()
            self._loop.wait(0.01)

    def forget(self) -> None:
        for each in self.ages.values():
            each.clear()

    def close(self) -> None:
        self._loop.close()

    def _take(self, message: RosMessage) -> None:
        stamp = RosDecoder.of(message.topic).decode(message.payload).get("header.stamp")
        age = time.time() - int(stamp.get("sec")) - int(stamp.get("nanosec")) * 1e-9
        self.ages[message.topic.name].append(age * 1e3)


def summary(ages: list[float]) -> str:
    """Count, p99, the largest and the last."""
    sorted_ages = sorted(ages)
    p99 = sorted_ages[int(len(ages) * 0.99)]
    return f"{len(ages)} came, p99 {p99:.1f}, largest {sorted_ages[-1]:.1f}, last {ages[-1]:.1f} ms"


def thin(robot: SimulatedRos) -> None:
    """Measure ages of odometry and pictures together on a thin line."""
    one = together(robot)
    peers = {"one connection": statistics.median(one), "one connection, at the end": one[-1]}
    for name, room in _QUEUES.items():
        ages, pictures = apart(robot, room)
        queue_ms = room / _RATE * 8e3
        queue = f"a queue of {queue_ms:.0f} ms in the line"
        note = f"200 kB/s, pictures of 576 kB/s; {queue}; {summary(ages)}"
        bar = 50.0 if name == "ros_odom_thin" else None
        report(name, statistics.median(ages), "ms", bar=bar, peers=peers, note=note)
        if bar is not None:
            note = f"{len(pictures) / _SECONDS:.1f} pictures/s, the oldest {max(pictures):.1f} s"
            report("ros_image_thin", statistics.median(pictures), "s", bar=1.0, note=note)


def apart(robot: SimulatedRos, room: int) -> tuple[list[float], list[float]]:
    """Ages of odometry [ms] and pictures [s], a connection each, as driver and camera have."""
    pictures: dict[float, float] = {}
    with ExitStack() as stack:
        address = ros_address(thin_link(robot, room, stack))
        feed = stack.enter_context(closing(PictureFeed(line_to(address), _PICTURES, "")))
        reader = stack.enter_context(closing(Reader(line_to(address), _ODOMETRY)))

        def look() -> None:
            now = time.monotonic()
            try:
                picture = feed.newest(now)
            except CameraError:
                return
            pictures.setdefault(picture.measured, now - picture.measured)

        reader.read(_FIRST_S, look)
        reader.forget()
        pictures.clear()
        reader.read(_SECONDS, look)
        return reader.ages[_ODOMETRY], list(pictures.values())


def together(robot: SimulatedRos) -> list[float]:
    """The odometry's ages where one connection has the pictures too [ms]."""
    with ExitStack() as stack:
        address = ros_address(thin_link(robot, _QUEUES["ros_odom_thin"], stack))
        line = line_to(address)
        reader = stack.enter_context(closing(Reader(line, _ODOMETRY, _PICTURES)))
        reader.read(_FIRST_S + _SECONDS)
        return reader.ages[_ODOMETRY]


def thin_link(robot: SimulatedRos, room: int, stack: ExitStack) -> str:
    """The robot's address at the near end of a thin line."""
    place = f"tcp://127.0.0.1:{robot.port}"
    link = ThinLink(place, rate=_RATE, delay=_DELAY_S, room=room, ports=1)
    return stack.enter_context(closing(link)).endpoint.replace("tcp:", "ws:")


def cost(folder: Path, robot: SimulatedRos) -> None:
    """Measure the driver's share of a core while it reads odometry, scans and diagnostics."""
    tables = ros_tables(robot.port)
    with closing(HubProcess(folder, kind="ros", modules=("driver",), tables=tables)) as hub:
        driver = psutil.Process(hub.pids["driver"])
        driver.cpu_percent(_FIRST_S)  # its start does not count
        share = driver.cpu_percent(_SECONDS)
        note = "odometry 50 Hz, scans of 360 beams 10 Hz"
        report("ros_driver_cpu", share, "% of a core", bar=5.0, note=note)


def main() -> None:
    """Measure all."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        with closing(SimulatedRos(folder)) as robot:
            say("the thin line takes half a minute")
            thin(robot)
            cost(folder, robot)


if __name__ == "__main__":
    main()
