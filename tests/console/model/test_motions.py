"""Events when a driver goes and comes back, or when somebody stops the robot."""

from __future__ import annotations

from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.diagnostics import SLEEP, Diagnostics, DiagnosticStatus, Severity
from hub.gcm.navigation import MotionState
from rune_tui.model.change_notifier import ChangeNotifier
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.vehicle import problems_of
from tests.console.visualizers.conftest import Made, received
from tests.support.messages import robot_state

ME = 7
NEUTRAL = "it waits: release all keys, then drive"


class Scene:
    """A watch, and a robot that says what navigation does."""

    def __init__(self) -> None:
        self._watch = ChangeNotifier()
        self.owner = ME
        self.problems: tuple[DiagnosticStatus, ...] = ()

    def events_at(self, motion: MotionState) -> list[str]:
        """What is new."""
        control = ControlState(owner=self.owner, operator="ada", why="taken")
        robot = Made().robot(
            link=Made.link(number=ME),
            navigation=received(robot_state(motion=motion)),
            messages={CONTROL_STATE.name: received(control)},
            diagnostics={3: received(Diagnostics(status=self.problems))},
        )
        state = ConsoleState(now=1.0, robots={"magellan": robot})
        return [notice.text for notice in self._watch.look(state)]


def test_a_driver_that_goes_and_comes_back_is_told_and_what_the_robot_waits_for() -> None:
    scene = Scene()
    scene.events_at(MotionState.MOVING)
    assert scene.events_at(MotionState.NO_DRIVER) == ["its driver does not report: it cannot move"]
    assert scene.events_at(MotionState.NO_DRIVER) == []
    assert scene.events_at(MotionState.WAITING) == [f"its driver reports again; {NEUTRAL}"]
    assert scene.events_at(MotionState.WAITING) == []
    assert scene.events_at(MotionState.STANDING) == []


def test_a_driver_that_comes_back_at_once_is_told_by_what_the_robot_waits_for() -> None:
    scene = Scene()
    scene.events_at(MotionState.STANDING)
    assert scene.events_at(MotionState.WAITING) == [NEUTRAL]


def test_that_somebody_stopped_it_is_told() -> None:
    scene = Scene()
    scene.events_at(MotionState.GOING)
    assert scene.events_at(MotionState.STOPPED) == ["it was stopped: release all keys, then drive"]


def test_a_sleep_of_its_computer_is_told_once() -> None:
    scene = Scene()
    scene.events_at(MotionState.MOVING)
    why = "the robot's computer slept for 12.0 s"
    scene.problems = (DiagnosticStatus(level=Severity.WARN, name=SLEEP, message=why),)
    assert why in scene.events_at(MotionState.STOPPED)
    assert scene.events_at(MotionState.STOPPED) == []


def test_what_was_so_before_the_first_look_is_not_told() -> None:
    scene = Scene()
    assert NEUTRAL not in " ".join(scene.events_at(MotionState.WAITING))


def test_that_control_was_handed_over_is_told_once() -> None:
    scene = Scene()
    scene.events_at(MotionState.MOVING)
    scene.owner = 9
    assert NEUTRAL not in scene.events_at(MotionState.WAITING)


def test_a_problem_of_a_module_that_connected_again_is_told_once() -> None:
    found = DiagnosticStatus(level=Severity.WARN, name=SLEEP, message="it slept")
    reports = Diagnostics(status=(found,))
    robot = Made().robot(diagnostics={3: received(reports, 2.0), 9: received(reports, 1.0)})
    (problem,) = problems_of(robot)
    assert problem.measured == received(reports, 1.0).measured, "the newest"
