"""How fast the demo is there, how fast a key reaches the wheels, how fast the robot stops.

Real processes: a hub with a simulated robot in an empty hall, a console on a pseudo-terminal.
"""

from __future__ import annotations

import os
import resource
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, closing
from pathlib import Path

from benchmarks.figures import report, say
from tests.support.waiting import until
from tests.system.conftest import LAYOUT
from tests.system.harness import ConsoleProcess, HubProcess, Observer, family

ROUNDS = 5
PRESSES = 20
STILL = 0.005
REPORTS_RELEASES = "\x1b[?27u"
"""What a terminal with the kitty keyboard protocol answers."""
W_DOWN, W_UP = "\x1b[119;;119u", "\x1b[119;1:3u"
SPACE_DOWN, SPACE_UP = "\x1b[32;;32u", "\x1b[32;1:3u"


def first_picture() -> None:
    """From the start of `rune demo` to the camera image on the screen."""
    times = []
    for _ in range(ROUNDS):
        with closing(ConsoleProcess(["demo"], columns=120, rows=40)) as console:
            console.wait_for_picture()
            times.append(time.monotonic() - console.started)
            console.type("q")
            console.wait_ended()
    report("start.first_picture_s", statistics.median(times), "s", bar=1.2)


def hub_ready() -> None:
    """From the start of `rune-hub run` until all modules run, and the processor time until then."""
    figures = {}
    for how, options in (("forked", ()), ("spawned", ("--spawn",))):
        times, processor = [], []
        for _ in range(ROUNDS):
            with tempfile.TemporaryDirectory() as folder:
                started = time.monotonic()
                with closing(HubProcess(Path(folder), options=options)) as hub:
                    times.append(time.monotonic() - started)
                    spent = [each.cpu_times() for each in family(hub.process.pid)]
                    processor.append(sum(sum(each[:4]) for each in spent))
        figures[how] = (statistics.median(times), statistics.median(processor))
    (ready, cpu), (ready_spawned, cpu_spawned) = figures["forked"], figures["spawned"]
    report("start.hub_ready_s", ready, "s", bar=0.8, note=f"spawned: {ready_spawned:.2f} s")
    report(
        "start.cpu_s",
        cpu,
        "s",
        bar=0.6 * cpu_spawned,
        note=f"until then, all processes; the bar is 60 % of spawned modules, {cpu_spawned:.2f} s",
    )


def help_text() -> None:
    """The whole process of `rune --help`."""
    rune = shutil.which("rune", path=Path(sys.executable).parent)
    times = []
    for _ in range(10):
        started = time.monotonic()
        subprocess.run([rune or "rune", "--help"], check=True, stdout=subprocess.DEVNULL)
        times.append(time.monotonic() - started)
    report("start.help_s", statistics.median(times), "s", bar=0.4)


def imports() -> None:
    """Processor time of an import of the console, beside that of its libraries alone."""
    codes = {
        "console": "import rune_tui.app",
        "libraries": "import lxml.etree, numpy, PIL.ImageDraw, textual.app, zmq",
    }
    times: dict[str, list[float]] = {name: [] for name in codes}
    for _ in range(2 * ROUNDS):
        for name, code in codes.items():
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, "-c", code], check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = (after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime)
            times[name].append(sum(spent))
    console, libraries = (statistics.median(each) for each in times.values())
    report("start.import_cpu_s", console, "s", bar=0.4, note=f"the libraries: {libraries:.2f} s")


class Drive:
    """A hub, an observer of ground truth and a console, for one measurement."""

    def __init__(self, stack: ExitStack) -> None:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        self.hub = stack.enter_context(closing(HubProcess(folder)))
        self.observer = stack.enter_context(closing(Observer(self.hub.endpoint)))
        layout = folder / "layout.xml"
        layout.write_text(LAYOUT.format(hub=self.hub.endpoint))
        self.console = stack.enter_context(closing(ConsoleProcess(["run", str(layout)])))
        self.console.wait_for_picture()
        self.console.wait(lambda: "STANDING" in self.console.text, 10.0)

    def serve(self) -> None:
        """Let the console write and the observer listen."""
        self.console.pump(0.002)
        self.observer.client.listen(0.002)

    def serve_for(self, seconds: float) -> None:
        """Serve for a while [s]."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.serve()

    def at_speed(self) -> None:
        """Hold W until the robot drives at full speed."""

        def push() -> None:
            self.console.type("w")
            self.serve_for(0.033)

        until(lambda: self.observer.truth.linear > 0.49, 10.0, meanwhile=push)


def key_to_wheel() -> None:
    """From a key's byte on the terminal to the first change of the true velocity."""
    times = []
    with ExitStack() as stack:
        drive = Drive(stack)
        for press in range(PRESSES):
            until(
                lambda: (
                    abs(drive.observer.truth.linear) < 1e-4
                    and abs(drive.observer.truth.angular) < 1e-4
                ),
                10.0,
                meanwhile=drive.serve,
            )
            drive.serve_for(0.7 + 0.013 * press)  # another phase of every timer each time
            drive.observer.history.clear()
            pressed = time.monotonic()
            drive.console.type("w" if press % 2 else "s")
            until(
                lambda: any(abs(truth.linear) > 1e-4 for _, truth in drive.observer.history),
                5.0,
                meanwhile=drive.serve,
            )
            moved = next(t for t, truth in drive.observer.history if abs(truth.linear) > 1e-4)
            times.append(moved - pressed)
    report(
        "start.key_to_wheel_ms",
        statistics.median(times) * 1e3,
        "ms",
        bar=100,
        note=f"the driver reports every 3 ms after the command; largest {max(times) * 1e3:.0f} ms",
    )


def stop_to_wheel() -> None:
    """From the bytes of the stop key, while W is held, to wheels commanded to zero."""
    times = []
    with ExitStack() as stack:
        drive = Drive(stack)
        history = drive.observer.history
        drive.console.type(REPORTS_RELEASES)
        drive.serve_for(0.5)
        for press in range(PRESSES):
            drive.console.type(W_DOWN)
            until(lambda: drive.observer.truth.linear > 0.2, 10.0, meanwhile=drive.serve)
            drive.serve_for(0.013 * (press % 5))  # another phase of every timer each time
            history.clear()
            pressed = time.monotonic()
            drive.console.type(SPACE_DOWN)
            until(
                lambda: any(s.commanded_linear == 0.0 for _, s in history),
                5.0,
                meanwhile=drive.serve,
            )
            times.append(next(t for t, s in history if s.commanded_linear == 0.0) - pressed)
            drive.console.type(SPACE_UP + W_UP)
            drive.serve_for(1.0)
    note = f"largest {max(times) * 1e3:.0f} ms"
    report("start.stop_to_wheel_ms", statistics.median(times) * 1e3, "ms", bar=15, note=note)


def stop_after_kill(victim: str, name: str) -> None:
    """From kill -9 at 0.5 m/s to wheels commanded to zero, and to rest."""
    commanded, rest = [], []
    for _ in range(ROUNDS):
        with ExitStack() as stack:
            drive = Drive(stack)
            drive.at_speed()
            pid = drive.console.process.pid if victim == "console" else drive.hub.pids[victim]
            os.kill(pid, signal.SIGKILL)
            killed = time.monotonic()
            drive.observer.wait(lambda d=drive: abs(d.observer.history[-1][1].linear) < STILL, 5.0)
            after = [(t, truth) for t, truth in drive.observer.history if t >= killed]
            commanded.append(next(t for t, s in after if s.commanded_linear == 0.0) - killed)
            rest.append(next(t for t, s in after if abs(s.linear) < STILL) - killed)
    report(f"start.stop_after_{name}_kill_ms", max(commanded) * 1e3, "ms", bar=350, note="largest")
    report(f"start.rest_after_{name}_kill_ms", max(rest) * 1e3, "ms", bar=700, note="largest")


def main() -> None:
    """All figures."""
    say("hub ready")
    hub_ready()
    say("first picture, help")
    first_picture()
    help_text()
    imports()
    say("key to wheel")
    key_to_wheel()
    say("stops")
    stop_to_wheel()
    stop_after_kill("console", "console")
    stop_after_kill("navigation", "navigation")


if __name__ == "__main__":
    main()
