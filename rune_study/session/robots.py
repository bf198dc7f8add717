"""The robots of a trial: their hubs, their recordings, and what is seen of them meanwhile."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from hub.errors import HubError
from hub.gcm.ground_truth import GROUND_TRUTH, GroundTruth
from hub.gcm.mapping import INTEREST_POINTS, MAP, MAP_REQUEST, InterestPoints, MapRequest, PointKind
from hub.gcm.navigation import ROBOT_STATE, STOP, RobotState, Stop
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.simulation import SIMULATION_PAUSE, SimulationPause
from hub.gcm.vision import CAMERA_STATE, CameraState
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.pose import Pose
from rune_tui.commands.demo import DemoHubs

_START_S = 20.0
_END_S = 5.0
_MAP_S = 3.0
_LISTEN_S = 0.02
_STILL = 0.02
"""Velocity below which a robot stands [m/s, rad/s]."""


@contextlib.contextmanager
def simulated(robots: Sequence[str], settings: Sequence[str], log: Path) -> Iterator[list[str]]:
    """Endpoints of the hubs of simulated robots, which end with the context.

    Raises:
        DemoError: One did not start.
    """
    with DemoHubs(log) as hubs:
        hubs.start(robots, "", settings)
        yield hubs.endpoints()


@contextlib.contextmanager
def recorded(hubs: Sequence[str], files: Sequence[Path], log: Path) -> Iterator[None]:
    """Record all that hubs publish, each into a file, until the end of the context."""
    with contextlib.ExitStack() as stack:
        output = stack.enter_context(log.open("ab"))
        for hub, file in zip(hubs, files, strict=True):
            command = [
                sys.executable,
                "-m",
                "hub",
                "record",
                "--hub",
                hub,
                "-o",
                str(file),
                "--json",
                "--stop-with-stdin",
            ]
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=output, stderr=output)
            stack.callback(_end, process)
        yield


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.stdin is not None:
        process.stdin.close()
    try:
        process.wait(_END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class WatchedRobot:
    """What is seen of a robot during a trial; one thread uses it.

    Attributes:
        distance: Length of its way since the start [m]; simulated robots only.
        collisions: Number of its collisions since the start; simulated robots only.
        victims: Number of victims near which one is marked.
        truth: Its newest true state; None: none came.
        state: Its newest state, as it reports it; None: none came.
        camera: The newest state of its main camera; None: none came.
        marks: Marks of victims in its `map` [m].
        map_in_arena: Its frame `map` in the arena's; None: not known yet.
    """

    def __init__(
        self,
        hub: str,
        number: int,
        victims: Sequence[tuple[float, float]],
        radius: float,
        *,
        real: bool,
    ) -> None:
        """Connect.

        Args:
            hub: The endpoint.
            number: Of the robot, from 0.
            victims: Where victims are in its `map` [m]; none: not known.
            radius: Largest distance of a mark from its victim [m].
            real: Whether it is no simulated robot.

        Raises:
            HubError: No hub answers.
        """
        self.distance = 0.0
        self.collisions = 0
        self.victims = 0
        self.truth: GroundTruth | None = None
        self.state: RobotState | None = None
        self.camera: CameraState | None = None
        self.marks: tuple[tuple[float, float], ...] = ()
        self.map_in_arena: Pose | None = None
        self._first = 0
        self._still_since = math.inf
        self._radius = radius
        self._real = real
        self._victims = victims
        self._client = Client(f"study-{os.getpid()}-{number}", hub)
        try:
            self._client.define(STOP, *([] if real else [SIMULATION_PAUSE]))
            self._client.subscribe(GROUND_TRUTH, self._see)
            self._client.subscribe(ROBOT_STATE, self._see_state)
            self._client.subscribe(CAMERA_STATE, self._see_camera)
            self._client.subscribe(INTEREST_POINTS, self._count, last=True)
            self._client.wait_connected(_START_S)
        except BaseException:
            self._client.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._client.close()

    @property
    def number_of_victims(self) -> int:
        """Number of victims in its arena."""
        return len(self._victims)

    def still_for(self, now: float) -> float:
        """How long it has been standing [s]."""
        return max(0.0, now - self._still_since)

    def watch(self, seconds: float) -> None:
        """Handle messages for this time [s]."""
        self._client.listen(seconds)

    def begin(self) -> None:
        """Count from now on."""
        self.distance = 0.0
        self._first = self.truth.contacts if self.truth is not None else 0
        self.collisions = 0

    def pause(self, *, on: bool) -> None:
        """Let its simulation stand still, or run again; a real robot stops."""
        if not self._real:
            self._client.publish(SIMULATION_PAUSE, SimulationPause(paused=int(on)))
        elif on:
            self._client.publish(STOP, Stop(reason="a pause of the study"))
        self._client.wait_published(_START_S)

    def own_map(self) -> OccupancyMap | None:
        """The map that it made until now; None: it has none, or does not answer."""
        try:
            answer = self._client.query_response(MAP_REQUEST, MapRequest(), MAP, timeout=_MAP_S)
            return OccupancyMap.of(answer)
        except HubError:
            return None

    def _see_state(self, state: RobotState, _: MessageInfo) -> None:
        self.state = state
        if self.map_in_arena is None and self.truth is not None:
            own = Pose(x=state.x, y=state.y, theta=state.theta)
            here = Pose(x=self.truth.x, y=self.truth.y, theta=self.truth.theta)
            self.map_in_arena = here.then(Pose().seen_from(own))

    def _see_camera(self, camera: CameraState, _: MessageInfo) -> None:
        self.camera = camera

    def _see(self, truth: GroundTruth, info: MessageInfo) -> None:
        if self.truth is not None:
            self.distance += math.hypot(truth.x - self.truth.x, truth.y - self.truth.y)
        self.truth = truth
        self.collisions = max(0, truth.contacts - self._first)
        moves = max(abs(truth.linear), abs(truth.sway), abs(truth.heave), abs(truth.angular))
        if moves > _STILL:
            self._still_since = math.inf
        else:
            self._still_since = min(self._still_since, info.measured)

    def _count(self, points: InterestPoints, _: MessageInfo) -> None:
        self.marks = tuple(
            (each.x, each.y) for each in points.points if each.kind == PointKind.VICTIM
        )
        self.victims = sum(
            any(math.dist(mark, victim) <= self._radius for mark in self.marks)
            for victim in self._victims
        )


def state_of(robot: WatchedRobot) -> dict[str, Any]:
    """What is true of a robot now, as the journal has it."""
    truth = robot.truth
    seen: dict[str, Any] = {"collisions": robot.collisions, "victims": robot.victims}
    seen["distance"] = round(robot.distance, 3)
    if truth is not None:
        seen |= {"x": truth.x, "y": truth.y, "theta": truth.theta, "linear": truth.linear}
    return seen


@contextlib.contextmanager
def listening(robots: Sequence[WatchedRobot]) -> Iterator[None]:
    """Keep the connections to robots served while this thread is busy."""
    ended = threading.Event()

    def serve() -> None:
        while not ended.is_set():
            for robot in robots:
                robot.watch(_LISTEN_S)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
