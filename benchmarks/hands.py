"""What hands on a joystick cost before anything moves: reports to values.

The devices are the ones whose descriptors the tests have; where no reports were recorded, random
ones of the described length are decoded.
"""

from __future__ import annotations

import json
import random
import statistics
import timeit
from pathlib import Path

from benchmarks.figures import report, say
from rune_tui.controls.hid.descriptor import parse
from rune_tui.controls.hid.device_controls import DeviceDecoder

DEVICES = Path(__file__).parents[1] / "tests" / "data" / "hid"


def decode_us(decoder: DeviceDecoder, reports: list[bytes]) -> float:
    """Median time of a report, over runs of many [us]."""

    def decode_all() -> None:
        for each in reports:
            decoder.decode(each)

    calls = max(1, 2000 // len(reports))
    times = timeit.repeat(decode_all, number=calls, repeat=9)
    return statistics.median(times) / calls / len(reports) * 1e6


def reports_of(descriptor: bytes, recorded: list[str]) -> list[bytes]:
    if recorded:
        return [bytes.fromhex(each) for each in recorded]
    parsed, generator = parse(descriptor), random.Random(1)
    used = dict.fromkeys(field.report_id for field in parsed.fields)
    return [
        (bytes([each]) if parsed.numbered else b"")
        + generator.randbytes((parsed.bits[each] + 7) // 8)
        for each in used
        for _ in range(20)
    ]


def main() -> None:
    decoding, parsing = {}, {}
    for path in sorted(DEVICES.glob("*.json")):
        said = json.loads(path.read_text())
        descriptor = bytes.fromhex(said["report_descriptor"])
        vid, pid, bus = int(said["vid"], 16), int(said["pid"], 16), said["bus"]
        decoder = DeviceDecoder(descriptor, vid=vid, pid=pid, bus=bus)
        if not decoder.joystick:
            continue
        decoding[path.stem] = decode_us(decoder, reports_of(descriptor, said["reports"]))
        runs = timeit.repeat(
            lambda d=descriptor, v=vid, p=pid, b=bus: DeviceDecoder(d, vid=v, pid=p, bus=b),
            number=10,
            repeat=9,
        )
        parsing[path.stem] = statistics.median(runs) / 10 * 1e3
        say(f"{path.stem}: decode {decoding[path.stem]:.1f} us, parse {parsing[path.stem]:.2f} ms")
    slowest = max(decoding, key=decoding.__getitem__)
    longest = max(parsing, key=parsing.__getitem__)
    note = (
        f"{len(decoding)} devices; slowest {slowest} {decoding[slowest]:.1f} us; "
        f"a descriptor takes up to {parsing[longest]:.2f} ms ({longest}), once"
    )
    report("hid.decode_us", statistics.median(decoding.values()), "us", bar=40, note=note)


if __name__ == "__main__":
    main()
