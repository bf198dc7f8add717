"""What recordings cost: writing 5,000 messages and 30 pictures a second, opening, seeking, reading.

Costs are processor time of a process of its own, less that of the same loop without a recording.
mcap as it is packs with zstd in chunks of 1 MiB, in the thread that adds messages.
"""

from __future__ import annotations

import json
import os
import random
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mcap.reader import SeekingReader
from mcap.writer import CompressionType, Writer

from benchmarks.figures import median_ms, report, say
from hub.recording.anchor import TimeAnchor
from hub.recording.encoder import McapEncoder
from hub.recording.reader import Recording
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter, WriterLimits

SECONDS = 10.0
RATE, PICTURES = 5000, 30
CHUNKS_OF_HOUR, TOPICS = 7200, 51
HOGS = 4
Add = Callable[[int, bytes, float, int], None]


def payloads() -> tuple[list[bytes], list[bytes]]:
    """Messages of 200 B, and pictures of 57.6 kB with noise."""
    noise = np.random.default_rng(1)
    slope = np.linspace(0, 255, 160)[None, :, None]
    pictures = [np.clip(noise.normal(0, 4, (120, 160, 3)) + slope, 0, 255) for _ in range(8)]
    messages = [noise.normal(size=25).tobytes() for _ in range(64)]
    return messages, [each.astype(np.uint8).tobytes() for each in pictures]


def topics() -> list[RecordedTopic]:
    definition = b"float64[25] x\n"
    return [
        RecordedTopic(f"/rover/T{n}", "rune_msgs/msg/X", schema=definition) for n in range(TOPICS)
    ]


def produce(add: Add, seconds: float) -> int:
    """Add messages in time; how many."""
    messages, pictures = payloads()
    count, begun = 0, time.monotonic()
    for step in range(int(seconds * 1000)):
        now = time.monotonic()
        for _ in range(RATE // 1000):
            add(count % (TOPICS - 1), messages[count & 63], now, count + 1)
            count += 1
        if step * PICTURES // 1000 != (step + 1) * PICTURES // 1000:
            add(TOPICS - 1, pictures[count & 7], now, count + 1)
            count += 1
        left = begun + (step + 1) / 1000 - time.monotonic()
        if left > 0.002:
            time.sleep(left)
    return count


def record(subject: str, path: Path) -> dict[str, float]:
    """Record for `SECONDS`, in this process."""
    every = topics()
    writer: RecordingWriter | None = None
    finish: Callable[[], object] = int
    if subject == "rune":
        limits = WriterLimits(least_free=0)
        writer = rune = RecordingWriter(path, TimeAnchor.now(), {}, limits)
        finish = rune.close

        def add(topic: int, payload: bytes, now: float, number: int) -> None:
            rune.add(every[topic], payload, now, now, number)

    elif subject == "mcap":
        file = path.open("wb")
        theirs = Writer(file, compression=CompressionType.ZSTD)
        theirs.start("", "benchmark")
        schema = theirs.register_schema("rune_msgs/msg/X", "ros2msg", every[0].schema)
        channels = [theirs.register_channel(each.name, "cdr", schema) for each in every]

        def add(topic: int, payload: bytes, _now: float, number: int) -> None:
            stamp = time.time_ns()
            theirs.add_message(channels[topic], stamp, payload, stamp, number)

        def close() -> None:
            theirs.finish()
            file.close()

        finish = close
    else:

        def add(topic: int, payload: bytes, now: float, number: int) -> None:
            pass

    begun = time.process_time()
    count = produce(add, SECONDS)
    finish()
    used = time.process_time() - begun
    lost = sum(writer.state.lost.values()) if writer is not None else 0
    size = path.stat().st_size if path.exists() else 0
    return {"cpu": used, "messages": count, "lost": lost, "bytes": size}


def in_process(*arguments: str) -> dict[str, float]:
    command = [sys.executable, str(Path(__file__)), *arguments]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    return json.loads(done.stdout)


def write_costs(folder: Path, load: int) -> None:
    hogs = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(load)]
    try:
        runs = {
            subject: in_process("record", subject, str(folder / f"{subject}-{load}.mcap"))
            for subject in ("nothing", "rune", "mcap")
        }
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()
    cost = {
        subject: 100 * (run["cpu"] - runs["nothing"]["cpu"]) / SECONDS
        for subject, run in runs.items()
    }
    where = f", {load} busy processes beside" if load else ""
    rate = f"{RATE} messages of 200 B and {PICTURES} pictures of 57.6 kB a second{where}"
    size = {subject: run["bytes"] / SECONDS / 1e6 for subject, run in runs.items()}
    report(
        f"recording_cpu_load_{load}", cost["rune"], "% of a core", bar=3.0,
        peers={"mcap": round(cost["mcap"], 2)},
        note=f"{rate}; {size['rune']:.2f} MB/s on disk, mcap {size['mcap']:.2f}; "
        f"the loop itself {100 * runs['nothing']['cpu'] / SECONDS:.1f} %",
    )  # fmt: skip
    report(f"recording_lost_load_{load}", runs["rune"]["lost"], "messages", bar=0.0, note=rate)


def resident() -> int:
    """Memory of this process [bytes]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


def index_memory(subject: str) -> dict[str, float]:
    """Growth of the process over the chunks of an hour, the last of them and the index included."""
    payload = bytes(50)
    before = resident()
    if subject == "rune":
        encoder = McapEncoder()
        encoder.begin()
        channels = [encoder.register(each) for each in topics()]
        for chunk in range(CHUNKS_OF_HOUR):
            for channel in channels:
                encoder.add(channel, chunk, chunk, 1, payload)
            encoder.end_chunk()
            encoder.keep()
        kept = resident()
        end = encoder.end()
        after = resident() if end else 0
    else:
        with Path(os.devnull).open("wb") as file:
            theirs = Writer(file, compression=CompressionType.LZ4)
            theirs.start("", "benchmark")
            channels = [theirs.register_channel(each.name, "cdr", 0) for each in topics()]
            for chunk in range(CHUNKS_OF_HOUR):
                for channel in channels:
                    theirs.add_message(channel, chunk, payload, chunk, 1)
                theirs.flush()
            kept = resident()
            theirs.finish()
            after = resident()
    return {"kept": (kept - before) / 1e6, "all": (after - before) / 1e6}


def write_hour(path: Path) -> int:
    """An hour of 51 topics, about 100 messages a second in chunks of 0.5 s; how many messages."""
    rng = random.Random(1)
    encoder = McapEncoder()
    messages, _ = payloads()
    count = 0
    with path.open("wb") as file:
        file.write(encoder.begin())
        channels = [encoder.register(each) for each in topics()]
        begin = 1_790_000_000_000_000_000
        for chunk in range(CHUNKS_OF_HOUR):
            for place in range(50):
                count += 1
                channel = channels[rng.randrange(TOPICS)]
                stamp = begin + chunk * 500_000_000 + place * 10_000_000
                encoder.add(channel, stamp, stamp, count, messages[rng.randrange(64)])
            file.write(encoder.end_chunk())
            encoder.keep()
        file.write(encoder.end())
    return count


def read_costs(folder: Path) -> None:
    path = folder / "hour.mcap"
    count = write_hour(path)
    about = f"an hour, {TOPICS} topics, {count} messages, {path.stat().st_size / 1e6:.0f} MB"

    def open_it(_: int) -> None:
        with Recording.open(path) as recording:
            recording.newest(recording.end, set())

    def open_theirs(_: int) -> None:
        with path.open("rb") as file:
            SeekingReader(file).get_summary()

    theirs = median_ms(open_theirs, 3, 1, time.process_time)
    opened = median_ms(open_it, 9, clock=time.process_time)
    report("recording_open_hour", opened, "ms", bar=100.0, peers={"mcap": theirs}, note=about)

    rng = random.Random(2)
    with Recording.open(path) as recording:
        times = []
        for _ in range(300):
            stamp = rng.randrange(recording.start, recording.end)
            begun = time.process_time()
            found = recording.newest(stamp)
            times.append((time.process_time() - begun) * 1e3)
            if len(found) < TOPICS - 5:
                say(f"only {len(found)} topics are there at {stamp}")
    times.sort()
    report("recording_newest_median", times[150], "ms", note=f"newest of all topics; {about}")
    report(
        "recording_newest_p95", times[285], "ms", bar=10.0, note=f"newest of all topics; {about}"
    )

    with Recording.open(path) as recording:
        begun = time.process_time()
        read = sum(1 for _ in recording.messages())
        ours = read / (time.process_time() - begun)
        begun = time.process_time()
        checked = sum(len(each.stamps) for each in recording.facts())
        facts = checked / (time.process_time() - begun)
    with path.open("rb") as file:
        begun = time.process_time()
        part = 0
        for part, _ in enumerate(SeekingReader(file).iter_messages(), 1):
            if part == 50_000:
                break
        theirs = part / (time.process_time() - begun)
    report(
        "recording_iterate", ours, "messages/s", better="higher", peers={"mcap": theirs}, note=about
    )
    report("recording_facts", facts, "messages/s", better="higher", note="as rune-hub log info")
    cut = folder / "cut.mcap"
    cut.write_bytes(path.read_bytes()[: -path.stat().st_size // 4])
    scanned = median_ms(lambda _: Recording.open(cut).close(), 3, 1, time.process_time)
    report("recording_open_unfinished", scanned, "ms", note="the same without its last quarter")


def main() -> None:
    if sys.argv[1:2] == ["record"]:
        print(json.dumps(record(sys.argv[2], Path(sys.argv[3]))))
        return
    if sys.argv[1:2] == ["memory"]:
        print(json.dumps(index_memory(sys.argv[2])))
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        say("reading an hour")
        read_costs(folder)
        say("memory of an hour's index")
        ours, theirs = in_process("memory", "rune"), in_process("memory", "mcap")
        report(
            "recording_index_memory", ours["kept"], "MB an hour", bar=20.0,
            peers={"mcap": theirs["kept"]},
            note=f"{TOPICS} topics in each of {CHUNKS_OF_HOUR} chunks; with the writing of the "
            f"index {ours['all']:.0f}, mcap {theirs['all']:.0f}",
        )  # fmt: skip
        for load in (0, HOGS):
            say(f"writing, {load} busy processes beside")
            write_costs(folder, load)


if __name__ == "__main__":
    main()
