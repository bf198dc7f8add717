"""The present or last task of a robot, from reports of its autonomy and navigation; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hub.gcm.autonomy import AUTONOMY_STATE, AutonomyState, Behaviour, Phase
from hub.gcm.navigation import NAVIGATION_STATUS, Cause, NavigationStatus, Task
from rune_tui.model.robot_state import Received, RobotState

UNDER_WAY = frozenset({Phase.ACTIVE, Phase.WAITING})
"""Phases in which the robot goes on by itself."""
FAILED = frozenset({Phase.BLOCKED, Phase.LOST, Phase.REFUSED})
"""Phases of a task that failed."""

_ENDED = {Task.REACHED: Phase.DONE, Task.BLOCKED: Phase.BLOCKED}
_CANCELLED = {
    Cause.STOP: Phase.STOPPED,
    Cause.WITHDRAWN: Phase.STOPPED,
    Cause.BUSY: Phase.LOST,
    Cause.DRIVER: Phase.LOST,
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
class Doing:
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
        """Whether it goes on, now or after a while."""
        return self.phase in UNDER_WAY

    @property
    def reason(self) -> str:
        """The reason, without the word of the phase."""
        return self.why.removeprefix("stopped: ") if self.phase is Phase.STOPPED else self.why

    @property
    def failed(self) -> bool:
        """Whether it failed."""
        return self.phase in FAILED

    def age(self, now: float) -> float:
        """Time since it ended [s]; 0: it is active."""
        since_report = max(0.0, now - self.measured)
        return 0.0 if self.under_way else max(0.0, self.ended_s) + since_report


def by_autonomy(robot: RobotState) -> Doing | None:
    """The task of autonomy; None: it never had one."""
    received: Received[AutonomyState] | None = robot.newest(AUTONOMY_STATE)
    if received is None or received.value.phase is Phase.IDLE:
        return None
    said = received.value
    return Doing(
        kind=_KIND[said.asked],
        number=said.number,
        phase=said.phase,
        why=said.why,
        x=said.x,
        y=said.y,
        left_m=said.distance_m,
        explored=said.explored,
        edge_m=said.frontier_m,
        seconds=said.seconds,
        ended_s=_known(said.ended_s),
        measured=received.measured,
    )


def by_navigation(robot: RobotState) -> Doing | None:
    """The present or last task of navigation, also for autonomy; None: none yet."""
    received: Received[NavigationStatus] | None = robot.newest(NAVIGATION_STATUS)
    if received is None or received.value.task is Task.NONE:
        return None
    said = received.value
    place = math.isfinite(said.x) and math.isfinite(said.y)
    return Doing(
        kind="going" if place or said.task is Task.GOING else "turning",
        number=said.number,
        phase=_phase_of(said),
        why=said.why,
        x=said.x if place else math.nan,
        y=said.y if place else math.nan,
        left_m=said.distance_left,
        seconds=said.seconds,
        ended_s=_known(said.ended_s),
        measured=received.measured,
    )


def of_operators(robot: RobotState) -> Doing | None:
    """The task of navigation that autonomy did not send."""
    status, autonomy = robot.newest(NAVIGATION_STATUS), robot.newest(AUTONOMY_STATE)
    if status is not None and autonomy is not None:
        sender = autonomy.value.sender
        if sender != 0 and status.value.sender == sender:
            return None
    return by_navigation(robot)


def doing_of(robot: RobotState) -> Doing | None:
    """The robot's present task, else its last one; None: none yet."""
    found = [doing for doing in (by_autonomy(robot), of_operators(robot)) if doing is not None]
    return min(found, key=_newest, default=None)


def _newest(doing: Doing) -> tuple[bool, float]:
    """Key of an order: active tasks first, then the task that ended last."""
    return not doing.under_way, 0.0 if doing.under_way else doing.ended_s - doing.measured


def _phase_of(said: NavigationStatus) -> Phase:
    if said.task in (Task.GOING, Task.TURNING):
        return Phase.ACTIVE if said.cause is Cause.NONE else Phase.WAITING
    if said.task is Task.CANCELLED:
        return _CANCELLED.get(said.cause, Phase.TAKEN_OVER)
    return _ENDED[said.task]


def _known(seconds: float) -> float:
    return seconds if math.isfinite(seconds) else 0.0
