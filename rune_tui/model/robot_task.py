"""The present or last task of a robot, from reports of its autonomy and navigation; pure."""

from __future__ import annotations

import math
from typing import Any

from hub.gcm.autonomy import AUTONOMY_STATE, AutonomyState, Behaviour, Phase
from hub.gcm.navigation import NAVIGATION_STATUS, Cause, NavigationStatus, Task
from hub.values import dataclass
from rune_tui.model.robot_state import Received, RobotState

UNDER_WAY = frozenset({Phase.ACTIVE, Phase.WAITING})
"""Phases in which the robot continues by itself."""
FAILED = frozenset({Phase.BLOCKED, Phase.LOST, Phase.REFUSED})
"""Phases of a task that failed."""

_ENDED = {Task.REACHED: Phase.DONE, Task.BLOCKED: Phase.BLOCKED}
_CANCELLED = {
    Cause.STOP: Phase.STOPPED,
    Cause.WITHDRAWN: Phase.STOPPED,
    Cause.BUSY: Phase.LOST,
    Cause.DRIVER: Phase.LOST,
    Cause.TILTED: Phase.LOST,
    Cause.BLIND: Phase.LOST,
}
_KIND = {
    Behaviour.HOLD: "holding",
    Behaviour.EXPLORE: "exploring",
    Behaviour.GO: "going",
    Behaviour.FOLLOW: "following points",
    Behaviour.RETURN: "returning",
    Behaviour.WANDER: "wandering",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotTask:
    """The present task of a robot, or its last one.

    Attributes:
        kind: Its kind, such as "exploring".
        number: Counts the tasks of one source.
        phase: Its state.
        why: The reason for its state, in the robot's words.
        x: Its present target in `map` [m]; NaN: none, or not known.
        y: The same [m].
        left_m: Length of the path that is left [m]; NaN: not known.
        explored: Share explored, 0 to 1; NaN: it does not explore.
        edge_m: Length of the map's edge that is left to explore [m]; NaN: it does not explore.
        seconds: Time since it began, or its whole duration [s].
        ended_s: Time since it ended [s]; NaN: it is active.
        measured: Time of the report, on the console's monotonic clock [s].
    """

    kind: str
    number: int
    phase: Phase
    why: str
    x: float
    y: float
    left_m: float
    explored: float = math.nan
    edge_m: float = math.nan
    seconds: float
    ended_s: float
    measured: float

    @property
    def under_way(self) -> bool:
        """Whether it continues, now or after a wait."""
        return self.phase in UNDER_WAY

    @property
    def reason(self) -> str:
        """The reason, without a repetition of the phase."""
        return self.why.removeprefix("stopped: ") if self.phase is Phase.STOPPED else self.why

    @property
    def failed(self) -> bool:
        """Whether it failed."""
        return self.phase in FAILED

    def since_begin(self, now: float) -> float:
        """Time since it began [s]."""
        return self.seconds + self.age(now) + (now - self.measured) * self.under_way

    def age(self, now: float) -> float:
        """Time since it ended [s]; 0: it is active."""
        since_report = max(0.0, now - self.measured)
        return 0.0 if self.under_way else max(0.0, self.ended_s) + since_report


def autonomy_task(robot: RobotState) -> RobotTask | None:
    """Autonomy's task; None: it never had one."""
    received: Received[AutonomyState] | None = robot.newest(AUTONOMY_STATE)
    if received is None or received.value.phase is Phase.IDLE:
        return None
    status = received.value
    return RobotTask(
        kind=_KIND[status.asked],
        number=status.number,
        phase=status.phase,
        why=status.why,
        x=status.x,
        y=status.y,
        left_m=status.distance_m,
        explored=status.explored,
        edge_m=status.frontier_m,
        seconds=status.seconds,
        ended_s=_known(status.ended_s),
        measured=received.measured,
    )


def navigation_task(robot: RobotState) -> RobotTask | None:
    """Navigation's present or last task, also for autonomy; None: none yet."""
    received: Received[NavigationStatus] | None = robot.newest(NAVIGATION_STATUS)
    if received is None or received.value.task is Task.NONE:
        return None
    status = received.value
    place = math.isfinite(status.x) and math.isfinite(status.y)
    return RobotTask(
        kind="going" if place or status.task is Task.GOING else "turning",
        number=status.number,
        phase=_phase_of(status),
        why=status.why,
        x=status.x if place else math.nan,
        y=status.y if place else math.nan,
        left_m=status.distance_left,
        seconds=status.seconds,
        ended_s=_known(status.ended_s),
        measured=received.measured,
    )


def operator_task(robot: RobotState) -> RobotTask | None:
    """The task of navigation that autonomy did not send."""
    status, autonomy = robot.newest(NAVIGATION_STATUS), robot.newest(AUTONOMY_STATE)
    if status is not None and autonomy is not None:
        sender = autonomy.value.sender
        if sender != 0 and status.value.sender == sender:
            return None
    return navigation_task(robot)


def task_of(robot: RobotState) -> RobotTask | None:
    """The robot's present or last task; None: none yet."""
    found = [task for task in (autonomy_task(robot), operator_task(robot)) if task is not None]
    return min(found, key=_newest, default=None)


def tasks_heard(robot: RobotState) -> Received[Any] | None:
    """The newest report of what the robot does by itself; None: none came."""
    reports = (robot.newest(NAVIGATION_STATUS), robot.newest(AUTONOMY_STATE))
    found = [each for each in reports if each is not None]
    return max(found, key=lambda each: each.measured, default=None)


def _newest(task: RobotTask) -> tuple[bool, float]:
    """Key of an order: active tasks first, then the task that ended last."""
    return not task.under_way, 0.0 if task.under_way else task.ended_s - task.measured


def _phase_of(status: NavigationStatus) -> Phase:
    if status.task in (Task.GOING, Task.TURNING):
        return Phase.ACTIVE if status.cause is Cause.NONE else Phase.WAITING
    if status.task is Task.CANCELLED:
        return _CANCELLED.get(status.cause, Phase.TAKEN_OVER)
    return _ENDED[status.task]


def _known(seconds: float) -> float:
    return seconds if math.isfinite(seconds) else 0.0
