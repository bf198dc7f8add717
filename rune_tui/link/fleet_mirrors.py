"""The robots of fleets: programs that show them as hubs of this machine, started again if they end.

`rune-hub fleet mirror` joins the fleet; the console itself knows hubs only.
"""

from __future__ import annotations

import collections
import contextlib
import dataclasses
import json
import logging
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Collection
from pathlib import Path
from typing import Any

from hub.command_line import ExitCode
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.ipc.roles import Role
from hub.ipc.security.publish_rights import may_publish
from hub.plain_text import plain
from hub.values import dataclass
from rune_tui.layout.spec import LayoutSpec, RobotSpec
from rune_tui.layout.watching import LayoutArrivals

_logger = logging.getLogger(__name__)

_RETRY_S = 0.3
_END_WITHIN_S = 3.0
_MOST_WORDS = 500
_MOST_NOTICES = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetPlace:
    """A fleet, and how this console joins it.

    Attributes:
        router: A router of the fleet, tcp/HOST:PORT or tls/HOST:PORT; empty: this machine's.
        name: Name of the fleet.
        operator: The operator's role and name, as operate:ann; empty: operate, and the login.
        keys: Folder of the operator's certificates, for a router with TLS; None: without.
    """

    router: str
    name: str
    operator: str
    keys: Path | None = None

    @property
    def operator_name(self) -> str:
        """The operator's name without the role; empty: none is named."""
        return self.operator.partition(":")[2]

    @property
    def may_command(self) -> bool:
        """Whether the operator's role allows to drive; the mirror refuses a role that is none."""
        named = self.operator.partition(":")[0]
        role = next((each for each in Role if each.value == named), Role.OPERATE)
        return may_publish(role, VELOCITY_COMMAND.name)


class FleetMirror:
    """One such program, and what it says; a thread reads it and starts it again.

    Attributes:
        refused: Whether it refused what it was given; it is not started again then.
    """

    def __init__(self, place: FleetPlace, robots: Collection[str] = ()) -> None:
        """Start it.

        Args:
            place: The fleet.
            robots: Names of the robots to show; none: all.
        """
        self.place, self.robots = place, frozenset(robots)
        self.refused = self._heard = False
        self._folder = Path(tempfile.mkdtemp(prefix="rune-"))  # mkdtemp admits only this user
        self._there: dict[str, bool] = {}
        self._notices: dict[str, collections.deque[str]] = {}
        self._trouble = "the fleet is not joined yet"
        self._process: subprocess.Popen[bytes] | None = None
        self._ending = threading.Event()
        self._start()
        self._thread = threading.Thread(target=self._keep, name="fleet", daemon=True)
        self._thread.start()

    @property
    def trouble(self) -> str:
        """Why no robot can be there now; empty: the fleet is joined."""
        return self._trouble

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the robots that are there now."""
        return tuple(sorted(name for name, there in self._there.copy().items() if there))

    def endpoint(self, robot: str) -> str:
        """Where the hub of a robot is while it is there."""
        return f"ipc://{self._folder / robot / 'hub'}"

    def why_not(self, robot: str) -> str:
        """Why a robot is not there now; empty: it is."""
        if self._trouble or self._there.get(robot):
            return self._trouble
        gone = robot in self._there
        return f"{robot} {'left' if gone else 'is not in'} the fleet {self.place.name}"

    def next_notice(self, robot: str) -> str:
        """What the operator has to read about a robot's line, each once; empty: no more."""
        waiting = self._notices.get(robot)
        return waiting.popleft() if waiting else ""

    def close(self) -> None:
        """End it."""
        self._ending.set()
        self._stop()
        self._thread.join()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _start(self) -> None:
        place = self.place
        command = ["fleet", "mirror", "--fleet", place.name, "--folder", str(self._folder)]
        command += ["--connect", place.router] if place.router else []
        command += ["--as", place.operator] if place.operator else []
        command += ["--tls", str(place.keys)] if place.keys is not None else []
        command += [word for robot in sorted(self.robots) for word in ("--robot", robot)]
        with (self._folder / "mirror.log").open("wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "hub", *command, "--json", "--stop-with-stdin"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                process_group=0,
                env=os.environ,
            )

    def _keep(self) -> None:
        """Read what it says; start it again when it ends, as a killed one does."""
        while not self._ending.is_set():
            process = self._process
            if process is not None and process.stdout is not None:
                with process.stdout as lines:
                    for line in lines:
                        self._hear(line)
            self._stop()
            for name in self._there:
                self._there[name] = False
            if self._ending.is_set():
                return
            if process is not None and process.returncode == ExitCode.USAGE and not self._heard:
                self._trouble, self.refused = self._last_words(), True
                return
            self._trouble = f"the program that joins the fleet ended: {self._last_words()}"
            _logger.warning("%s; starting it again", self._trouble)
            if not self._ending.wait(_RETRY_S):
                try:
                    self._start()
                except OSError as error:
                    self._trouble = f"the program that joins the fleet cannot be started: {error}"

    def _hear(self, line: bytes) -> None:
        try:
            said: dict[str, Any] = json.loads(line)
        except ValueError:
            return
        self._heard = True
        event, robot = said.get("event"), str(said.get("robot", ""))
        why = plain(str(said.get("why", "")))[:_MOST_WORDS]
        if event == "robot":
            self._there[robot] = True
        elif event == "gone":
            self._there[robot] = False
        elif event == "joined":
            self._trouble = ""
        elif event == "apart":
            self._trouble = why
        elif event == "refused":
            self._note(robot, f"the robot's gateway refused: {why}")
        elif event == "rate" and said.get("thin"):
            self._note(robot, "the line falls behind: states come at the low rate")

    def _note(self, robot: str, notice: str) -> None:
        newest: collections.deque[str] = collections.deque(maxlen=_MOST_NOTICES)
        self._notices.setdefault(robot, newest).append(notice)

    def _stop(self) -> None:
        process = self._process
        if process is None or process.stdin is None:
            return
        with contextlib.suppress(OSError):
            process.stdin.close()
        try:
            process.wait(_END_WITHIN_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def _last_words(self) -> str:
        try:
            said = (self._folder / "mirror.log").read_text(errors="replace").split("\n")
        except OSError:
            said = []
        words = [line.rpartition("rune-hub: ")[2].strip() for line in said if line.strip()]
        return plain(words[-1])[:_MOST_WORDS].rstrip(".") if words else "it says nothing of why"


class FleetWay:
    """The way to one robot of a fleet."""

    def __init__(self, mirror: FleetMirror, robot: str) -> None:
        self._mirror, self._robot = mirror, robot
        self.endpoint = mirror.endpoint(robot)
        self.shown = f"fleet {mirror.place.name}"

    @property
    def trouble(self) -> str:
        """Why the robot is not there now; empty: it is."""
        return self._mirror.why_not(self._robot)

    @property
    def may_command(self) -> bool:
        """Whether the operator's role in the fleet allows to drive."""
        return self._mirror.place.may_command

    def next_notice(self) -> str:
        """What the operator has to read about the line, each once; empty: no more."""
        return self._mirror.next_notice(self._robot)


class FleetMirrors:
    """All fleets of a console, one program for each, and more for robots of later layouts.

    Attributes:
        place: The fleet of the options.
        arrivals: Layouts for robots that join later; None: the console names its layouts.
    """

    def __init__(self, place: FleetPlace) -> None:
        """Join none yet; layouts may name other fleets than the one of the place."""
        self.arrivals: LayoutArrivals | None = None
        self.place = place
        self._mirrors: list[FleetMirror] = []
        self._ways: dict[tuple[str, str], FleetWay] = {}

    def join(self, fleet: str, robots: Collection[str] = ()) -> FleetMirror:
        """Show these robots of a fleet; none: all."""
        place = dataclasses.replace(self.place, name=fleet)
        mirror = FleetMirror(place, robots)
        self._mirrors.append(mirror)
        return mirror

    def follow(self, layout: LayoutSpec) -> None:
        """Show the robots of a layout, each fleet's by one program."""
        wanted: dict[str, set[str]] = {}
        for robot in layout.robots:
            if robot.fleet and self._shown_by(robot) is None:
                wanted.setdefault(robot.fleet, set()).add(robot.name)
        for fleet, names in wanted.items():
            self.join(fleet, names)

    def way(self, robot: RobotSpec) -> FleetWay:
        """The way to a robot that names a fleet."""
        key = (robot.fleet, robot.name)
        if key not in self._ways:
            mirror = self._shown_by(robot) or self.join(robot.fleet, [robot.name])
            self._ways[key] = FleetWay(mirror, robot.name)
        return self._ways[key]

    def close(self) -> None:
        """End all."""
        for mirror in self._mirrors:
            mirror.close()

    def _shown_by(self, robot: RobotSpec) -> FleetMirror | None:
        """The program that shows a robot."""
        for mirror in self._mirrors:
            same = mirror.place.name == robot.fleet
            if same and (not mirror.robots or robot.name in mirror.robots):
                return mirror
        return None
