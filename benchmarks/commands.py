"""What it costs that the gateway looks at each command, and that a client floods it.

One client with a key publishes a state and a command in turn, 50 of each a second. States pass the
gateway in ZeroMQ's own proxy, commands in a thread of Python. Ages are measured where they arrive.
Then another key sends commands under a number that is not its own, as fast as it can.
"""

from __future__ import annotations

import multiprocessing
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import zmq

from benchmarks.figures import report, say
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.keyring import Keyring
from hub.ipc.wire import frames
from tests.support.ports import free_port

HZ, SECONDS = 50.0, 10.0
_PROCESSES = multiprocessing.get_context("spawn")


@dataclass(frozen=True, slots=True, kw_only=True)
class Tick:
    count: int


STATE = MessageDefinition(name="BENCH_State", format="{int}", type=Tick, keep=Keep.ALL)
COMMAND = MessageDefinition(
    name="BENCH_Command", format="{int}", type=Tick, keep=Keep.ALL, plane=Plane.COMMAND
)


def serve(folder: str, pipe: Connection) -> None:
    """Be a hub with a gateway until the other end closes."""
    port = free_port()
    gateway = curve_gateway(f"tcp://127.0.0.1:{port}", Keyring(Path(folder, "keys")))
    central = Central([f"ipc://{folder}/central"], gateways=[gateway])
    with closing(central):
        pipe.send((*central.endpoints, port + 3))
        _until_closed(pipe)
        say(f"dropped: {dict(central.faults.counts)}")


def publish(endpoint: str, keys: str, pipe: Connection) -> None:
    """Publish a state and a command in turn until the other end closes."""
    with closing(Client("far", endpoint, keys=read_client_keys(Path(keys)))) as client:
        client.wait_connected(10.0)
        client.define(STATE, COMMAND)
        count = 0

        def tick() -> None:
            nonlocal count
            count += 1
            client.publish(STATE if count % 2 else COMMAND, Tick(count=count))

        client.every(0.5 / HZ, tick)
        while not pipe.poll(0):
            client.listen(0.1)


def flood(port: int, keys: str, pipe: Connection) -> None:
    """Send commands under a number that belongs to no client until the other end closes."""
    context: Any = zmq.Context()
    socket = context.socket(zmq.PUB)
    socket.linger = 0
    read_client_keys(Path(keys)).apply(socket)
    socket.connect(f"tcp://127.0.0.1:{port}")
    frame = frames.pack(
        frames.prefix(COMMAND.name, frames.FAR),
        publisher=7,
        fingerprint=COMMAND.fingerprint,
        sequence=1,
        stamp_ns=0,
        payload=COMMAND.encode(Tick(count=0)),
    )
    while not pipe.poll(0):
        for _ in range(500):
            socket.send(frame)
    socket.close()
    context.term()


def _until_closed(pipe: Connection) -> None:
    while not pipe.poll(0.2):
        pass


@contextmanager
def process(work: Any, *arguments: Any) -> Iterator[Connection]:
    ours, theirs = _PROCESSES.Pipe()
    made = _PROCESSES.Process(target=work, args=(*arguments, theirs), daemon=True)
    made.start()
    try:
        yield ours
    finally:
        ours.send("end")
        made.join(10.0)


def ages(endpoint: str, seconds: float) -> dict[str, list[float]]:
    """Ages of what arrives at a module of the robot, by message [ms]."""
    found: dict[str, list[float]] = {STATE.name: [], COMMAND.name: []}
    with closing(Client("module", endpoint)) as client:
        client.wait_connected(10.0)
        for each in (STATE, COMMAND):
            ages_of = found[each.name]
            client.subscribe(each, lambda _, how, ages_of=ages_of: ages_of.append(how.age * 1e3))
        while not all(found.values()):
            client.listen(0.1)
        for measured in found.values():
            measured.clear()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            client.listen(0.1)
    return found


def p99(values: list[float]) -> float:
    return sorted(values)[int(0.99 * len(values))]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, process(serve, folder) as hub:
        local, gateway, port = hub.recv()
        ring = Keyring(Path(folder, "keys"))
        keys = {role: str(ring.make(f"a-{role.value}", role)) for role in Role}
        with process(publish, gateway, keys[Role.MODULE]):
            say(f"{SECONDS:.0f} s in the calm, then {SECONDS:.0f} s of flood")
            calm = ages(local, SECONDS)
            with process(flood, port, keys[Role.OPERATE]):
                flooded = ages(local, SECONDS)
    states, commands = calm[STATE.name], calm[COMMAND.name]
    middle = statistics.median(commands)
    proxy = {"state through ZeroMQ's proxy": round(statistics.median(states), 4)}
    report("commands.gateway_p50", middle, "ms", peers=proxy)
    report("commands.gateway_p99", p99(commands), "ms")
    added = middle - statistics.median(states)
    report("commands.door_adds_p50", added, "ms", bar=0.3, note="command less state, same client")
    worst = flooded[COMMAND.name]
    report("commands.flooded_p50", statistics.median(worst), "ms")
    report("commands.flooded_p99", p99(worst), "ms", bar=50.0)
    part = len(worst) / (HZ * SECONDS)
    report("commands.flooded_arrived", part, "of all", bar=0.95, better="higher")


if __name__ == "__main__":
    main()
