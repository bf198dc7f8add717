"""Fleets: hub to hub beside raw Zenoh, a thin line, a lost router, many robots and consoles.

A robot is a hub without modules that publishes states and pictures, with its real gateway; `fleet
mirror` and the routers are the real programs. Run alone: `python -m benchmarks.fleet [PART...]`.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import psutil

from benchmarks.figures import report, say
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.transport.loop import Loop
from hub.values import dataclass
from hub.zenoh.settings import client_settings, parse_place
from tests.support.ports import free_port

_HEAD = struct.Struct("<QQ")
_SMALL, _STATE, _PICTURE = 48, 700, 57_600
_THIN_B_S = 200_000
_ROBOTS, _CONSOLES = 20, 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Bytes.

    Attributes:
        length: Their number.
        data: They.
    """

    length: int
    data: npt.NDArray[np.uint8]


def block(size: int) -> MessageDefinition[Block]:
    """A message of this size [bytes]."""
    return MessageDefinition(
        name=f"Trial_{size}",
        format="{int,<ubyte:1>}",
        type=Block,
        keep=Keep.ALL if size == _SMALL else Keep.NEWEST,
        plane=Plane.PICTURE if size == _PICTURE else Plane.STATE,
    )


def median(values: list[float]) -> float | None:
    """The median; None where there are none."""
    return statistics.median(values) if values else None


# The programs beside this one


@contextlib.contextmanager
def program(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A program that has said its first line, until the end of the context."""
    process = subprocess.Popen(
        [sys.executable, "-m", *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        if not next_line(process):
            text = f"{' '.join(words)} ended"
            raise SystemExit(text)
        yield process
    finally:
        if process.stdin is not None:
            process.stdin.close()
        try:
            process.wait(3.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def next_line(process: subprocess.Popen[bytes]) -> bytes:
    """The next line of a program; empty: it has ended."""
    return b"" if process.stdout is None else process.stdout.readline()


@contextlib.contextmanager
def router(port: int) -> Iterator[str]:
    """A router; its place."""
    place = f"tcp/127.0.0.1:{port}"
    with program("hub", "fleet", "router", "--listen", place) as process:
        yield place
        process.kill()


@contextlib.contextmanager
def mirror(place: str, folder: Path, *robots: str) -> Iterator[subprocess.Popen[bytes]]:
    """A console's mirror, which shows these robots."""
    named = [word for robot in robots for word in ("--robot", robot)]
    words = ["hub", "fleet", "mirror", "--connect", place, "--folder", str(folder), "--json"]
    with program(*words, "--stop-with-stdin", "--as", "operate:ann", *named) as process:
        yield process


def robot(name: str, place: str, sizes: list[int], rates: list[float]) -> None:
    """A hub with its gateway that publishes, and says at its end how old commands were."""
    from hub.doors.fleet.gateway import FleetGateway
    from hub.robots.fleet_table import FleetTable

    with tempfile.TemporaryDirectory(prefix="rune-bench-") as folder:
        endpoint = f"ipc://{folder}/hub"
        central = Central([endpoint])
        gate = Client("fleet", endpoint)
        source = Client("source", endpoint, loop=gate.loop)
        ages: list[float] = []
        source.subscribe(VELOCITY_COMMAND, lambda _, info: ages.append(info.age))
        for size, rate in zip(sizes, rates, strict=True):
            source.every(1.0 / rate, publishing(source, size))
        gateway = FleetGateway(gate, name, FleetTable(place=parse_place(place)))
        put({"ready": name})
        ended = threading.Event()
        signal.signal(signal.SIGTERM, lambda *_: ended.set())
        threading.Thread(target=lambda: (sys.stdin.read(), ended.set()), daemon=True).start()
        while not ended.is_set():
            gate.listen(0.2)
        put({"commands": len(ages), "age": median(ages), "cpu": time.process_time()})
        gateway.finish()
        for each in (source, gate):
            each.close()
        central.close()


def publishing(client: Client, size: int) -> Callable[[], None]:
    """Publishes numbered blocks with the time of their making."""
    definition, data = block(size), np.zeros(size, np.uint8)
    client.define(definition)
    count = 0

    def publish() -> None:
        nonlocal count
        count += 1
        _HEAD.pack_into(data, 0, count, time.monotonic_ns())
        client.publish(definition, Block(length=size, data=data))

    return publish


def thin(listen: int, target: int, rate: float) -> None:
    """A relay: all connections share one rate of bytes each way."""
    server = socket.create_server(("127.0.0.1", listen))
    locks = threading.Lock(), threading.Lock()
    free = [0.0, 0.0]
    ended = threading.Event()  # never set: the process is killed

    def pump(source: socket.socket, sink: socket.socket, way: int) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(1400):
                with locks[way]:
                    now = time.monotonic()
                    free[way] = max(now, free[way]) + len(data) / rate
                    wait = free[way] - now
                ended.wait(wait)
                sink.sendall(data)
        for each in (source, sink):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)

    put({"ready": listen})
    while True:
        near, _ = server.accept()
        far = socket.socket()
        for each in (near, far):
            each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            each.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16384)
        far.connect(("127.0.0.1", target))
        for way, (source, sink) in enumerate(((near, far), (far, near))):
            threading.Thread(target=pump, args=(source, sink, way), daemon=True).start()


def raw(place: str, size: int, rate: float) -> None:
    """A publisher of Zenoh alone."""
    from hub.zenoh.fleet_session import FleetWay, open_fleet_session

    where = parse_place(place)
    session = open_fleet_session(where, client_settings(where))
    put({"ready": size})
    way = FleetWay.BULK if size == _PICTURE else FleetWay.STATE
    loop, count = Loop(), 0

    def publish() -> None:
        nonlocal count
        count += 1
        data = _HEAD.pack(count, time.monotonic_ns()) + bytes(size - _HEAD.size)
        session.put(f"raw/{size}", data, None, way)

    loop.every(1.0 / rate, publish)
    while count < 6 * rate:
        loop.listen(1.0 / rate)
    loop.close()
    session.close()


def put(said: dict[str, Any]) -> None:
    """Say it to the program that started this one."""
    sys.stdout.write(json.dumps(said) + "\n")
    sys.stdout.flush()


# What this one measures


class Reader:
    """A console's client at a robot's mirror: ages of its messages, by size [ms]."""

    def __init__(self, folder: Path, name: str, *sizes: int, loop: Loop | None = None) -> None:
        """Connect, and subscribe; the loop serves several."""
        self.ages: dict[int, list[float]] = {size: [] for size in sizes}
        self.last = 0.0
        endpoint = f"ipc://{folder / name / 'hub'}"
        self.client = Client(
            f"rune-bench-{os.getpid()}-{id(self)}", endpoint, near=False, loop=loop
        )
        self.client.wait_connected(20.0)
        for size in sizes:
            self.client.subscribe(block(size), lambda value, _, size=size: self._came(value, size))

    def _came(self, value: Block, size: int) -> None:
        _, sent = _HEAD.unpack_from(value.data)
        self.last = time.monotonic()
        self.ages[size].append((time.monotonic_ns() - sent) * 1e-6)

    def listen(self, seconds: float) -> None:
        """Serve."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.client.listen(0.05)

    def until(self, condition: Callable[[], object], seconds: float) -> bool:
        """Serve until a condition holds; whether it did."""
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                return False
            self.client.listen(0.01)
        return True


def robot_program(name: str, place: str, **sizes: float) -> contextlib.AbstractContextManager[Any]:
    """A robot in a process of its own; `sizes` are rates by "s" and the size."""
    pairs = [f"{size[1:]}@{rate}" for size, rate in sizes.items()]
    return program("benchmarks.fleet", "as-robot", name, place, *pairs)


def hub_to_hub(folder: Path) -> None:
    """One robot and one console, at one router."""
    for name, size, rate, bar in (
        ("fleet.small_ms", _SMALL, 50.0, 2.0),
        ("fleet.picture_ms", _PICTURE, 30.0, 3.0),
    ):
        with router(free_port()) as place:
            with robot_program("a", place, **{f"s{size}": rate}), mirror(place, folder, "a"):
                reader = Reader(folder, "a", size)
                reader.listen(8.0)
                ages = reader.ages[size][int(rate) :]
                reader.client.close()
            alone = _raw(place, size, rate)
        note = f"{len(ages)} of {7 * rate:g}; {load()}"
        peers = {"raw Zenoh": round(alone, 3)} if alone is not None else {}
        report(name, median(ages), "ms", bar=bar, peers=peers, note=note)


def _raw(place: str, size: int, rate: float) -> float | None:
    from hub.zenoh.fleet_session import open_fleet_session

    ages: list[float] = []
    where = parse_place(place)
    session = open_fleet_session(where, client_settings(where))
    session.subscribe(
        f"raw/{size}",
        lambda sample: ages.append(
            (time.monotonic_ns() - _HEAD.unpack_from(sample.payload)[1]) * 1e-6
        ),
    )
    with program("benchmarks.fleet", "as-raw", place, str(size), str(rate)) as process:
        process.wait(20.0)
    session.close()
    return median(ages[int(rate) :])


def thin_line(folder: Path) -> None:
    """The robot behind 200 kB/s, pictures of 576 kB/s beside states and commands."""
    port = free_port()
    with (
        router(port) as place,
        contextlib.nullcontext(free_port()) as near,
        program("benchmarks.fleet", "as-thin", str(near), str(port), str(_THIN_B_S)),
        robot_program(
            "a", f"tcp/127.0.0.1:{near}", **{f"s{_STATE}": 50.0, f"s{_PICTURE}": 10.0}
        ) as process,
        mirror(place, folder, "a"),
    ):
        reader = Reader(folder, "a", _STATE, _PICTURE)
        commands = reader.client.every(
            0.05, lambda: reader.client.publish(VELOCITY_COMMAND, TwistStamped())
        )
        reader.listen(14.0)
        commands.cancel()
        reader.client.close()
        process.send_signal(signal.SIGTERM)
        said = json.loads(next_line(process))
    states, pictures = reader.ages[_STATE][100:], reader.ages[_PICTURE]
    note = f"{len(states)} of 600 arrived, pictures {len(pictures) / 14.0:.1f}/s; {load()}"
    report("fleet.state_thin_ms", median(states), "ms", bar=50.0, note=note)
    age = said["age"]
    note = f"{said['commands']} arrived, by the robot's hub's clock; {load()}"
    report("fleet.command_thin_ms", age and age * 1e3, "ms", bar=10.0, note=note)
    note = "median age of pictures of 57.6 kB that arrived"
    report("fleet.picture_thin_ms", median(pictures), "ms", note=note)


def many(folder: Path) -> None:
    """Half of the robots and then all, with one console and then three, over two routers."""
    for robots, consoles in ((_ROBOTS // 2, 1), (_ROBOTS, 1), (_ROBOTS, _CONSOLES)):
        with contextlib.ExitStack() as stack:
            place = stack.enter_context(router(free_port()))
            second = free_port()
            far = f"tcp/127.0.0.1:{second}"
            joined = ["--listen", far, "--connect", place]
            stack.enter_context(program("hub", "fleet", "router", *joined))
            names = [f"r{number}" for number in range(robots)]
            started = [
                stack.enter_context(robot_program(name, far, **{f"s{_STATE}": 10.0}))
                for name in names
            ]
            mirrors = [
                stack.enter_context(mirror(place, _made(folder / f"c{number}")))
                for number in range(consoles)
            ]
            loop = Loop()
            stack.callback(loop.close)
            readers = [
                Reader(folder / f"c{number}", name, _STATE, loop=loop)
                for number in range(consoles)
                for name in names
            ]
            for reader in readers:
                reader.listen(0.1)
            before = [cpu(each) for each in (*started, *mirrors)]
            began = time.monotonic()
            while time.monotonic() - began < 5.0:
                loop.listen(0.05)
            passed = time.monotonic() - began
            after = [cpu(each) for each in (*started, *mirrors)]
            used = [100.0 * (b - a) / passed for a, b in zip(before, after, strict=True)]
            for reader in readers:
                reader.client.close()
            fresh = sum(1 for reader in readers if reader.ages[_STATE])
        note = f"{fresh} of {len(readers)} views had states; {load()}"
        what = f"fleet.{{}}_cpu_percent_{robots}_robots_{consoles}_consoles"
        report(what.format("robot"), statistics.mean(used[:robots]), "%", note=f"each; {note}")
        report(what.format("mirror"), statistics.mean(used[robots:]), "%", note=f"each; {note}")


def cpu(process: subprocess.Popen[bytes]) -> float:
    """Processor time of a program so far [s]."""
    times = psutil.Process(process.pid).cpu_times()
    return float(times.user + times.system)


def lost_router(folder: Path) -> None:
    """The router is killed and there again: how long until states come again."""
    port = free_port()
    place = f"tcp/127.0.0.1:{port}"
    with contextlib.ExitStack() as stack:
        first = stack.enter_context(program("hub", "fleet", "router", "--listen", place))
        stack.enter_context(robot_program("a", place, **{f"s{_STATE}": 50.0}))
        stack.enter_context(mirror(place, folder, "a"))
        reader = Reader(folder, "a", _STATE)
        reader.until(lambda: reader.last, 10.0)
        first.kill()
        first.wait()
        reader.listen(1.0)
        stack.enter_context(program("hub", "fleet", "router", "--listen", place))
        back = time.monotonic()
        came = reader.until(lambda: reader.last > back, 10.0)
        took = time.monotonic() - back if came else None
        reader.client.close()
    note = f"from the router's return to the first state at a console; {load()}"
    report("fleet.router_back_s", took, "s", bar=2.0, note=note)


def load() -> str:
    """How busy the machine is."""
    return f"load {os.getloadavg()[0]:.1f}"


def _made(folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    return folder


PARTS = {"hub_to_hub": hub_to_hub, "thin": thin_line, "router": lost_router, "many": many}


def main(words: list[str]) -> None:
    """Be one of the programs, or measure."""
    role, *rest = words or [""]
    if role == "as-robot":
        pairs = [pair.split("@") for pair in rest[2:]]
        robot(
            rest[0], rest[1], [int(size) for size, _ in pairs], [float(rate) for _, rate in pairs]
        )
    elif role == "as-thin":
        thin(int(rest[0]), int(rest[1]), float(rest[2]))
    elif role == "as-raw":
        raw(rest[0], int(rest[1]), float(rest[2]))
    else:
        for name in words or PARTS:
            say(name)
            with tempfile.TemporaryDirectory(prefix="rune-bench-") as folder:
                PARTS[name](Path(folder))


if __name__ == "__main__":
    main(sys.argv[1:])
