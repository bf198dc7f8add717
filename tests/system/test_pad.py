"""`rune pad`: a virtual gamepad at one program drives the robot through a console in another."""

from __future__ import annotations

import getpass
import math
import os
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.navigation import GROUND_TRUTH, GroundTruth
from tests.support import warm_start
from tests.support.fake_hid import VirtualBed, VirtualDevice, needs_virtual_devices
from tests.support.ports import free_port
from tests.support.waiting import exit_code
from tests.system.gamepads import NAME, PAD, console_at, drive, expect_no_driving, forward, report
from tests.system.harness import STILL, ConsoleProcess, HubProcess, Observer, expect_stop

pytestmark = needs_virtual_devices

COMMANDED_WITHIN_S = 0.35
AT_REST_WITHIN_S = 0.7
_TRIES = 4
"""The machine may be busy with other things just when it counts."""


@pytest.fixture
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture(scope="module")
def console(
    lasting_hub: HubProcess, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ConsoleProcess]:
    """A console where nothing is plugged in."""
    with (
        closing(VirtualBed()) as empty,
        console_at(lasting_hub, empty, tmp_path_factory.mktemp("console")) as started,
    ):
        yield started


class Desk:
    """The operator's machine: a gamepad, and `rune pad`, which sends it."""

    def __init__(self, hub: HubProcess, bed: VirtualBed, folder: Path) -> None:
        self._hub, self._bed, self._folder = hub, bed, folder
        self._plugged: VirtualDevice | None = None
        self._process: warm_start.Process | None = None

    @property
    def pad(self) -> VirtualDevice:
        assert self._plugged is not None
        return self._plugged

    @property
    def said(self) -> str:
        """What `rune pad` has written."""
        return (self._folder / "said.txt").read_text()

    def plug(self) -> None:
        self._plugged = self._bed.plug(PAD)

    def unplug(self) -> None:
        self.pad.unplug()
        self._plugged = None

    def start(self, *options: str) -> None:
        with (self._folder / "said.txt").open("w") as said:
            own = self._bed.environment | {"XDG_STATE_HOME": str(self._folder)}
            self._process = warm_start.start(
                [sys.executable, "-m", "rune_tui", "pad", self._hub.endpoint, *options],
                environment=os.environ | own,
                stderr=said.fileno(),
            )

    def notify(self, number: int) -> None:
        assert self._process is not None
        self._process.send_signal(number)

    def end(self, number: int = signal.SIGTERM) -> int:
        assert self._process is not None
        self._process.send_signal(number)
        return exit_code(self._process, 15.0)

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        if self._plugged is not None:
            self.unplug()


@pytest.fixture
def desk(
    hub: HubProcess, bed: VirtualBed, tmp_path: Path, stack: ExitStack, console: ConsoleProcess
) -> Desk:
    """There, the pad is plugged in, nobody touches it, and the console has it."""
    opened = stack.enter_context(closing(Desk(hub, bed, tmp_path)))
    opened.plug()
    opened.start()
    opened.pad.send(report(), timeout=20.0)
    console.wait(lambda: plugged_in(console), 20.0, "the console does not take it")
    return opened


def test_whoever_sends_a_pad_is_told_who_uses_it(desk: Desk, console: ConsoleProcess) -> None:
    operator = getpass.getuser()
    used = f"used by the console of {operator}; connected"
    console.wait(lambda: used in desk.said, 10.0, "it is not said who uses it")
    desk.end()
    desk.start("--operator", "nobody")
    waits = f"waits for a console of nobody (there: {operator}); connected"
    console.wait(lambda: waits in desk.said, 10.0, "it is not said for whom it waits")


def plugged_in(console: ConsoleProcess) -> bool:
    """Whether the console shows the pad, where it is, and how old what it says is."""
    there = re.search(rf"{NAME} \(DirectInput mode\) at \S+: plugged", console.text)
    return bool(there and re.search(r"what it says is 0\.\d\d s old", console.text))


def times_to_stop(observer: Observer, since: float) -> tuple[float, float]:
    """How long after a moment the wheels were commanded to stand, and stood [s]."""

    def first(stands: Callable[[GroundTruth], bool]) -> float:
        times = [when for when, truth in observer.history if when > since and stands(truth)]
        return min(times, default=math.inf) - since

    def commanded() -> float:
        return first(lambda truth: truth.commanded_linear == 0.0)

    def at_rest() -> float:
        return first(lambda truth: abs(truth.linear) < STILL)

    observer.wait(lambda: math.isfinite(at_rest()), 5.0, "it drives on")
    return commanded(), at_rest()


def freeze(desk: Desk) -> None:
    desk.notify(signal.SIGSTOP)


def go_on(desk: Desk) -> None:
    desk.notify(signal.SIGCONT)


def kill(desk: Desk) -> None:
    desk.end(signal.SIGKILL)


def end_by_a_key(desk: Desk) -> None:
    assert desk.end(signal.SIGINT) == 0


@pytest.mark.parametrize(
    ("cause", "said", "mend"),
    [
        (freeze, "SILENT", go_on),
        (kill, "SILENT", Desk.start),
        (end_by_a_key, "ENDED there", Desk.start),
        (Desk.unplug, "UNPLUGGED there", Desk.plug),
    ],
    ids=["frozen", "killed", "ended", "unplugged"],
)
def test_whatever_ends_the_states_stops_the_robot_which_drives_again_from_neutral_only(
    cause: Callable[[Desk], None],
    said: str,
    mend: Callable[[Desk], None],
    desk: Desk,
    observer: Observer,
    console: ConsoleProcess,
) -> None:
    measured = []
    for _ in range(_TRIES):
        drive(desk.pad, observer, console)
        since = time.monotonic()
        cause(desk)
        measured.append(times_to_stop(observer, since))
        console.wait(lambda: f"pad {said}" in console.text, 5.0, "the console does not say it")
        mend(desk)
        desk.pad.send(report(y=0), timeout=20.0)
        desk.pad.send(report(x=129, y=0))
        console.wait(lambda: forward(console) == "+1.00", 20.0, f"not seen again: {desk.said}")
        expect_no_driving(observer)
        if measured[-1] < (COMMANDED_WITHIN_S, AT_REST_WITHIN_S):
            break
    commanded, at_rest = measured[-1]
    assert commanded < COMMANDED_WITHIN_S, measured
    assert at_rest < AT_REST_WITHIN_S, measured
    drive(desk.pad, observer, console)


def control(observer: Observer) -> ControlState:
    state: ControlState = observer.seen[CONTROL_STATE.name][-1][1]
    return state


def take_over(console: ConsoleProcess, operator: str, observer: Observer) -> None:
    console.type("t")

    def taken() -> bool:
        observer.client.listen(0.0)
        return control(observer).operator == operator

    # A console whose terminal does not answer counts a second press of a key later.
    console.wait(taken, 10.0, f"{operator} does not get control")


def expect_a_held_stick_drives_nothing(
    desk: Desk, console: ConsoleProcess, observer: Observer
) -> None:
    desk.pad.send(report(y=10))
    console.wait(lambda: forward(console) == "+0.90", 10.0, "it does not see the stick")
    expect_no_driving(observer)


@pytest.mark.soak
def test_of_two_consoles_that_use_one_pad_only_the_one_in_control_drives_and_from_neutral_on(
    desk: Desk, hub: HubProcess, console: ConsoleProcess, tmp_path: Path, stack: ExitStack
) -> None:
    observer = stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH, CONTROL_STATE)))
    alice, empty = console, stack.enter_context(closing(VirtualBed()))
    bob = stack.enter_context(console_at(hub, empty, tmp_path, "--operator", "bob"))
    bob.wait(lambda: plugged_in(bob), 20.0, "the other console does not take it")
    take_over(alice, getpass.getuser(), observer)
    drive(desk.pad, observer, alice)
    for console_now, operator in ((bob, "bob"), (alice, getpass.getuser())):
        take_over(console_now, operator, observer)
        expect_stop(observer)
        expect_a_held_stick_drives_nothing(desk, console_now, observer)
        drive(desk.pad, observer, console_now)
        assert control(observer).operator == operator
    # It is the owner's commands that drive: without them nothing does, though the pad says go on.
    alice.process.send_signal(signal.SIGSTOP)
    stack.callback(alice.process.send_signal, signal.SIGCONT)
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 2.0, "the other one drives")
    assert control(observer).operator == operator, "it stood only when control was lost"
    observer.wait(lambda: control(observer).operator != operator, 10.0, "it keeps control")
    expect_a_held_stick_drives_nothing(desk, bob, observer)
    drive(desk.pad, observer, bob)


def test_who_waits_for_a_hub_is_told_for_which(bed: VirtualBed) -> None:
    command = ["pad", f"127.0.0.1:{free_port()}"]
    with closing(ConsoleProcess(command, environment=bed.environment)) as sending:
        sending.wait(lambda: f"connecting to tcp://{command[1]}" in sending.text, 15.0, "no word")
        assert sending.wait_ended() == 3
