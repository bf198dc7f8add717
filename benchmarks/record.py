"""What `rune-hub record` costs: 5,000 messages of 200 B and 30 pictures of 57.6 kB a second.

Costs are of the whole process with all its threads, as the system counts them. Beside them stand
receivers that only count the same messages: ZeroMQ's own that wakes for each, and one that looks
every 50 ms. Both get messages alone, no pictures, and write nothing.

| pattern | senders | sends |
| --- | --- | --- |
| groups | 1 | 5 messages every millisecond |
| even | 1 | a message every 0.2 ms |
| modules | 10 | 5 messages every 10 ms, each |
"""

from __future__ import annotations

import argparse
import os
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import zmq

from benchmarks.figures import report, say
from benchmarks.log import HOGS, PICTURES, RATE, SECONDS, payloads
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.recording.reader import Recording
from hub.values import dataclass

NAMES = 50
BEFORE_S = 2.0
"""Time before the cost is counted [s]."""
PATTERNS = {"groups": (1, 5), "even": (1, 1), "modules": (10, 5)}
"""Number of senders, and messages that each sends at once."""
FRAME = 264
"""Length of a message with its header [bytes]."""
END = b"end"
_ENCAPSULATION = b"\x00\x01\x00\x00"


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A message of some bytes."""

    data: bytes = b""


PICTURE = MessageDefinition(
    name="Bench_Picture", format="{<ubyte>}", type=Block, keep=Keep.ALL, plane=Plane.PICTURE
)


def definitions(sender: int, count: int) -> list[MessageDefinition]:
    return [
        MessageDefinition(
            name=f"Bench_{sender}_{n}", format="{[double:25]}", type=Block, keep=Keep.ALL
        )
        for n in range(count)
    ]


def pace(pattern: str, seconds: float, work: Callable[[int], None]) -> int:
    """Call `work` for each group of messages in time; how many messages."""
    senders, group = PATTERNS[pattern]
    rate = RATE / senders / group
    begun, total = time.monotonic(), int(seconds * rate)
    for step in range(total):
        work(step)
        left = begun + (step + 1) / rate - time.monotonic()
        if left > 0.0:
            time.sleep(left)
    return total * group


def send(endpoint: str, number: int, pattern: str) -> None:
    """Publish after a line on standard input; print how many messages."""
    senders, group = PATTERNS[pattern]
    client = Client(f"sender{number}", endpoint)
    client.wait_connected(10.0)
    names = definitions(number, NAMES // senders)
    messages, pictures = payloads()
    small = [_ENCAPSULATION + each for each in messages]
    large = [_ENCAPSULATION + len(each).to_bytes(4, "little") + each for each in pictures]
    every = [*names, PICTURE] if number == 0 else names
    for each in every:
        client.publish_payload(each, large[0] if each is PICTURE else small[0])
    client.wait_published(10.0)
    print("ready", flush=True)
    while not select.select([sys.stdin], [], [], 0.0)[0]:
        client.listen(0.05)
    sys.stdin.readline()
    begun, shown = time.monotonic(), 0

    def work(step: int) -> None:
        nonlocal shown
        for count in range(step * group, (step + 1) * group):
            client.publish_payload(names[count % len(names)], small[count & 63])
        if number == 0 and (time.monotonic() - begun) * PICTURES > shown:
            shown += 1
            client.publish_payload(PICTURE, large[shown & 7])
        if step % 64 == 0:
            client.listen(0.0)

    count = pace(pattern, BEFORE_S + SECONDS, work)
    client.wait_published(10.0)
    print(len(every) + count + shown, flush=True)
    while not select.select([sys.stdin], [], [], 0.0)[0]:
        client.listen(0.05)
    client.close()


def push(address: str, pattern: str) -> None:
    """Send as `send` does, without Rune."""
    with zmq.Context() as context, context.socket(zmq.PUSH) as socket:
        socket.connect(address)
        group = PATTERNS[pattern][1]
        pace(pattern, SECONDS, lambda _: socket.send(bytes(group * FRAME)))
        socket.send(END)


def pull(address: str, pattern: str, wait: float) -> None:
    """Count messages; print the cost [% of a core]."""
    with zmq.Context() as context, context.socket(zmq.PULL) as socket:
        socket.bind(address)
        print("ready", flush=True)
        ended, begun = 0, time.process_time()
        while ended < PATTERNS[pattern][0]:
            if wait:
                time.sleep(wait)
            else:
                socket.poll()
            try:
                while True:
                    ended += socket.recv(zmq.NOBLOCK) == END
            except zmq.Again:
                pass
        print(100 * (time.process_time() - begun) / SECONDS, flush=True)


def start(*arguments: str) -> subprocess.Popen[str]:
    """Run a part of this script, or of Rune, in a process of its own."""
    here = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    return subprocess.Popen(
        [sys.executable, *arguments],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=here,
    )  # fmt: skip


def line_of(process: subprocess.Popen[str]) -> str:
    return process.stdout.readline() if process.stdout else ""


def floor(pattern: str, folder: Path, wait: float) -> float:
    """The cost of a receiver of ZeroMQ that only counts [% of a core]."""
    address = f"ipc://{folder}/floor"
    receiver = start(__file__, "pull", address, pattern, str(wait))
    line_of(receiver)
    senders = [start(__file__, "push", address, pattern) for _ in range(PATTERNS[pattern][0])]
    cost = float(line_of(receiver))
    for each in (*senders, receiver):
        each.communicate()
    return cost


def used(process: int) -> float:
    """Time that a process has had of all cores [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def record(pattern: str, folder: Path, load: int) -> tuple[float, int, int]:
    """Cost [% of a core], number of messages that were sent, and of those in the file."""
    endpoint, path = f"ipc://{folder}/hub", folder / "recorded.mcap"
    central = Central([endpoint])
    senders = [
        start(__file__, "send", endpoint, str(number), pattern)
        for number in range(PATTERNS[pattern][0])
    ]
    hogs = []
    try:
        for each in senders:
            line_of(each)
        recorder = start(
            "-m", "hub", "record", "--hub", endpoint, "-o", str(path), "--pictures", "0",
            "--maps", "0", "--least-free", "1 MB", "-e", "Bench_",
        )  # fmt: skip
        line_of(recorder)
        hogs = [start("-c", "while True: pass") for _ in range(load)]
        for each in senders:
            print(file=each.stdin, flush=True)
        time.sleep(BEFORE_S)
        before, since = used(recorder.pid), time.monotonic()
        time.sleep(SECONDS - 1.0)
        cost = 100 * (used(recorder.pid) - before) / (time.monotonic() - since)
        sent = sum(int(line_of(each)) for each in senders)
        time.sleep(0.5)  # the last ones are under way
        recorder.terminate()
        recorder.communicate()
    finally:
        for hog in hogs:
            hog.kill()
        for each in (*senders, *hogs):
            each.communicate("\n")
        central.close()
    with Recording.open(path) as recording:
        return cost, sent, sum(len(each.stamps) for each in recording.facts())


def main() -> None:
    if sys.argv[1:2] and sys.argv[1] in ("send", "push", "pull"):
        _, role, address, *rest = sys.argv
        if role == "send":
            send(address, int(rest[0]), rest[1])
        elif role == "push":
            push(address, rest[0])
        else:
            pull(address, rest[0], float(rest[1]))
        return
    parser = argparse.ArgumentParser()
    parser.add_argument("--pattern", nargs="*", default=list(PATTERNS))
    parser.add_argument("--load", nargs="*", type=int, default=[0, HOGS])
    options = parser.parse_args()
    for pattern in options.pattern:
        for load in options.load:
            say(f"{pattern}, {load} busy processes beside")
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                peers = {}
                if not load:
                    peers["zmq, counts only"] = round(floor(pattern, folder, 0.0), 2)
                    peers["zmq every 50 ms, counts only"] = round(floor(pattern, folder, 0.05), 2)
                cost, sent, kept = record(pattern, folder, load)
            note = f"the whole process of rune-hub record; {sent} messages, {pattern}"
            report(
                f"record_cpu_{pattern}_load_{load}", cost, "% of a core",
                bar=3.0, peers=peers, note=note,
            )  # fmt: skip
            report(
                f"record_lost_{pattern}_load_{load}", sent - kept, "messages", bar=0.0, note=note
            )


if __name__ == "__main__":
    main()
