"""What a hub costs without a console, and how fast a module that was killed is back.

Real processes: a hub with a simulated robot. For the second part a script drives it in an empty
hall while each module in turn gets SIGKILL.
"""

from __future__ import annotations

import os
import signal
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import psutil

from benchmarks.figures import report, say
from hub.errors import HubError
from hub.gcm import autonomy, mapping, navigation, supervision, vision
from hub.gcm.geometry import TwistStamped
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from tests.support.waiting import until
from tests.system.harness import HubProcess, family

ROUNDS = 5
MODULES = ("driver", "navigation", "vision", "mapping", "autonomy")
STILL = 0.005
IDLE_S = 20.0
"""Measured time of an idle hub [s]."""
QUIET_S = 8.0
"""Time until vision no longer expects a console [s]."""
_ASK_S = 0.05

Fresh = dict[str, tuple[int, float]]


class Console:
    """Drives, and sees the messages of each sender."""

    def __init__(self, endpoint: str) -> None:
        self.client = Client("script", endpoint)
        self.client.wait_connected(5.0)
        self.pids: dict[str, int] = {}
        self.fresh: Fresh = {}
        self.truths: list[tuple[float, navigation.GroundTruth]] = []
        self.state: navigation.RobotState | None = None
        self.answered: dict[str, float] = {}
        self.held = False
        for definition in (
            navigation.ROBOT_STATE,
            navigation.DRIVE_STATE,
            autonomy.AUTONOMY_STATE,
        ):
            self.client.subscribe(definition, self._note(definition.name))
        self.client.subscribe(navigation.GROUND_TRUTH, self._note_truth)
        self.client.subscribe(navigation.ROBOT_STATE, self._note_state)
        self.client.subscribe(supervision.MODULE_REPORTS, self._note_modules)
        self.client.every(1.0 / navigation.VELOCITY_COMMAND.rate_hz, self._drive)
        self.client.define(navigation.VELOCITY_COMMAND)

    def _note(self, name: str) -> Callable[[Any, MessageInfo], None]:
        def note(value: Any, how: MessageInfo) -> None:
            del value
            self.fresh[name] = (how.publisher, time.monotonic())

        return note

    def _note_truth(self, truth: navigation.GroundTruth, how: MessageInfo) -> None:
        self.truths.append((how.measured, truth))

    def _note_state(self, state: navigation.RobotState, _: MessageInfo) -> None:
        self.state = state

    def _note_modules(self, reports: supervision.ModuleReports, _: MessageInfo) -> None:
        self.pids = {each.name: each.pid for each in reports.modules}

    def _drive(self) -> None:
        """Drive a wide circle; from neutral wherever that is asked for, or with a held stick."""
        moving = (navigation.MotionState.MOVING, navigation.MotionState.STANDING)
        free = self.held or (self.state is not None and self.state.motion in moving)
        twist = TwistStamped.planar(0.3, 0.5) if free else TwistStamped()
        self.client.publish(navigation.VELOCITY_COMMAND, twist)

    def until(self, condition: Callable[[], object], timeout: float = 20.0) -> None:
        until(condition, timeout, meanwhile=lambda: self.client.listen(0.005))

    def ask(self, name: str) -> None:
        """Ask the module whose capability is an answer; when the first one came is noted."""
        request, answer, value = {
            "vision": (
                vision.IMAGE_REQUEST,
                vision.IMAGE,
                vision.ImageRequest(width_px=64, height_px=48),
            ),
            "mapping": (mapping.MAP_REQUEST, mapping.MAP, mapping.MapRequest()),
        }[name]

        def failed(error: HubError) -> None:
            del error

        def answered(_: object, how: MessageInfo) -> None:
            del how
            self.answered.setdefault(name, time.monotonic())

        self.client.query_notify(
            request, value, answer, timeout=0.5, answered=answered, failed=failed
        )


_STREAMS = {
    "driver": navigation.DRIVE_STATE.name,
    "navigation": navigation.ROBOT_STATE.name,
    "autonomy": autonomy.AUTONOMY_STATE.name,
}


def kill(console: Console, name: str) -> tuple[float, float, float]:
    """Kill a module; time until its capability is back, until the command 0, until rest."""
    console.until(
        lambda: console.truths and console.truths[-1][1].linear > 0.29 and console.pids.get(name)
    )
    until_warm = time.monotonic() + 1.0
    console.until(lambda: time.monotonic() > until_warm)
    stream = _STREAMS.get(name)
    before = console.fresh[stream][0] if stream else 0
    console.truths.clear()
    console.answered.clear()
    console.held = True  # else it drives again before it is at rest
    os.kill(console.pids[name], signal.SIGKILL)
    killed = time.monotonic()
    if stream:
        console.until(lambda: console.fresh[stream][0] != before)
        back = console.fresh[stream][1] - killed
    else:
        timer = console.client.every(_ASK_S, lambda: console.ask(name))
        console.until(lambda: name in console.answered)
        timer.cancel()
        back = console.answered[name] - killed
    end = killed + 1.5
    console.until(lambda: time.monotonic() > end)
    console.held = False
    after = [(t - killed, truth) for t, truth in console.truths if t >= killed]
    commanded = next((t for t, truth in after if truth.commanded_linear == 0.0), 0.0)
    rest = next((t for t, truth in after if abs(truth.linear) < STILL), 0.0)
    return back, commanded, rest


def pss_mb(*options: str) -> float:
    """Proportional set size of an idle hub with five modules, all its processes [MB]."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        hub = stack.enter_context(closing(HubProcess(folder, options=options, modules=MODULES)))
        settled = time.monotonic() + 3.0
        until(lambda: time.monotonic() > settled, 5.0)
        return sum(each.memory_full_info().pss for each in family(hub.process.pid)) / 1e6


def idle_cpu() -> None:
    """The processor time of a hub without clients."""
    modules = ("driver", "navigation", "vision", "mapping")
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        hub = stack.enter_context(closing(HubProcess(folder, arena="yellow", modules=modules)))
        quiet = time.monotonic() + QUIET_S
        until(lambda: time.monotonic() > quiet, 2 * QUIET_S)
        processes = family(hub.process.pid)
        before, begun = [_spent(each) for each in processes], time.monotonic()
        until(lambda: time.monotonic() > begun + IDLE_S, 2 * IDLE_S)
        elapsed = time.monotonic() - begun
        shares = [
            (_spent(each) - spent) / elapsed for each, spent in zip(processes, before, strict=True)
        ]
        names = {pid: name for name, pid in hub.pids.items()}
        rest = sum(
            share for each, share in zip(processes, shares, strict=True) if each.pid not in names
        )
    each_share = ", ".join(
        f"{names[each.pid]} {share:.3f}"
        for each, share in zip(processes, shares, strict=True)
        if each.pid in names
    )
    note = f"{each_share}, daemon and the rest {rest:.3f}"
    report("robomon.idle_cpu", sum(shares), "core", bar=0.09, note=note)


def _spent(process: psutil.Process) -> float:
    """Processor time of a process until now [s]."""
    times = process.cpu_times()
    return float(times.user + times.system)


def memory() -> None:
    """What sharing imports saves."""
    spawned = pss_mb("--spawn")
    note = f"the bar is half of spawned modules, {spawned:.0f} MB"
    report("robomon.pss_MB", pss_mb(), "MB", bar=0.5 * spawned, note=note)


def main() -> None:
    """All figures."""
    say("idle")
    idle_cpu()
    say("memory")
    memory()
    worst: dict[str, list[float]] = {name: [] for name in MODULES}
    stops: list[tuple[float, float]] = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        hub = stack.enter_context(closing(HubProcess(folder, modules=MODULES)))
        console = Console(hub.endpoint)
        stack.callback(console.client.close)
        for name in MODULES:
            for _ in range(ROUNDS):
                back, commanded, rest = kill(console, name)
                say(f"{name}: back {back:.3f} s, commanded 0 {commanded:.3f} s")
                worst[name].append(back)
                if name == "navigation":
                    stops.append((commanded, rest))
    note = ", ".join(
        f"{name} {statistics.median(times):.2f} (largest {max(times):.2f})"
        for name, times in worst.items()
    )
    slowest = max(statistics.median(times) for times in worst.values())
    report("robomon.recovery_s", slowest, "s", bar=0.15, note=f"medians of {ROUNDS}: {note}")
    largest = max(max(times) for times in worst.values())
    report("robomon.recovery_largest_s", largest, "s", bar=0.3)
    report("robomon.live_command_s", max(stop for stop, _ in stops), "s", bar=0.35, note="largest")
    report("robomon.rest_s", max(rest for _, rest in stops), "s", bar=0.7, note="largest")


if __name__ == "__main__":
    main()
