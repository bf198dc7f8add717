"""The events at which a driven robot must stop, and what a robot with any body makes of them.

Each case is an event in real processes while a stick or a key drives the robot. Then the robot is
commanded to stand in time and comes to rest in time. It stays at rest, although the stick stays
deflected, until the stick was neutral and is deflected again. The commands and the motion are read
at the robot's body (see `recorded_robot`).
"""

from __future__ import annotations

import signal
import statistics
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from tests.support.fake_hid import VirtualBed
from tests.support.wall_clock import WallClock
from tests.system.driven_robot import DrivenRobot
from tests.system.recorded_robot import Row
from tests.system.ssh_server import SshServer
from tests.system.stale_stick.actions import (
    Action,
    Scene,
    agent_awake,
    agents_ssh_goes_on,
    another_agent,
    another_hub,
    awake,
    kill_hub,
    linked,
    navigation_goes_on,
    nothing,
    release_dead_man,
    replug,
    resumed,
    rival_gives_up,
    rival_pushes,
    rival_takes_over,
    send_signal,
    signal_agent,
    signal_module,
    signal_ssh,
    ssh_goes_on,
    start_again,
    started_again,
    step_clocks,
    stop_from_elsewhere,
    type_keys,
)

STOPPED_S = 0.35
"""The robot is commanded to stand within this time after the event [s]."""
INSISTED_S = 0.6
"""A stick stays deflected for so long, in vain [s]."""
INSISTED_WITH_GAPS_S = 3.0
"""The same for a key of which some repeats come late [s]."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """An event.

    Attributes:
        name: What happens.
        strike: Does it, while the robot is driven; it may return when [s].
        mend: Makes it good again; whoever drove still does as if nothing had happened.
        press: What drives the robot; by default a stick.
        ends: Whether the body's simulation ends with it, so that only wheels come to rest.
        elsewhere: Whether the pad is at another machine than the console, with `rune pad`.
        far: Whether the way to the hub is ssh for the machine that the pad is at.
        before: What has to be prepared.
        covered: Whether the pure tests of the stale stick and other tests of real processes show
            it in `make test`; here, only `make soak` plays it.
        stopped_s: The robot is commanded to stand within this time after the event [s].
    """

    name: str
    strike: Action
    mend: Action = nothing
    press: Callable[[DrivenRobot], None] = DrivenRobot.push
    ends: bool = False
    elsewhere: bool = False
    far: bool = False
    before: Action = nothing
    covered: bool = False
    stopped_s: float = STOPPED_S

    @property
    def id(self) -> str:
        """Its name in that of the test."""
        return self.name.replace(" ", "-")


def with_a_key_held(case: Case) -> Case:
    """The same while a key drives, not a stick."""
    name = f"{case.name} with a key held"
    return replace(case, name=name, press=DrivenRobot.hold_key, covered=True)


def with_gaps(case: Case) -> Case:
    """The same while a key drives, and from then on some of its repeats come late."""

    def strike(scene: Scene) -> object:
        scene.robot.finger.gaps = True
        return case.strike(scene)

    held = with_a_key_held(case)
    return replace(held, name=f"{held.name} and gaps", strike=strike)


ASLEEP = Case(name="asleep", strike=send_signal(signal.SIGSTOP), mend=awake, covered=True)
SUSPENDED = Case(name="suspended", strike=send_signal(signal.SIGTSTP), mend=resumed)
STOPPED = Case(name="stopped from elsewhere", strike=stop_from_elsewhere, covered=True)
KILLED = Case(name="killed", strike=send_signal(signal.SIGKILL), mend=start_again, covered=True)
UNPLUGGED = Case(name="unplugged", strike=lambda scene: scene.robot.unplug(), mend=replug)
RELEASED = Case(
    name="key released",
    press=DrivenRobot.hold_key,
    strike=lambda scene: scene.robot.finger.lift(),
)
HUB_KILLED = Case(name="hub killed", strike=kill_hub, mend=another_hub, ends=True)
NETWORK_CUT = Case(
    name="network cut", far=True, strike=signal_ssh(signal.SIGSTOP), mend=ssh_goes_on
)
NAVIGATION_KILLED = Case(
    name="navigation killed",
    strike=signal_module("navigation", signal.SIGKILL),
    mend=started_again("navigation"),
    covered=True,
)
NAVIGATION_FROZEN = Case(
    name="navigation frozen",
    strike=signal_module("navigation", signal.SIGSTOP),
    mend=navigation_goes_on,
    covered=True,
)
CASES = (
    UNPLUGGED,
    Case(
        name="another window in front",
        strike=type_keys("\x1b[O"),
        mend=type_keys("\x1b[I"),
        covered=True,
    ),
    Case(name="help opened", strike=type_keys("?"), mend=type_keys("\x1b")),
    Case(name="text pasted", strike=type_keys("\x1b[200~text\x1b[201~")),
    Case(
        name="dead-man button let go",
        press=lambda robot: robot.push(guarded=True),
        strike=release_dead_man,
        mend=lambda scene: scene.robot.shake(shoulder=True),
    ),
    STOPPED,
    with_gaps(STOPPED),
    Case(name="stopped by key", strike=type_keys(" "), covered=True),
    ASLEEP,
    with_a_key_held(ASLEEP),
    SUSPENDED,
    with_gaps(SUSPENDED),
    Case(name="wall clocks step", strike=step_clocks, mend=awake),
    Case(
        name="taken over",
        before=lambda scene: scene.robot.start_rival(),
        strike=rival_takes_over,
        mend=rival_gives_up,
        covered=True,
    ),
    Case(
        name="two push and control is given up",
        before=rival_pushes,
        strike=type_keys("c"),
        covered=True,
    ),
    KILLED,
    with_a_key_held(KILLED),
    Case(name="ended", strike=send_signal(signal.SIGTERM), mend=start_again, covered=True),
    Case(
        name="terminal closed", strike=lambda scene: scene.robot.console.hang_up(), mend=start_again
    ),
    HUB_KILLED,
    NETWORK_CUT,
    NAVIGATION_KILLED,
    NAVIGATION_FROZEN,
    Case(
        name="ssh dropped",
        far=True,
        strike=signal_ssh(signal.SIGKILL),
        mend=linked,
        covered=True,
    ),
    Case(
        name="pad agent silent",
        elsewhere=True,
        covered=True,
        strike=signal_agent(signal.SIGSTOP),
        mend=agent_awake,
    ),
    Case(
        name="pad agent killed",
        elsewhere=True,
        covered=True,
        strike=signal_agent(signal.SIGKILL),
        mend=another_agent,
    ),
    Case(
        name="pad agent unplugged",
        elsewhere=True,
        covered=True,
        strike=lambda scene: scene.robot.unplug(),
        mend=replug,
    ),
    Case(
        name="pad agent cut off",
        elsewhere=True,
        covered=True,
        far=True,
        strike=signal_ssh(signal.SIGSTOP),
        mend=agents_ssh_goes_on,
    ),
)


@contextmanager
def playing(folder: Path, body: str) -> Iterator[Scene]:
    """A scene with a robot of this body."""
    with ExitStack() as stack:
        patch = stack.enter_context(pytest.MonkeyPatch.context())
        patch.setenv("XDG_STATE_HOME", str(folder))
        clock = WallClock(folder)
        ssh = stack.enter_context(closing(SshServer(folder / "ssh")))
        bed = stack.enter_context(closing(VirtualBed()))
        made = DrivenRobot(folder, bed, body=body, clock=clock.environment, programs=ssh.path)
        robot = stack.enter_context(closing(made))
        yield Scene(robot=robot, ssh=ssh, clock=clock)


def once_and_often(
    quick: Mapping[str, Case], bodies: Iterable[str], cases: Sequence[Case], repetitions: int
) -> list[Any]:
    """Parameters of a test: scene, body, case and count; in soak each case of each body.

    Args:
        quick: The case of each body that is played once in `make test`.
        bodies: All bodies.
        cases: All cases.
        repetitions: How often soak plays each.
    """
    once = [
        pytest.param(body, body, case, 1, id=f"{body}-{case.id}") for body, case in quick.items()
    ]
    often = [
        pytest.param(
            body, body, case, repetitions, id=f"{body}-often-{case.id}", marks=pytest.mark.soak
        )
        for body in bodies
        for case in cases
    ]
    return once + often


@dataclass(frozen=True, kw_only=True)
class Reaction:
    """What the robot made of an event.

    Attributes:
        stopped: When it was commanded to stand, after the event [s].
        rest: When it was at rest, after the event [s].
        away: For how long the driver's process was held up meanwhile [s].
    """

    stopped: float
    rest: float
    away: float


def stops(scene: Scene, case: Case, *, rolls: bool = True) -> Reaction:
    """Drive, have the event happen, and keep the stick deflected in vain.

    Args:
        scene: The robot and its console.
        case: The event.
        rolls: Whether it also rolls out where the simulation of its body ends.
    """
    robot, record = scene.robot, scene.robot.record

    def at_rest(row: Row) -> bool:
        return not row.commanded and (not record.moves(row) or (case.ends and not rolls))

    drive(scene, case)
    struck = time.monotonic()
    returned = case.strike(scene)
    struck = returned if isinstance(returned, float) else struck
    robot.wait(lambda: record.first(struck, at_rest), "it drives on")
    stopped = record.first(struck, lambda row: not row.commanded)
    rest = record.first(struck, at_rest)
    assert stopped is not None
    assert rest is not None
    case.mend(scene)
    end = time.monotonic() + (INSISTED_WITH_GAPS_S if robot.finger.gaps else INSISTED_S)
    while time.monotonic() < end:
        robot.insist()
        robot.pump()
    moved = record.first(struck + stopped, lambda row: row.commanded)
    assert moved is None, f"{moved:.3f} s after the event it drives with what was held before"
    return Reaction(stopped=stopped, rest=rest, away=record.away(struck, struck + rest))


def drive(scene: Scene, case: Case) -> None:
    """Drive the robot from neutral."""
    way = ("--ssh", scene.ssh.target) if case.far else ()
    scene.robot.want_operator(*way, elsewhere=case.elsewhere)

    def let_go() -> None:
        scene.robot.neutral()
        case.before(scene)

    scene.robot.drive(lambda: case.press(scene.robot), let_go)


def play(
    scene: Scene,
    case: Case,
    count: int,
    rest_s: float,
    tell: Callable[..., None],
    *,
    rolls: bool = True,
) -> None:
    """Play a case several times, and then drive from neutral.

    Args:
        scene: The robot and its console.
        case: The event.
        count: How often; only for more than once the times count, which other tests lengthen.
        rest_s: Longest time until rest [s].
        tell: Writes the figures.
        rolls: As of `stops`.
    """
    reactions = [stops(scene, case, rolls=rolls) for _ in range(count)]
    drive(scene, case)
    scene.robot.neutral()
    if count == 1:
        return
    spread = {
        "stopped_s": [each.stopped for each in reactions],
        "rest_s": [each.rest for each in reactions],
        "away_s": [each.away for each in reactions],
    }
    tell(
        repetitions=count,
        **{
            name: {"median": round(statistics.median(each), 3), "largest": round(max(each), 3)}
            for name, each in spread.items()
        },
        bars={
            "commanded to stand in time": all(
                each.stopped <= case.stopped_s + each.away for each in reactions
            ),
            "at rest in time": all(each.rest <= rest_s + each.away for each in reactions),
        },
    )
