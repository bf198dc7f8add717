"""The link shaper: what it adds to a link, what it costs, and what its profiles do to driving.

Overhead and cost: the relay in a process of its own, between plain TCP sockets. Driving: a real
hub; a client behind the link turns the robot 20 times a second, and its states come back.
"""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import socket
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import psutil

from benchmarks.figures import report, say
from hub.gcm import navigation
from hub.gcm.geometry import TwistStamped
from hub.ipc.client import Client
from hub.shaper.profile import load_profile
from hub.shaper.relay import Relay
from hub.shaper.shaped_link import ShapedLink
from tests.support.ports import free_port
from tests.system.harness import HubProcess

ADDRESS = "127.0.0.88"
TRIPS, CARRY_S, DRIVE_S = 500, 10.0, 30.0
DRIVEN = ("lan", "wifi-good", "wifi-edge", "threshold", "rubble")
BAR_OVERHEAD_MS, BAR_PROCESSOR_PERCENT = 2.0, 10.0
_READY = {navigation.MotionState.STANDING, navigation.MotionState.MOVING}


def _relay(port: int, profile: str, listening: threading.Event) -> None:
    relay = Relay(ADDRESS, [("127.0.0.1", port)], load_profile(profile), 1)
    listening.set()
    relay.run(lambda: False)


@contextmanager
def carried(profile: str) -> Iterator[tuple[socket.socket, socket.socket, psutil.Process]]:
    """Both ends of a connection through a relay, and the relay's process."""
    context = multiprocessing.get_context("spawn")
    with ExitStack() as stack:
        server = stack.enter_context(socket.create_server(("127.0.0.1", free_port())))
        port, listening = server.getsockname()[1], context.Event()
        process = context.Process(target=_relay, args=(port, profile, listening), daemon=True)
        process.start()
        stack.callback(process.kill)
        listening.wait()
        near = stack.enter_context(socket.create_connection((ADDRESS, port)))
        far = stack.enter_context(server.accept()[0])
        for each in (near, far):
            each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        yield near, far, psutil.Process(process.pid)


def echo(one: socket.socket) -> None:
    while data := one.recv(65_536):
        one.sendall(data)


def report_overhead() -> None:
    """What the relay adds to the round trip of profile lan."""
    say("round trips through the relay")
    with carried("lan") as (near, far, _):
        threading.Thread(target=echo, args=(far,), daemon=True).start()
        trips = []
        for _ in range(TRIPS):
            began = time.perf_counter()
            near.sendall(bytes(32))
            near.recv(32)
            trips.append(time.perf_counter() - began)
            time.sleep(0.002)
        near.shutdown(socket.SHUT_WR)
    added = sorted(1e3 * (each - load_profile("lan").round_trip) for each in trips)
    note = "32 bytes there and back over lan, less its 1 ms; with the echo's own time"
    median = statistics.median(added)
    report("shaper.overhead_ms", median, "ms", bar=BAR_OVERHEAD_MS, note=note)
    report("shaper.overhead_p95_ms", added[int(0.95 * TRIPS)], "ms", note=note)


def report_cost() -> None:
    """The processor time of the relay while it carries 5 Mbit/s in packets."""
    say("5 Mbit/s through the relay")
    with carried("wifi-good") as (near, far, process):
        ended = threading.Event()

        def send() -> None:
            with contextlib.suppress(OSError):  # the end closes the socket
                while not ended.is_set():
                    far.sendall(bytes(6250))  # waits while the link is full

        sender = threading.Thread(target=send, daemon=True)
        sender.start()
        near.recv(65_536)
        before, began, count = sum(process.cpu_times()[:2]), time.monotonic(), 0
        while time.monotonic() < began + CARRY_S:
            count += len(near.recv(65_536))
        took = time.monotonic() - began
        used = sum(process.cpu_times()[:2]) - before
        ended.set()
    report("shaper.carried_mbit_s", 8e-6 * count / took, "Mbit/s", better="higher")
    percent, note = 100.0 * used / took, "of one core, by its processor time"
    report("shaper.processor_percent", percent, "%", bar=BAR_PROCESSOR_PERCENT, note=note)


def report_driving(profile: str) -> None:
    """How much of the time a robot turns whose operator turns it without a pause."""
    say(f"driving over {profile}")
    turned: list[bool] = []
    ages: list[float] = []
    motions = [navigation.MotionState.WAITING]

    def came(state: navigation.RobotState, age: float) -> None:
        motions.append(state.motion)
        ages.append(age)

    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        running = stack.enter_context(closing(HubProcess(Path(folder), options=("--listen", "0"))))
        link = stack.enter_context(ShapedLink(running.endpoint, profile, 7))
        far = stack.enter_context(closing(Client("operator", link.endpoint)))
        near = stack.enter_context(closing(Client("wheels", running.endpoint)))
        near.subscribe(
            navigation.DRIVE_STATE, lambda state, _: turned.append(state.commanded.angular.z > 0.0)
        )
        far.subscribe(navigation.ROBOT_STATE, lambda state, how: came(state, how.age))

        def drive() -> None:
            turn = 0.4 if motions[-1] in _READY else 0.0
            command = TwistStamped.planar(0.0, turn)
            far.publish(navigation.VELOCITY_COMMAND, command, measured=time.monotonic())

        far.wait_connected(20.0)
        far.every(0.05, drive)
        end = time.monotonic() + DRIVE_S
        while time.monotonic() < end:
            far.listen(0.005)
            near.listen(0.005)
    turned = turned[len(turned) // 5 :]  # without the begin
    note = "seed 7; commands 20 times a second, and a neutral one after each stop"
    name = profile.replace("-", "_")
    report(
        f"shaper.{name}_moving_percent",
        100.0 * statistics.fmean(turned),
        "%",
        better="higher",
        note=note,
    )
    report(f"shaper.{name}_state_age_median_ms", 1e3 * statistics.median(ages), "ms")
    report(f"shaper.{name}_state_age_max_ms", 1e3 * max(ages), "ms")


FIGURES: dict[str, Callable[[], None]] = {
    "overhead": report_overhead,
    "cost": report_cost,
    **{name: functools.partial(report_driving, name) for name in DRIVEN},
}


def main() -> None:
    """All figures, or those that are named."""
    for name in sys.argv[1:] or FIGURES:
        FIGURES[name]()


if __name__ == "__main__":
    main()
