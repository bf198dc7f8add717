"""A task that the robot's own navigation carries out, while Rune's own only watches; pure.

| what the driver reports of the goal | the task |
| --- | --- |
| nothing for 1.5 s, nothing of this goal for 1.5 s, or SENT for 5 s | ends: cancelled, DRIVER |
| SENT, DRIVES | goes on; it says when the robot was silent for 1 s |
| REACHED | goes on to the next point; after the last one it is done |
| ABORTED, REFUSED | ends: blocked |
| CANCELLED, which another node did | ends: cancelled, REPLACED |
| LOST | ends: cancelled, DRIVER |
| another reason for an end that it has reported | the ended task has this reason |

The wheels are never held for such a task: what would hold it ends it. So no goal is sent again
after a loss. Each point is a goal of its own, in `odom` as it lies when the goal is sent.
"""

from __future__ import annotations

import math
import secrets
from itertools import pairwise
from typing import Final

from hub.gcm.navigation import Cause, Task
from hub.gcm.own_navigation import DriveGoal, OwnGoal, OwnNavigation
from hub.ipc.message_info import MessageInfo
from hub.modules.navigation.path_follower import PathFollower
from hub.modules.navigation.speed_governor import HELD, SpeedGovernor
from hub.modules.navigation.task import NavigationTask
from hub.pose import Pose, wrapped

REPORT_S: Final = 1.5
"""Age from which on a report of the driver does not count [s]."""
SENT_S: Final = 5.0
"""Longest time until the robot takes a goal [s]; goals before it have to end first."""
QUIET_S: Final = 1.0
"""Silence of the robot about its goal from which on the task says so [s]."""
_MOST: Final = 1 << 32
_ENDS: Final = {
    OwnGoal.ABORTED: (Task.BLOCKED, Cause.CLOSED),
    OwnGoal.REFUSED: (Task.BLOCKED, Cause.CLOSED),
    OwnGoal.CANCELLED: (Task.CANCELLED, Cause.REPLACED),
    OwnGoal.LOST: (Task.CANCELLED, Cause.DRIVER),
}


class OwnPilot:
    """The goals for one robot; every method gets the monotonic time [s]."""

    def __init__(self, pilot: PathFollower, *, expected: bool) -> None:
        """Watch the tasks of a path follower.

        Args:
            pilot: Has the tasks.
            expected: Whether the robot file names such a navigation, so that goals wait for a
                report.
        """
        self._pilot, self._expected = pilot, expected
        self._report: tuple[OwnNavigation, float] | None = None
        # The numbers begin at a random one: the driver may know those of the process before.
        self._number = secrets.randbelow(_MOST)
        self._goal: DriveGoal | None = None
        self._began = 0.0
        self._ended = (0, 0)  # the task and the goal that a report ended last

    def reported(self, report: OwnNavigation, reception: MessageInfo) -> None:
        """Take what the driver reports; the robot may say why it gave up a little later."""
        self._report = report, reception.measured
        task = self._pilot.task
        if not task.active and report.why and self._ended == (task.number, report.number):
            task.why = report.why

    def refusal(self, now: float) -> str:
        """Why no goal can begin, as it is not known who would drive; empty: one can."""
        if self._expected and self._fresh(now) is None:
            return "the driver has not said yet whether the robot's own navigation takes goals"
        return ""

    def begin(self, now: float) -> None:
        """Carry out a new task to go to points, if the robot has navigation of its own now."""
        report = self._fresh(now)
        if report is not None and report.available:
            self._pilot.task.by_robot = True
            self._aim(now)

    def steered(self, governor: SpeedGovernor, now: float) -> DriveGoal | None:
        """The goal for the driver; None: there is none, or the task has just ended."""
        task = self._pilot.task
        if not (governor.has_task and task.active and task.by_robot):
            return None
        report = self._fresh(now)
        held = governor.held if report is not None else Cause.DRIVER
        if held is not Cause.NONE or report is None:
            task.end(Task.CANCELLED, f"ended: {HELD[held]}", held, now)
            return None
        if self._goal is None or report.number != self._goal.number:
            if now - self._began > REPORT_S:
                task.end(Task.CANCELLED, "the driver does not take the goal", Cause.DRIVER, now)
                return None
            return self._goal
        if report.goal is OwnGoal.REACHED:
            task.reached(now)
            if not task.active:
                return None
            self._aim(now)
        elif report.goal in _ENDS:
            how, cause = _ENDS[report.goal]
            task.end(how, report.why or "the robot's own navigation ended it", cause, now)
            self._ended = task.number, report.number
            return None
        elif report.goal is OwnGoal.SENT and now - self._began > SENT_S:
            why = "the robot's own navigation does not take the goal"
            task.end(Task.CANCELLED, why, Cause.DRIVER, now)
            return None
        else:
            _watch(task, report, self._pilot.pose)
        return self._goal

    def _fresh(self, now: float) -> OwnNavigation | None:
        """The newest report; None: there is none, or it is too old."""
        if self._report is None or now - self._report[1] >= REPORT_S:
            return None
        return self._report[0]

    def _aim(self, now: float) -> None:
        """Make a goal of the task's next point."""
        task, pose, odom = self._pilot.task, self._pilot.pose, self._pilot.correction.odom
        x, y = task.points[0]
        theta = task.theta if len(task.points) == 1 else math.nan
        if not math.isfinite(theta):  # the direction in which it comes
            theta = math.atan2(y - pose.y, x - pose.x)
        # 0 stands for no goal.
        self._number = self._number % (_MOST - 1) + 1
        inner_x, inner_y = odom.inward(x, y)
        self._goal = DriveGoal(
            number=self._number, x=inner_x, y=inner_y, theta=wrapped(theta - odom.theta)
        )
        self._began = now


def _watch(task: NavigationTask, report: OwnNavigation, pose: Pose) -> None:
    """Note the way that is left, and whether the robot is silent."""
    left = report.distance_left
    if not math.isfinite(left):
        left = math.dist(task.points[0], (pose.x, pose.y))
    task.distance_left = left + sum(math.dist(a, b) for a, b in pairwise(task.points))
    quiet = report.heard_s >= QUIET_S
    task.cause = Cause.DRIVER if quiet else Cause.NONE
    seconds = f"{report.heard_s:.0f} s" if quiet else ""
    task.why = f"waits: the robot's own navigation was silent for {seconds}" if quiet else ""
