"""Each task of a robot gives one notice at its begin, one while it waits long, one at its end."""

from __future__ import annotations

import math
from typing import Any

from hub.gcm.autonomy import AUTONOMY_STATE, Behaviour, Phase
from hub.gcm.navigation import NAVIGATION_STATUS, Cause, Task
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import Received
from rune_tui.model.task_watch import WAIT_S, TaskWatch
from tests.console.visualizers import known
from tests.console.visualizers.conftest import Made
from tests.console.visualizers.words.test_autonomy import navigation
from tests.support.cases import for_each


class Story:
    """What a console sees, look by look."""

    def __init__(self) -> None:
        self.watch = TaskWatch()
        self.now = 100.0
        self.began = 50.0
        self.notices: list[Notice] = []

    def look(
        self,
        autonomy: dict[str, Any] | None = None,
        status: dict[str, Any] | None = None,
        after: float = 0.1,
    ) -> list[tuple[str, bool]]:
        self.now += after
        messages = {}
        if autonomy is not None:
            messages[AUTONOMY_STATE.name] = self._received(known.autonomy(**autonomy))
        if status is not None:
            messages[NAVIGATION_STATUS.name] = self._received(navigation(**status))
        robot = Made().robot(messages=messages)
        state = ConsoleState(now=self.now, began=self.began, clock="14:03:22")
        self.notices = [*self.watch.look(robot, state)]
        return [(notice.text, notice.alarm) for notice in self.notices]

    def _received(self, value: Any) -> Received[Any]:
        return Received(value=value, measured=self.now - 0.1, number=1)


IDLE = {"phase": Phase.IDLE, "asked": Behaviour.HOLD, "number": 0}

ENDS = [
    (Phase.DONE, "explored: nothing is left", "done", False),
    (Phase.BLOCKED, "there is no way", "BLOCKED", True),
    (Phase.STOPPED, "stopped: lunch", "stopped", False),
    (Phase.TAKEN_OVER, "the operator took over", "ended", False),
    (Phase.LOST, "gave up after 60 s: the driver is gone", "GIVEN UP", True),
]


@for_each(("phase", "why", "verb", "alarm"), ENDS)
def test_an_exploration_has_notices_of_its_begin_and_its_end(
    phase: Phase,
    why: str,
    verb: str,
    alarm: bool,  # noqa: FBT001 a parameter of the table
) -> None:
    story = Story()
    assert story.look(IDLE) == []
    assert story.look({}) == [("exploring begins", False)]
    assert story.look({"explored": 0.6}) == []
    over = {"phase": phase, "why": why, "seconds": 412.4, "ended_s": 0.1}
    said = why.removeprefix("stopped: ")
    assert story.look(over) == [(f"exploring {verb}: {said} (412 s)", alarm)]
    assert story.look(over) == []


CAUSES = [
    (Task.REACHED, Cause.NONE, "done", False),
    (Task.BLOCKED, Cause.CLOSED, "BLOCKED", True),
    (Task.CANCELLED, Cause.STOP, "stopped", False),
    (Task.CANCELLED, Cause.WITHDRAWN, "stopped", False),
    (Task.CANCELLED, Cause.STICK, "ended", False),
    (Task.CANCELLED, Cause.CONTROL, "ended", False),
    (Task.CANCELLED, Cause.DRIVER, "GIVEN UP", True),
    (Task.CANCELLED, Cause.BUSY, "GIVEN UP", True),
]


@for_each(("task", "cause", "verb", "alarm"), CAUSES)
def test_a_goal_has_notices_of_its_begin_and_its_end(
    task: Task,
    cause: Cause,
    verb: str,
    alarm: bool,  # noqa: FBT001 a parameter of the table
) -> None:
    story = Story()
    story.look(status={"task": Task.NONE})
    assert story.look(status={}) == [("going to 2.0, 1.0 m begins", False)]
    over = {"task": task, "cause": cause, "why": "so it is", "ended_s": 0.1}
    assert story.look(status=over) == [(f"going {verb}: so it is (12 s)", alarm)]


def test_a_goal_that_was_over_at_once_has_a_notice() -> None:
    story = Story()
    story.look(status={"task": Task.NONE, "number": 0})
    over = {"task": Task.CANCELLED, "cause": Cause.DRIVER, "why": "not begun: so", "seconds": 0.0}
    assert story.look(status=over) == [("going GIVEN UP: not begun: so", True)]


def test_the_goals_of_autonomy_have_no_notices() -> None:
    story = Story()
    story.look({}, {"sender": 5})
    for number in range(4, 9):
        assert story.look({}, {"sender": 5, "number": number}) == []
        over = {"sender": 5, "number": number, "task": Task.BLOCKED, "ended_s": 0.0}
        assert story.look({}, over) == []


def test_what_was_over_before_the_console_came_is_history_with_its_time_and_no_alarm() -> None:
    story = Story()
    assert story.look(None, None) == []
    blocked = {"task": Task.BLOCKED, "why": "no way", "ended_s": 449.0, "seconds": 0.5}
    assert story.look(None, blocked, after=2.0) == [("going BLOCKED: no way", False)]
    (notice,) = story.notices
    assert (notice.past, notice.quiet, notice.clock) == (True, True, "13:55:53")
    assert story.look({"seconds": 131.0}, blocked) == [("exploring begins", False)]
    assert story.notices[0].past


def test_what_ended_while_the_link_was_lost_is_news_with_its_time() -> None:
    story = Story()
    story.look(None, {})
    assert story.look(None, {"task": Task.BLOCKED, "ended_s": 60.0}, after=100.0)[0][1]
    assert (story.notices[0].past, story.notices[0].clock) == (False, "14:02:22")


def test_a_long_wait_has_notices_of_its_begin_and_its_end() -> None:
    story = Story()
    story.look({})
    waits = {"phase": Phase.WAITING, "why": "waits: the map is old"}
    assert story.look(waits) == []
    assert story.look(waits, after=0.9 * WAIT_S) == []
    assert story.look(waits, after=0.2 * WAIT_S) == [("exploring waits: the map is old", False)]
    assert story.look(waits, after=9.0) == []
    assert story.look({}) == [("exploring goes on", False)]
    assert story.look(waits) == []
    assert story.look({}) == [], "a short one"


def test_a_new_order_ends_the_old_one() -> None:
    story = Story()
    story.look({})
    back = {"asked": Behaviour.RETURN, "number": 2, "explored": math.nan}
    assert story.look(back) == [
        ("exploring ended: another task began", False),
        ("returning begins", False),
    ]


def test_an_autonomy_that_began_anew_has_forgotten_and_that_is_an_alarm() -> None:
    story = Story()
    story.look({})
    assert story.look(IDLE) == [("exploring ended: the robot no longer reports it", True)]


def test_a_reason_that_comes_after_the_end_is_said_once() -> None:
    story = Story()
    story.look(status={"task": Task.NONE})
    story.look(status={"task": Task.GOING, "number": 1})
    over = {"task": Task.BLOCKED, "cause": Cause.CLOSED, "number": 1, "why": "it gave up"}
    over["seconds"] = 12.0
    assert story.look(status=over) == [("going BLOCKED: it gave up (12 s)", True)]
    over["why"] = "it gave up: no path"
    assert story.look(status=over) == [("going BLOCKED: it gave up: no path", False)]
    assert story.look(status=over) == []
