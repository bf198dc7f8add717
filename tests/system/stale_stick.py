"""The events at which a driven robot must stop, and what a robot with any body makes of them.

Each case is an event in real processes while a stick or a key drives the robot. Then the robot is
commanded to stand in time and comes to rest in time. It stays at rest, although the stick stays
deflected, until the stick was neutral and is deflected again. The commands and the motion are read
at the robot's body (see `recorded_robot`).
"""

from __future__ import annotations

import os
import signal
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import psutil
import pytest

from hub.gcm.navigation import STOP, Stop
from hub.ipc.client import Client
from tests.support.fake_hid import VirtualBed
from tests.support.wall_clock import WallClock
from tests.system.driven_robot import DrivenRobot
from tests.system.recorded_robot import Row
from tests.system.ssh_server import SshServer

STOPPED_S = 0.35
"""The robot is commanded to stand within this time after the event [s]."""
INSISTED_S = 0.6
"""A stick stays deflected for so long, in vain [s]."""
INSISTED_WITH_GAPS_S = 3.0
"""The same for a key of which some repeats come late [s]."""
_YEAR_S = 365 * 24 * 3600


@dataclass(frozen=True, kw_only=True)
class Scene:
    """What the cases are played with.

    Attributes:
        robot: It, and what drives it.
        ssh: The way to its hub, for consoles that take it.
        clock: The wall clock of hub and consoles.
    """

    robot: DrivenRobot
    ssh: SshServer
    clock: WallClock


Action = Callable[[Scene], object]


def nothing(scene: Scene) -> None:
    """All is as before, but for what the robot makes of it."""


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

    @property
    def id(self) -> str:
        """Its name in that of the test."""
        return self.name.replace(" ", "-")


def send_signal(number: signal.Signals) -> Action:
    """Have the operator's console get it."""
    return lambda scene: scene.robot.console.process.send_signal(number)


def type_keys(keys: str) -> Action:
    """Press keys at the operator's console."""
    return lambda scene: scene.robot.console.type(keys)


def start_again(scene: Scene) -> None:
    """The operator opens another console."""
    scene.robot.finger.lift()
    scene.robot.start_console()
    linked(scene)


def awake(scene: Scene) -> None:
    """A console that was stopped goes on after a while."""
    time.sleep(scene.robot.chance.uniform(0.0, 1.0))
    scene.robot.console.process.send_signal(signal.SIGCONT)


def kill_hub(scene: Scene) -> None:
    scene.robot.hub.process.kill()


def another_hub(scene: Scene) -> None:
    scene.robot.start_hub()
    linked(scene)


def navigation(scene: Scene) -> list[int]:
    """The processes of navigation; one, except while it starts again."""
    modules = psutil.Process(scene.robot.hub.process.pid).children(recursive=True)
    found = []
    for each in modules:
        with suppress(psutil.NoSuchProcess):
            found += [each.pid] * ("hub.modules.navigation" in each.cmdline())
    return found


def signal_navigation(number: signal.Signals) -> Action:
    def sent(scene: Scene) -> float:
        (pid,) = navigation(scene)
        struck = time.monotonic()
        os.kill(pid, number)
        return struck

    return sent


def another_navigation(scene: Scene) -> None:
    scene.robot.wait(lambda: len(navigation(scene)) == 1, "navigation does not start again")


def navigation_goes_on(scene: Scene) -> None:
    """It was silent for a while; the hub may have ended it."""
    scene.robot.watch(scene.robot.chance.uniform(0.0, 1.0))
    for pid in navigation(scene):
        os.kill(pid, signal.SIGCONT)
    another_navigation(scene)


def linked(scene: Scene) -> None:
    console = scene.robot.console
    scene.robot.wait(lambda: "linked" in console.text, "the console finds no way back")


def ssh_goes_on(scene: Scene) -> None:
    """The network carries again what it has carried not, all that was sent meanwhile first."""
    scene.robot.watch(scene.robot.chance.choice((0.3, 1.0, 3.0)))
    signal_ssh(signal.SIGCONT)(scene)
    linked(scene)


def signal_ssh(number: signal.Signals) -> Action:
    def sent(scene: Scene) -> None:
        for pid in scene.ssh.running():
            os.kill(pid, number)

    return sent


def step_clocks(scene: Scene) -> float:
    """The clocks of hub and console step; that alone stops nobody. Then the console is stopped."""
    robot = scene.robot
    scene.clock.step(robot.chance.choice((3600, -3600, _YEAR_S, -_YEAR_S)))
    stepped = time.monotonic()
    robot.watch(0.5)
    assert robot.record.first(stepped, lambda row: not row.commanded) is None, (
        "the step stops the robot"
    )
    struck = time.monotonic()
    robot.console.process.send_signal(signal.SIGSTOP)
    scene.clock.step(0)
    return struck


def stop_from_elsewhere(scene: Scene) -> float:
    with closing(Client("passer-by", scene.robot.hub.endpoint)) as client:
        client.wait_connected(5.0)
        client.define(STOP)
        client.wait_defined(5.0)
        struck = time.monotonic()
        client.publish(STOP, Stop(reason="a test"))
        client.wait_published(5.0)
    return struck


def release_dead_man(scene: Scene) -> None:
    scene.robot.shake(shoulder=False)


def replug(scene: Scene) -> None:
    scene.robot.plug()
    found_deflected(scene)


def found_deflected(scene: Scene) -> None:
    """The console has the pad again, and wants it to be let go of."""
    scene.robot.shake()
    scene.robot.wait(lambda: "LET GO OF" in scene.robot.console.text, "the pad is not found")


def signal_agent(number: signal.Signals) -> Action:
    """Have the operator's `rune pad` get it."""

    def sent(scene: Scene) -> None:
        assert scene.robot.agent is not None
        scene.robot.agent.send_signal(number)

    return sent


def agent_awake(scene: Scene) -> None:
    """A pad that was silent speaks again after a while, all that it says is new."""
    scene.robot.watch(scene.robot.chance.choice((0.0, 0.3, 1.0, 4.0)))
    signal_agent(signal.SIGCONT)(scene)
    found_deflected(scene)


def another_agent(scene: Scene) -> None:
    scene.robot.start_agent()
    found_deflected(scene)


def agents_ssh_goes_on(scene: Scene) -> None:
    """All that was sent meanwhile comes first, too late."""
    scene.robot.watch(scene.robot.chance.choice((0.3, 1.0, 3.0)))
    signal_ssh(signal.SIGCONT)(scene)
    found_deflected(scene)


def rival_takes_over(scene: Scene) -> None:
    rival = scene.robot.start_rival()
    rival.type("k")


def rival_gives_up(scene: Scene) -> None:
    rival = scene.robot.start_rival()
    scene.robot.wait(lambda: "you have control" in rival.text, "nothing was taken over")
    rival.type("c")
    scene.robot.wait(lambda: "nobody has control" in rival.text, "control was not given up")


def rival_pushes(scene: Scene) -> None:
    """Somebody else holds a key all the time."""
    rival = scene.robot.start_rival()
    scene.robot.finger.press(lambda: rival.terminal, "s")


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
SUSPENDED = Case(name="suspended", strike=send_signal(signal.SIGTSTP), mend=awake)
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
    strike=signal_navigation(signal.SIGKILL),
    mend=another_navigation,
    covered=True,
)
NAVIGATION_FROZEN = Case(
    name="navigation frozen",
    strike=signal_navigation(signal.SIGSTOP),
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
                each.stopped <= STOPPED_S + each.away for each in reactions
            ),
            "at rest in time": all(each.rest <= rest_s + each.away for each in reactions),
        },
    )
