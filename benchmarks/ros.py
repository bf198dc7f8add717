"""What a line to a robot with ROS costs: pictures at 30 Hz, odometry and velocities at 50 Hz.

The robot is Foxglove's own server in a process of its own. Beside our line, the client of
websockets with asyncio does the same.
"""

from __future__ import annotations

import asyncio
import json
import multiprocessing
import select
import statistics
import struct
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from benchmarks.figures import report, say
from hub.ipc.transport.loop import Loop
from hub.robots.ros.address import ros_address
from hub.robots.ros.foxglove import wire
from hub.robots.ros.opening import line_to

_SECONDS = 12.0
_WARM_S = 2.0
_IMAGE, _ODOMETRY, _COMMAND = "/camera/image_raw", "/odom", "/cmd_vel"
_SIZES = {_IMAGE: 57_680, _ODOMETRY: 720, _COMMAND: 68}
_COMMAND_S = 0.02
_STEP_S = 0.05
"""A driver makes a step at least as often; messages wake it besides [s]."""
_STAMP = struct.Struct("<4sq")
"""Encapsulation, and the monotonic time [ns], which all processes of a machine share."""


def stamped(topic: str) -> bytes:
    return _STAMP.pack(b"\0\1\0\0", time.monotonic_ns()).ljust(_SIZES[topic], b"\x55")


def way_ms(payload: bytes | memoryview) -> float:
    return (time.monotonic_ns() - _STAMP.unpack_from(payload)[1]) / 1e6


def robot(pipe: Connection) -> None:
    """Be the robot: a process of its own. Says its port, ends at a word, and says the ways."""
    import foxglove
    from foxglove import Channel, Context, Schema
    from foxglove.websocket import Capability, ServerListener

    ways: list[float] = []

    class Listener(ServerListener):
        def on_message_data(self, _client: Any, _channel: int, data: bytes) -> None:
            ways.append(way_ms(data))

    context = Context()
    server = foxglove.start_server(
        host="127.0.0.1",
        port=0,
        context=context,
        capabilities=[Capability.ClientPublish],
        supported_encodings=["cdr"],
        server_listener=Listener(),
    )
    schema = Schema(name="std_msgs/msg/String", encoding="ros2msg", data=b"string data\n")
    channels = [
        (Channel(topic, schema=schema, message_encoding="cdr", context=context), topic, period)
        for topic, period in ((_IMAGE, 1 / 30), (_ODOMETRY, 1 / 50))
    ]
    pipe.send(server.port)
    due = [time.monotonic()] * len(channels)
    while not pipe.poll(max(0.0, min(due) - time.monotonic())):
        for index, (channel, topic, period) in enumerate(channels):
            if due[index] <= time.monotonic():
                due[index] += period
                channel.log(stamped(topic))
    pipe.send(ways)
    pipe.poll(None)  # the server's threads end with the process


class Record:
    """The ways of messages to a client, and its processor time, without its start."""

    def __init__(self) -> None:
        self.ways: dict[str, list[float]] = {_IMAGE: [], _ODOMETRY: []}
        self.begun, self.used = time.monotonic(), 0.0
        self._counts = False

    def take(self, topic: str, payload: bytes | memoryview) -> None:
        if self._counts:
            self.ways[topic].append(way_ms(payload))

    def left(self) -> float:
        """Seconds until the end; begins to count after the start."""
        past = time.monotonic() - self.begun
        if past > _WARM_S and not self._counts:
            self._counts, self.used = True, -time.process_time()
        return _WARM_S + _SECONDS - past

    def end(self) -> tuple[dict[str, float], float]:
        share = 100.0 * (self.used + time.process_time()) / _SECONDS
        return {topic: statistics.median(ways) for topic, ways in self.ways.items()}, share


def ours(port: int) -> Record:
    """Our line in the loop of a driver."""
    record, loop = Record(), Loop()
    line = line_to(ros_address(f"ws://127.0.0.1:{port}"))

    def advance() -> None:
        line.advance(time.monotonic())

    for topic in (_IMAGE, _ODOMETRY):
        line.subscribe(topic, lambda message, topic=topic: record.take(topic, message.payload))
    line.advertise(_COMMAND, "geometry_msgs/msg/TwistStamped")
    line.watch(loop, advance)
    loop.every(_STEP_S, advance)
    loop.every(_COMMAND_S, lambda: line.publish(_COMMAND, stamped(_COMMAND)))
    while record.left() > 0.0:
        loop.listen(1.0)
    line.close()
    loop.close()
    return record


class Session:
    """What a client of websockets has to say, and what it makes of an answer."""

    def __init__(self, record: Record) -> None:
        self.record = record
        self._topics: dict[int, str] = {}

    def answer(self, message: str | bytes) -> list[str]:
        if isinstance(message, bytes):
            _, number, _ = struct.unpack_from("<BIQ", message)
            self.record.take(self._topics[number], memoryview(message)[13:])
            return []
        value = json.loads(message)
        if value["op"] == "serverInfo":
            return [wire.advertise(1, _COMMAND, "geometry_msgs/msg/TwistStamped", "cdr").decode()]
        self._topics = {each["id"]: each["topic"] for each in value.get("channels", [])}
        return [wire.subscribe({each: each for each in self._topics}).decode()]


def asynchronous(port: int) -> Record:
    """The client of websockets with asyncio."""
    from websockets.asyncio.client import connect
    from websockets.typing import Subprotocol

    session = Session(Record())
    subprotocols = [Subprotocol(each) for each in wire.SUBPROTOCOLS]

    async def run() -> None:
        async with connect(f"ws://127.0.0.1:{port}", subprotocols=subprotocols) as client:

            async def command() -> None:
                while True:
                    await asyncio.sleep(_COMMAND_S)
                    await client.send(wire.data(1, stamped(_COMMAND)))

            async with asyncio.TaskGroup() as tasks:
                task = tasks.create_task(command())
                while session.record.left() > 0.0:
                    for text in session.answer(await client.recv()):
                        await client.send(text)
                task.cancel()

    asyncio.run(run())
    return session.record


def measured(client: Callable[[int], Record]) -> dict[str, float]:
    """The ways to and from a client [ms], and its share of a core [%]."""
    ours_end, its_end = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=robot, args=(its_end,))
    process.start()
    its_end.close()  # so that its end is seen here
    record = client(ours_end.recv())
    ways, share = record.end()
    ours_end.send("end")
    commands = ours_end.recv()
    process.kill()
    process.join()
    return {"image": ways[_IMAGE], "odometry": ways[_ODOMETRY]} | {
        "command": statistics.median(commands),
        "share": share,
    }


def wake_up_us() -> float:
    """What the processor spends on a wake-up in which nothing is done [us]."""
    poller, count = select.epoll(), 300
    begun = time.process_time()
    for _ in range(count):
        poller.poll(0.01)
    poller.close()
    return 1e6 * (time.process_time() - begun) / count


def line() -> None:
    """Measure our line and the other client."""
    note = (
        f"a wake-up that does nothing takes {wake_up_us():.0f} us; the line needs some 150 a second"
    )
    clients = {"websockets, asyncio": asynchronous}
    found = measured(ours)
    peers = {name: measured(client) for name, client in clients.items()}
    for name, unit, bar in (
        ("image", "ms", 1.0),
        ("odometry", "ms", 1.0),
        ("command", "ms", 1.0),
        ("share", "% of a core", 3.0),
    ):
        theirs = {peer: round(figures[name], 4) for peer, figures in peers.items()}
        report(f"ros_line_{name}", found[name], unit, bar=bar, peers=theirs, note=note)


def main() -> None:
    """Measure the line."""
    say("the line takes a minute")
    line()


if __name__ == "__main__":
    main()
