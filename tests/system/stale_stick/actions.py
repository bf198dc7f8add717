"""What happens to a driven robot, its operator and its hub in the cases of the stale stick."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass

import psutil

from hub.gcm.navigation import STOP, Stop
from hub.ipc.client import Client
from tests.support.wall_clock import WallClock
from tests.system.driven_robot import DrivenRobot
from tests.system.ssh_server import SshServer

_YEAR_S = 365 * 24 * 3600
_STEPS = 5
"""The wall clock may step so often until the robot drives on."""
_DRIVEN_S = 0.5
"""The robot drives on for so long after a step of the wall clock, by its own rows [s]."""


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


def resumed(scene: Scene) -> None:
    """A console that suspends itself goes on after a while; a shell waits until it has stopped."""
    process = psutil.Process(scene.robot.console.process.pid)
    stopped = psutil.STATUS_STOPPED
    scene.robot.wait(lambda: process.status() == stopped, "the console does not stop")
    awake(scene)


def kill_hub(scene: Scene) -> None:
    scene.robot.hub.process.kill()


def another_hub(scene: Scene) -> None:
    scene.robot.start_hub()
    linked(scene)


def module(scene: Scene, name: str) -> list[int]:
    """The processes of a module of the hub; one, except while it starts again."""
    modules = psutil.Process(scene.robot.hub.process.pid).children(recursive=True)
    found = []
    for each in modules:
        with suppress(psutil.NoSuchProcess):
            found += [each.pid] * (f"hub.modules.{name}" in each.cmdline())
    return found


def signal_module(name: str, number: signal.Signals) -> Action:
    def sent(scene: Scene) -> float:
        (pid,) = module(scene, name)
        struck = time.monotonic()
        os.kill(pid, number)
        return struck

    return sent


def started_again(name: str) -> Action:
    def started(scene: Scene) -> None:
        scene.robot.wait(lambda: len(module(scene, name)) == 1, f"{name} does not start again")

    return started


def navigation_goes_on(scene: Scene) -> None:
    """It was silent for a while; the hub may have ended it."""
    scene.robot.watch(scene.robot.chance.uniform(0.0, 1.0))
    for pid in module(scene, "navigation"):
        os.kill(pid, signal.SIGCONT)
    started_again("navigation")(scene)


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
    """The clocks of hub and console step; that alone stops nobody. Then the console is stopped.

    On a busy machine, commands can fall silent, which stops the robot too. But the step that stops
    it does so each time, so the robot may stop at some steps, but not at all of them.
    """
    robot = scene.robot
    seconds = robot.chance.choice((3600, -3600, _YEAR_S, -_YEAR_S))
    for _ in range(_STEPS):
        if not stopped_by_step(scene, seconds):
            break
        scene.clock.step(0)
        robot.drive(robot.push, robot.neutral)
    else:
        message = f"each of {_STEPS} steps by {seconds} s stops the robot"
        raise AssertionError(message)
    struck = time.monotonic()
    robot.console.process.send_signal(signal.SIGSTOP)
    scene.clock.step(0)
    return struck


def stopped_by_step(scene: Scene, seconds: int) -> bool:
    """Whether the robot is commanded to stand soon after the clocks step by so much [s]."""
    robot = scene.robot
    scene.clock.step(seconds)
    stepped = time.monotonic()
    robot.wait(lambda: robot.record.now.at >= stepped + _DRIVEN_S, "the robot writes no more")
    return robot.record.first(stepped, lambda row: not row.commanded) is not None


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


LINK_BACK_S = 3.0
"""The stick stays deflected for this time after a link is back [s]."""


def rival_pushes(scene: Scene) -> None:
    """Somebody else holds a key all the time."""
    rival = scene.robot.start_rival()
    scene.robot.finger.press(lambda: rival.terminal, "s")


def insist(scene: Scene, seconds: float = LINK_BACK_S) -> None:
    """Keep the stick deflected for a while [s]."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        scene.robot.insist()
        scene.robot.pump()
