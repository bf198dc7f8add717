"""A robot in a fleet of one router, for consoles that join it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil

from hub.gcm import navigation
from hub.gcm.control import CONTROL_STATE
from hub.gcm.navigation import NAVIGATION_STATUS
from tests.support.ports import free_port
from tests.system.conftest import LAYOUT
from tests.system.harness import ConsoleProcess, HubProcess, Observer


class Site:
    """A robot, its fleet's router, and one console after the other.

    Attributes:
        place: Where the router listens.
        certificates: Of the fleet's authority; None: the router is open to this machine.
    """

    def __init__(self, folder: Path, certificates: Path | None = None) -> None:
        self.certificates = certificates
        where = "tls/localhost" if certificates else "tcp/127.0.0.1"
        self.place = f"{where}:{free_port()}"
        self.start_router()
        self.hub = HubProcess(folder, tables=self.table("rover"))
        watched = (navigation.GROUND_TRUTH, CONTROL_STATE, NAVIGATION_STATUS)
        self.observer = Observer(self.hub.endpoint, *watched)
        self.layout = folder / "layout.xml"
        text = LAYOUT.replace('hub="{hub}"', 'fleet="rune/lab"')
        self.layout.write_text(text.replace("magellan", "rover"))

    def table(self, name: str) -> str:
        """The table of a robot file."""
        shown = f'certificates = "{self.certificates}"\n' if self.certificates else ""
        lines = f'router = "{self.place}"\nname = "{name}"\nfleet = "rune/lab"\n{shown}'
        return f"\n[fleet]\n{lines}"

    def start_router(self) -> None:
        words = ["fleet", "router", "--fleet", "rune/lab", "--listen", self.place]
        words += ["--tls", str(self.certificates)] if self.certificates else []
        command = [sys.executable, "-m", "hub", *words]
        self.router = subprocess.Popen(command, stdout=subprocess.PIPE)
        assert self.router.stdout is not None
        assert self.router.stdout.readline()

    def kill_router(self) -> None:
        self.router.kill()
        self.router.communicate()

    def console(self, *options: str) -> ConsoleProcess:
        made = ConsoleProcess(["run", str(self.layout), "--fleet", self.place, *options])
        made.wait_for_picture(40.0)
        return made

    def newest(self, name: str) -> Any:
        return self.observer.seen[name][-1][1]

    def close(self) -> None:
        self.observer.close()
        self.hub.close()
        if self.router.poll() is None:
            self.kill_router()


def mirror_of(console: ConsoleProcess) -> psutil.Process:
    children = psutil.Process(console.process.pid).children(recursive=True)
    return next(each for each in children if "mirror" in each.cmdline())


def stopped_after(observer: Observer) -> float:
    """Time from now until the wheels are commanded to stop [s]."""
    began = time.monotonic()
    observer.wait(lambda: observer.truth.commanded_linear == 0.0, 5.0, "the wheels are driven on")
    took = time.monotonic() - began
    observer.wait(lambda: abs(observer.truth.linear) < 1e-3, 5.0, "it rolls on")
    return took
