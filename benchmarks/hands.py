"""What the use of a joystick costs, and how soon the robot moves.

Decoded are the reports of the devices whose descriptors the tests have; where none were recorded,
random ones of the described length. The rest is measured with a virtual gamepad at the real console
that shows the picture of the robot's camera over its whole terminal.
"""

from __future__ import annotations

import itertools
import json
import os
import random
import re
import statistics
import subprocess
import sys
import tempfile
import time
import timeit
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

import psutil

from benchmarks.figures import report, say
from hub.gcm.navigation import GROUND_TRUTH, VELOCITY_COMMAND
from rune_tui.controls.hid.descriptor import parse
from rune_tui.controls.hid.device_controls import DeviceDecoder
from tests.support.fake_hid import MISSING, VirtualBed, library
from tests.support.waiting import until
from tests.system.conftest import LAYOUT
from tests.system.harness import ConsoleProcess, HubProcess, Observer

DEVICES = Path(__file__).parents[1] / "tests" / "data" / "hid"

_PAD = "logitech_f310_dinput"
_STICK = '<event joystick="pad" axis="lefty" control="translate"/>'
_CENTRE = 128
_REPORTS_RELEASES, _W_DOWN, _W_UP = "\x1b[?27u", "\x1b[119;;119u", "\x1b[119;1:3u"
"""A terminal with the kitty keyboard protocol."""
_STILL = 1e-4
_MOVES = 200
_DRIVES = 20
_BUSY_S = 10.0
_READ_ON = """
import json, os, select, sys, threading, types
from rune_tui.controls.devices import device_reader, hid_reader
from rune_tui.controls.devices.matching import DeviceInfo

class Device:  # reads a pipe that keeps packets apart, as the kernel's queue of reports does
    def open_path(self, path):
        self.waiting = select.poll()
        self.waiting.register(0, select.POLLIN)
    def get_report_descriptor(self):
        return bytes.fromhex(said["report_descriptor"])
    def set_nonblocking(self, on):
        pass
    def read(self, most, timeout_ms=0):
        return list(os.read(0, most)) if self.waiting.poll(timeout_ms) else []
    def close(self):
        pass

said = json.load(open(sys.argv[1]))
hid_reader.hidapi = lambda: types.SimpleNamespace(device=Device, enumerate=list)
moved = threading.Event()
reader = device_reader.DeviceReader([hid_reader.HidKind()])
reader.start(moved.set)
vid, pid = int(said["vid"], 16), int(said["pid"], 16)
reader.read(DeviceInfo(path="pad", vid=vid, pid=pid, bus=said["bus"]))
print("ready", flush=True)
while True:
    moved.wait()
    moved.clear()
    if (inbox := reader.inbox("pad")) is not None:
        inbox.take()
"""


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


class Drive:
    """A hub, a console that shows 15 pictures a second, an observer of commands and wheels."""

    def __init__(self, stack: ExitStack, environment: dict[str, str]) -> None:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        self.hub = stack.enter_context(closing(HubProcess(folder)))
        layout = folder / "layout.xml"
        layout.write_text(
            re.sub(r'interval_ms="\d+"', 'interval_ms="66"', LAYOUT)
            .format(hub=self.hub.endpoint)
            .replace("<view x", '<joystick name="pad"/><view x')
            .replace('<event key="w"', f'{_STICK}<event key="w"')
        )
        self.console = stack.enter_context(
            closing(
                ConsoleProcess(["run", str(layout)], columns=160, rows=48, environment=environment)
            )
        )
        self.console.wait_for_picture()
        self.observer = stack.enter_context(
            closing(Observer(self.hub.endpoint, GROUND_TRUTH, VELOCITY_COMMAND))
        )
        self.commands = self.observer.seen[VELOCITY_COMMAND.name]

    def serve(self, seconds: float) -> None:
        """Let the console write and the observer listen for a while [s]."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.step()

    def step(self) -> None:
        self.console.drain(0.001)
        self.observer.client.listen(0.001)

    def command_after(self, act: Callable[[], None], *, wanted: bool) -> tuple[float, float]:
        """When something was done, and when the command to move, or not, was sent [s]."""
        self.commands.clear()
        done = time.monotonic()
        act()
        hit = [0.0]

        def seen() -> bool:
            hit[:1] = [
                t for t, command in self.commands if (command.twist.linear.x != 0.0) == wanted
            ][:1]
            return bool(hit)

        until(seen, 5.0, "no command came", meanwhile=self.step)
        return done, hit[0]


class Pad:
    """A virtual gamepad at such a console."""

    def __init__(self, stack: ExitStack) -> None:
        bed = stack.enter_context(closing(VirtualBed()))
        self._device = bed.plug(_PAD)
        stack.callback(self._device.unplug)
        self.drive = Drive(stack, bed.environment)
        self._device.send(report_of(_CENTRE))

    def push(self, y: int) -> tuple[float, float]:
        """Move the stick; when that was, and when the command that follows was sent [s]."""
        report = report_of(y)
        return self.drive.command_after(lambda: self._device.send(report), wanted=y != _CENTRE)


def report_of(y: int) -> bytes:
    """What the gamepad sends with its left stick so far down, 0 to 255."""
    return bytes([128, y, 128, 128, 0x08, 0, 0, 0])


def report_to_command() -> None:
    """From a report at the device's node to the command that the console sends."""
    times = []
    with ExitStack() as stack:
        pad = Pad(stack)
        pad.drive.serve(0.5)
        for move in range(_MOVES):
            sent, came = pad.push(0 if move % 2 == 0 else _CENTRE)
            times.append(came - sent)
            pad.drive.serve(0.05 + 0.0037 * (move % 11))  # another phase of every timer each time
    report_p99("hid.report_to_command_p99_ms", times, bar=5)


def press_to_command() -> None:
    """From the bytes of a key at the terminal, as its keyboard sends them, to the command."""
    times = []
    with ExitStack() as stack:
        drive = Drive(stack, {})
        drive.console.type(_REPORTS_RELEASES)
        drive.serve(0.5)
        for move in range(_MOVES):
            keys, wanted = (_W_UP, False) if move % 2 else (_W_DOWN, True)
            sent, came = drive.command_after(lambda k=keys: drive.console.type(k), wanted=wanted)
            times.append(came - sent)
            drive.serve(0.05 + 0.0037 * (move % 11))
    report_p99("key.press_to_command_p99_ms", times, bar=20)


def report_p99(name: str, times: list[float], bar: float) -> None:
    times.sort()
    p99 = times[int(0.99 * len(times))]
    note = f"median {statistics.median(times) * 1e3:.1f} ms, largest {times[-1] * 1e3:.1f} ms"
    report(name, p99 * 1e3, "ms", bar=bar, note=note)


def report_to_wheel() -> None:
    """From a report to the first change of the true velocity."""
    times = []
    with ExitStack() as stack:
        pad = Pad(stack)
        drive = pad.drive
        truth = drive.observer.history

        def still() -> bool:
            return abs(truth[-1][1].linear) < _STILL

        def moved() -> list[float]:
            return [t for t, each in truth if abs(each.linear) > _STILL]

        for move in range(_DRIVES):
            until(still, 10.0, meanwhile=drive.step)
            drive.serve(0.7 + 0.013 * move)
            truth.clear()
            sent, _ = pad.push(0 if move % 2 else 255)
            until(moved, 5.0, meanwhile=drive.step)
            times.append(moved()[0] - sent)
            pad.push(_CENTRE)
    note = f"the driver reports every 3 ms after the command; largest {max(times) * 1e3:.0f} ms"
    report("hid.report_to_wheel_ms", statistics.median(times) * 1e3, "ms", bar=30, note=note)


def busy_pad() -> None:
    """What a gamepad that reports 1000 times a second costs the console, of one core."""
    path = DEVICES / "sony_dualsense_bt.json"
    reports = itertools.cycle(map(bytes.fromhex, json.loads(path.read_text())["reports"]))
    inner, outer = os.pipe2(os.O_DIRECT)
    command = [sys.executable, "-c", _READ_ON, str(path)]
    with subprocess.Popen(command, stdin=inner, stdout=subprocess.PIPE) as reader:
        os.close(inner)
        if reader.stdout is not None:
            reader.stdout.readline()
        process, begun, sent = psutil.Process(reader.pid), time.monotonic(), 0
        before = process.cpu_times()
        while (now := time.monotonic()) - begun < _BUSY_S:
            while (now - begun) * 1000.0 > sent:
                os.write(outer, next(reports))
                sent += 1
            time.sleep(0.0005)
        after = process.cpu_times()
        reader.kill()
    os.close(outer)
    used = (after.user + after.system - before.user - before.system) / (now - begun)
    note = "recorded reports of a DualSense, through a pipe"
    report("hid.cpu_1000hz", used, "of a core", bar=0.05, note=note)


def main() -> None:
    decoding_and_parsing()
    say("a busy gamepad")
    busy_pad()
    say("press to command")
    press_to_command()
    if library() is None:
        for name, bar in (("hid.report_to_command_p99_ms", 5), ("hid.report_to_wheel_ms", 30)):
            report(name, None, "ms", bar=bar, note=MISSING)
        return
    say("report to command")
    report_to_command()
    say("report to wheel")
    report_to_wheel()


def decoding_and_parsing() -> None:
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
