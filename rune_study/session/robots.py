"""The robots of a trial: their hubs, their recordings, and what is seen of them meanwhile."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
import threading
import time
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
from hub.ipc.security.client_keys import read_client_keys
from hub.pose import Pose
from rune_study.errors import TrialError
from rune_study.plan.study_spec import MetricsSpec
from rune_study.session.work_watch import WorkWatch
from rune_tui.commands.demo import DemoHubs

_START_S = 20.0
_POSE_S = 10.0
"""A robot whose hub answers says where it is within this time [s]."""
_END_S = 5.0
_MAP_S = 3.0
_LOOK_S = 0.02


@contextlib.contextmanager
def simulated(robots: Sequence[str], settings: Sequence[str], log: Path) -> Iterator[list[str]]:
    """Endpoints of the hubs of simulated robots, which end with the context.

    Raises:
        OwnHubError: One did not start.
    """
    with DemoHubs(log) as hubs:
        hubs.start(robots, "", settings)
        yield hubs.endpoints()


class Recorders:
    """Recorders of what hubs publish, each into a file, until the end of the context."""

    def __init__(
        self, hubs: Sequence[str], files: Sequence[Path], log: Path, keys: Path | None = None
    ) -> None:
        """Start them, and wait until they record.

        Args:
            hubs: The endpoints.
            files: A new file for each.
            log: Gets what they say.
            keys: The key file, for hubs on other machines.

        Raises:
            TrialError: One does not start.
        """
        self._files = files
        self._processes: list[subprocess.Popen[bytes]] = []
        try:
            with log.open("ab") as output:
                for hub, file in zip(hubs, files, strict=True):
                    command = [sys.executable, "-m", "hub", "record", "--hub", hub]
                    command += ["-o", str(file), "--json", "--stop-with-stdin"]
                    command += ["--keys", str(keys)] if keys is not None else []
                    self._processes.append(
                        subprocess.Popen(
                            command, stdin=subprocess.PIPE, stdout=output, stderr=output
                        )
                    )
            self._wait(log)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def ended(self) -> str:
        """The file of a recorder that ended by itself; empty: all record."""
        pairs = zip(self._processes, self._files, strict=False)
        return next((file.name for each, file in pairs if each.poll() is not None), "")

    def close(self) -> None:
        """End them all."""
        for each in self._processes:
            if each.stdin is not None:
                each.stdin.close()
        for each in self._processes:
            try:
                each.wait(_END_S)
            except subprocess.TimeoutExpired:
                each.kill()
                each.wait()

    def _wait(self, log: Path) -> None:
        late = time.monotonic() + _START_S
        while not all(file.exists() for file in self._files):
            if self.ended or time.monotonic() > late:
                missing = next(file for file in self._files if not file.exists())
                text = f"nothing records into {missing}; {log} says why"
                raise TrialError(text)
            time.sleep(_LOOK_S)


class WatchedRobot:
    """What is seen of a robot during a trial; one thread uses it.

    Of a simulated robot that is the truth. Of a real one it is what the robot believes; a collision
    is then a bumper that was pressed. A real robot is stopped when the trial is over.

    Attributes:
        distance: Length of its way since the start [m].
        collisions: Number of its collisions since the start.
        victims: Number of victims near which one is marked.
        pose: Where it is, and how it moves; None: it said nothing yet.
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
        *,
        metrics: MetricsSpec,
        real: bool,
        keys: Path | None = None,
    ) -> None:
        """Connect, and wait until the robot says where it is.

        Args:
            hub: The endpoint.
            number: Of the robot, from 0.
            victims: Where victims are in its `map` [m]; none: not known.
            metrics: When a mark fits a victim, and when a robot works.
            real: Whether it is no simulated robot.
            keys: The key file, for a hub on another machine.

        Raises:
            HubError: No hub answers.
            TrialError: The robot says nothing.
        """
        self.distance = 0.0
        self.collisions = 0
        self.victims = 0
        self.pose: GroundTruth | RobotState | None = None
        self.truth: GroundTruth | None = None
        self.state: RobotState | None = None
        self.camera: CameraState | None = None
        self.marks: tuple[tuple[float, float], ...] = ()
        self.map_in_arena: Pose | None = None
        self._contacts = self._first = 0
        self._pressed = False
        self._radius = metrics.victim_radius_m
        self._work = WorkWatch(metrics.threshold)
        self._way = 0.0
        self._real = real
        self._victims = victims
        self._heard = -math.inf
        own = read_client_keys(keys) if keys is not None else None
        self._client = Client(f"study-{os.getpid()}-{number}", hub, keys=own)
        try:
            self._client.define(STOP, *([] if real else [SIMULATION_PAUSE]))
            self._client.subscribe(GROUND_TRUTH, self._see)
            self._client.subscribe(ROBOT_STATE, self._see_state)
            self._client.subscribe(CAMERA_STATE, self._see_camera)
            self._client.subscribe(INTEREST_POINTS, self._count, last=True)
            self._client.wait_connected(_START_S)
            self._wait_for_pose(hub)
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
        if self._real:  # a robot out of reach stops by itself
            with contextlib.suppress(HubError):
                self._stop("the trial is over")
        self._client.close()

    @property
    def number_of_victims(self) -> int:
        """Number of victims in its arena."""
        return len(self._victims)

    def low_for(self, now: float) -> float:
        """How long it has not been working [s]."""
        return self._work.low_for(now)

    def silent_for(self, now: float) -> float:
        """How long it has said nothing [s]."""
        return now - self._heard

    def watch(self, seconds: float) -> None:
        """Handle messages for this time [s]."""
        self._client.listen(seconds)

    def begin(self) -> None:
        """Count from now on."""
        self.distance = 0.0
        self._first = self._contacts
        self.collisions = 0

    def pause(self, *, on: bool) -> None:
        """Let its simulation stand still, or run again; a real robot stops."""
        self._heard = time.monotonic()
        if not self._real:
            self._client.publish(SIMULATION_PAUSE, SimulationPause(paused=int(on)))
            self._client.wait_published(_END_S)
        elif on:
            self._stop("a pause of the study")

    def _stop(self, why: str) -> None:
        self._client.publish(STOP, Stop(reason=why))
        self._client.wait_published(_END_S)

    def _wait_for_pose(self, hub: str) -> None:
        late = time.monotonic() + _POSE_S
        while self.pose is None:
            self._client.listen(_LOOK_S)
            if time.monotonic() > late:
                text = (
                    f"the robot at {hub} does not say where it is ({self._source}); "
                    f"rune-hub modules --hub {hub} shows what is wrong there"
                )
                raise TrialError(text)

    @property
    def _source(self) -> str:
        return ROBOT_STATE.name if self._real else GROUND_TRUTH.name

    def own_map(self) -> OccupancyMap | None:
        """The map that it made until now; None: it has none, or does not answer."""
        try:
            answer = self._client.query_response(MAP_REQUEST, MapRequest(), MAP, timeout=_MAP_S)
            return OccupancyMap.of(answer)
        except HubError:
            return None

    def _see_state(self, state: RobotState, info: MessageInfo) -> None:
        self.state = state
        if self._real:
            self._believe(state, info)
        if self.map_in_arena is None and self.truth is not None:
            own = Pose(x=state.x, y=state.y, theta=state.theta)
            here = Pose(x=self.truth.x, y=self.truth.y, theta=self.truth.theta)
            self.map_in_arena = here.then(Pose().seen_from(own))

    def _see_camera(self, camera: CameraState, _: MessageInfo) -> None:
        self.camera = camera

    def _see(self, truth: GroundTruth, info: MessageInfo) -> None:
        self.truth = truth
        if not self._real:
            self._contacts = truth.contacts
            self._move(truth, info)

    def _believe(self, state: RobotState, info: MessageInfo) -> None:
        pressed = bool(state.bumpers)
        self._contacts += pressed and not self._pressed
        self._pressed = pressed
        self._move(state, info)

    def _move(self, pose: GroundTruth | RobotState, info: MessageInfo) -> None:
        if self.pose is not None:
            step = math.hypot(pose.x - self.pose.x, pose.y - self.pose.y)
            self.distance += step
            self._way += step
        self.pose = pose
        self._heard = time.monotonic()
        self.collisions = max(0, self._contacts - self._first)
        self._work.follow(info.measured, self._way)

    def _count(self, points: InterestPoints, _: MessageInfo) -> None:
        self.marks = tuple(
            (each.x, each.y) for each in points.points if each.kind == PointKind.VICTIM
        )
        self.victims = sum(
            any(math.dist(mark, victim) <= self._radius for mark in self.marks)
            for victim in self._victims
        )


def state_of(robot: WatchedRobot) -> dict[str, Any]:
    """Where a robot is and what it did, as the journal has it."""
    pose = robot.pose
    seen: dict[str, Any] = {"collisions": robot.collisions, "victims": robot.victims}
    seen["distance"] = round(robot.distance, 3)
    if pose is not None:
        seen |= {"x": pose.x, "y": pose.y, "theta": pose.theta, "linear": pose.linear}
        seen["true"] = isinstance(pose, GroundTruth)
    return seen


@contextlib.contextmanager
def listening(robots: Sequence[WatchedRobot]) -> Iterator[None]:
    """Keep the connections to robots served while this thread is busy."""
    ended = threading.Event()

    def serve() -> None:
        while not ended.is_set():
            for robot in robots:
                robot.watch(_LOOK_S)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
