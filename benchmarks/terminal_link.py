"""Pictures over thin links: from the robot's camera to the console, and on to its terminal.

What lies behind the console, slow terminals and ssh to them, is in `benchmarks.terminal_far`. Here
the hub, its modules, the simulated camera and the console's link are the real ones; between them
is `tests.support.thin_link`, a TCP relay with one queue a direction. The console's clock is two
hours ahead of the robot's, so that ages are measured as between two machines.
"""

from __future__ import annotations

import math
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks import terminal_far
from benchmarks.figures import report, say
from hub.gcm import navigation
from hub.gcm.geometry import TwistStamped
from rune_tui.layout.spec import RobotSpec
from rune_tui.link.hub_tunnel import tunnel_to
from rune_tui.link.robot_link import RobotLink
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.robot_state import RobotState
from rune_tui.startup.opening import open_layout
from tests.support.thin_link import ADDRESS, ThinLink
from tests.support.waiting import until
from tests.system.harness import ConsoleProcess, HubProcess
from tests.system.ssh_server import SshServer, missing

AHEAD_S = 7200.0
DRAW_S = 1.0 / 30.0
COMMAND_S = 1.0 / 20.0
SETTLE_S, SECONDS = 10.0, 30.0
SIZE = (160, 96)
NEUTRAL = TwistStamped.planar(0.0, 0.0)
GOING = {navigation.MotionState.STANDING, navigation.MotionState.MOVING}
TURN = TwistStamped.planar(0.0, 0.4)
LAYOUT = """<rune>
  <robot name="magellan">
    <capability name="VIS_VID" interval_ms="60"/>
    <capability name="NAV_STATE"/>
    <capability name="NAV_MOVE"/>
  </robot>
  <view xsize="160" ysize="96">
    <viewport name="camera" robot="magellan" xpos="0" ypos="0" xsize="160" ysize="96">
      <visualizer function="visualizeCameraImage" message="GCM_Common_Image"/>
      <widget handler="widgetSetSpeed"><event key="a" control="rotate"/></widget>
    </viewport>
    <viewport name="status" robot="magellan" xpos="0" ypos="94" xsize="160" ysize="2">
      <visualizer function="visualizeStatus" message="GCM_RobotState"/>
    </viewport>
  </view>
</rune>
"""


@dataclass(frozen=True, kw_only=True)
class Seen:
    """One picture as it was shown.

    Attributes:
        age: By the clock that camera and console really have in common [s].
        shown: By the console [s].
        state: Of the robot's state then, as the console tells [s].
    """

    age: float
    shown: float
    state: float


@contextmanager
def hub() -> Iterator[HubProcess]:
    with tempfile.TemporaryDirectory() as folder:
        running = HubProcess(Path(folder), arena="yellow", options=("--listen", "0"))
        with closing(running):
            yield running


def robot() -> RobotSpec:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.xml"
        path.write_text(LAYOUT)
        (spec,) = open_layout(path).robots
    return spec


def clock() -> float:
    return time.monotonic() + AHEAD_S


def drawn(link: RobotLink, seconds: float) -> tuple[list[Seen], RobotState]:
    """The pictures that a console shows, which turns the robot on its place all the while.

    Where the robot has stopped because commands fell silent, it drives on from neutral only.
    """
    seen: list[Seen] = []
    end, number, due = time.monotonic() + seconds, 0, 0.0
    while time.monotonic() < end:
        time.sleep(DRAW_S)
        link.attend()
        if time.monotonic() >= due:
            due = time.monotonic() + COMMAND_S
            known = link.state.navigation
            halted = known is None or known.value.motion not in GOING
            link.send(navigation.VELOCITY_COMMAND, NEUTRAL if halted else TURN)
        picture = link.state.picture
        if picture is not None and picture.number != number:
            number = picture.number
            link.shown(number)
            age = time.time() - picture.value.camera.stamp
            navigation_state, now = link.state.navigation, clock()
            state = navigation_state.age(now) if navigation_state else math.inf
            seen.append(Seen(age=age, shown=picture.age(now), state=state))
    return seen, link.state


def watched(link: RobotLink) -> tuple[list[Seen], RobotState]:
    """What a console shows once the link is known."""
    link.start()
    with closing(link):
        link.want_pictures({"": PictureNeed(size=SIZE)})
        until(lambda: link.state.picture is not None, 30.0, lambda: repr(link.state.link))
        drawn(link, SETTLE_S)
        seen, state = drawn(link, SECONDS)
    if state.navigation is None or not state.navigation.value.angular:
        say("the robot does not turn; the figures are those of a picture that stands still")
    return seen, state


def report_hub_link(name: str, rate: float, bar_fps: float) -> None:
    say(f"pictures of {SIZE[0]}x{SIZE[1]} over {name}")
    with hub() as running, closing(ThinLink(running.listening["tcp"], rate=rate)) as thin:
        seen, state = watched(RobotLink(robot(), thin.endpoint, near=False, clock=clock))
    flow = state.link.pictures
    asked = f"{flow.width_px}x{flow.height_px} {flow.coding.name} {flow.quality}" if flow else ""
    note = f"relay of {rate:g} bit/s, 20 ms each way, 64 kB; the robot turns; at the end {asked}"
    ages = sorted(each.age for each in seen)
    wrong = statistics.median(abs(each.shown - each.age) for each in seen)
    states = statistics.median(each.state for each in seen)
    fps = len(seen) / SECONDS
    report(f"link.hub_{name}_fps", fps, "1/s", bar=bar_fps, better="higher", note=note)
    report(f"link.hub_{name}_age_median_ms", 1e3 * statistics.median(ages), "ms", bar=400.0)
    report(f"link.hub_{name}_age_max_ms", 1e3 * ages[-1], "ms")
    error_note = "what the console tells, with a clock of its own, less what is true; median"
    report(f"link.hub_{name}_age_error_ms", 1e3 * wrong, "ms", note=error_note)
    report(f"link.hub_{name}_state_age_median_ms", 1e3 * states, "ms", note="GCM_RobotState")
    report(f"link.hub_{name}_kB_per_s", state.link.bytes_per_s / 1e3, "kB/s", note="pictures")


def report_ssh() -> None:
    """The same through a real ssh and sshd, whose connection the relay carries."""
    say("pictures through ssh over 1 Mbit/s")
    note = "relay of 1e+06 bit/s, 20 ms each way, around ssh -L to a real sshd"
    if why := missing():
        report("link.ssh_fps", None, "1/s", better="higher", note=why)
        report("link.ssh_age_median_ms", None, "ms", bar=400.0, note=why)
        return
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        server = stack.enter_context(closing(SshServer(Path(folder) / "ssh")))
        os.environ["PATH"] = f"{server.path}:{os.environ['PATH']}"
        stack.enter_context(closing(ThinLink(f":{server.port}", rate=1e6, ports=1)))
        running = stack.enter_context(hub())
        target = server.target.replace("127.0.0.1", ADDRESS)
        tunnel = stack.enter_context(closing(tunnel_to(target, running.endpoint)))
        tunnel.open()
        seen, _ = watched(RobotLink(robot(), tunnel.endpoint, near=False, way=tunnel, clock=clock))
    report("link.ssh_fps", len(seen) / SECONDS, "1/s", better="higher", note=note)
    age = 1e3 * statistics.median(each.age for each in seen)
    report("link.ssh_age_median_ms", age, "ms", bar=400.0, note=note)


def report_console_there() -> None:
    """What the terminal gets of a console that runs on the robot, on a way without limits."""
    say("bytes for the terminal of a console on the robot")
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        running = stack.enter_context(hub())
        layout = Path(folder) / "layout.xml"
        layout.write_text(LAYOUT)
        arguments = ["run", "--hub", running.endpoint, str(layout)]
        console = stack.enter_context(closing(ConsoleProcess(arguments, columns=160, rows=48)))
        console.wait_for_picture()
        console.hold_until("a", lambda: "MOVING" in console.text)
        before = console.output_bytes
        console.hold("a", 10.0)
        amount = (console.output_bytes - before) / 10.0 / 1e3
    note = "160x48 cells, 16 pictures a second wanted; the robot turns"
    report("link.console_on_robot_kB_per_s", amount, "kB/s", note=note)


FIGURES: dict[str, Callable[[], None]] = {
    "hub_1Mbit": partial(report_hub_link, "1Mbit", 1e6, 15.0),
    "hub_64kbit": partial(report_hub_link, "64kbit", 64e3, 3.0),
    "ssh": report_ssh,
    "console_on_robot": report_console_there,
    **terminal_far.FIGURES,
}


def main() -> None:
    """All figures, or those that are named."""
    for name in sys.argv[1:] or FIGURES:
        FIGURES[name]()


if __name__ == "__main__":
    main()
