"""Reports changes of robots and joysticks that the operator must see, each once."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Iterator, Mapping

from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityPhase
from rune_tui.model.autopilot_watch import AutopilotWatch
from rune_tui.model.body import can_have
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.control import (
    Standing,
    answer_keys,
    asks,
    control_of,
    owner_words,
    seconds_left,
    standing,
)
from rune_tui.model.joystick_state import Absence, JoystickPhase, JoystickState
from rune_tui.model.mission import MissionWatch
from rune_tui.model.motions import MotionWatch
from rune_tui.model.recording import RecordingWatch
from rune_tui.model.robot_state import LackKind, LinkPhase, RobotState
from rune_tui.model.task_watch import TaskWatch

_logger = logging.getLogger(__name__)

_GONE = {
    Absence.UNPLUGGED: "is unplugged: {} is gone",
    Absence.ENDED: "has ended: {} is no longer sent",
    Absence.SILENT: "is silent: nothing comes from {}",
}

GRACE_S = 4.0
"""Shorter absences are not reported, because hubs start with some [s]."""


class ChangeNotifier:
    """Compares the state of each robot and joystick with its state before.

    It reports: links lost and found; changes of control; stops; refusals; tasks that begin and
    end; what an autopilot does and says; requested capabilities that a robot does not provide;
    messages with values out of range; joysticks that come, go or cannot be used.
    """

    def __init__(self) -> None:
        self._phases: dict[str, LinkPhase] = {}
        self._lacking: dict[str, Mapping[str, str]] = {}
        self._had: dict[str, set[str]] = {}
        self._since: dict[tuple[str, str], float] = {}
        self._unfit: dict[str, frozenset[str]] = {}
        self._control: dict[str, ControlState] = {}
        self._refusals: dict[str, int] = {}
        self._tasks = TaskWatch()
        self._missions = MissionWatch()
        self._recordings = RecordingWatch()
        self._motions = MotionWatch()
        self._autopilots = AutopilotWatch()
        self._joysticks: dict[str, tuple[JoystickPhase, str]] = {}
        self._failed: set[str] = set()

    def look(self, state: ConsoleState) -> tuple[Notice, ...]:
        """The changes since the last call."""
        of_robots = (self._guarded(robot, state) for robot in state.robots.values())
        of_joysticks = (self._joystick_changes(each, state) for each in state.joysticks.values())
        return tuple(notice for some in (*of_robots, *of_joysticks) for notice in some)

    def _guarded(self, robot: RobotState, state: ConsoleState) -> tuple[Notice, ...]:
        """The changes of one robot; a fault there must not hide the changes of another robot."""
        try:
            return tuple(self._robot_changes(robot, state))
        except Exception:
            if robot.name in self._failed:
                return ()
            self._failed.add(robot.name)
            _logger.exception("the state of %s cannot be compared", robot.name)
            text = "its state cannot be compared with the last one; the log says why"
            return (state.notice(text, robot=robot.name, alarm=True),)

    def _joystick_changes(self, joystick: JoystickState, state: ConsoleState) -> Iterator[Notice]:
        name, device = joystick.name, joystick.device
        now = (joystick.phase, joystick.why)
        before = self._joysticks.get(name, (JoystickPhase.MISSING, ""))
        self._joysticks[name] = now
        if now == before:
            return
        lacking = f", {joystick.why}" if joystick.why else ""
        match joystick.phase:
            case JoystickPhase.CONNECTED:
                yield state.notice(f"{name} is {device}{lacking}", alarm=bool(lacking))
            case JoystickPhase.MISSING if before[0] is JoystickPhase.CONNECTED:
                gone = _GONE[joystick.absence].format(device)
                yield state.notice(f"{name} {gone}", alarm=True)
            case JoystickPhase.FORBIDDEN | JoystickPhase.UNSUITABLE:
                yield state.notice(f"{name} cannot be used: {joystick.why}", alarm=True)

    def _robot_changes(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        link, name = robot.link, robot.name
        before = self._phases.get(name, LinkPhase.CONNECTING)
        self._phases[name] = link.phase
        if link.phase is not before:
            if link.phase is LinkPhase.LOST:
                yield state.notice("the link is lost", robot=name, alarm=True)
            elif link.phase is LinkPhase.CONNECTED:
                again = " again" if before is LinkPhase.LOST else ""
                notice = state.notice(f"linked{again}", robot=name)
                yield dataclasses.replace(notice, quiet=not again)
        for message in sorted(link.unfit.keys() - self._unfit.get(name, frozenset())):
            yield state.notice(link.unfit[message], robot=name, alarm=True)
        self._unfit[name] = frozenset(link.unfit)
        if link.refusal_count != self._refusals.get(name, 0):
            self._refusals[name] = link.refusal_count
            yield state.notice(link.refusal, robot=name, alarm=True)
        yield from self._handed_over(robot, state)
        yield from self._motions.look(robot, state)
        yield from self._autopilots.look(robot, state)
        yield from self._tasks.look(robot, state)
        yield from self._missions.look(robot, state)
        yield from self._recordings.look(robot, state)
        if link.phase is LinkPhase.CONNECTED:
            yield from self._capabilities(robot, state)

    def _handed_over(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """Changes of control by other consoles, and their requests."""
        name, now = robot.name, control_of(robot)
        if now is None:
            return
        before = self._control.get(name, ControlState())
        self._control[name] = now
        if now.owner != before.owner:
            lost = before.owner == robot.link.number != 0
            text = f"{owner_words(robot)}: {now.why}"
            held = robot.newest(CONTROL_STATE)
            ago = now.held_s + held.age(state.now) if held is not None and now.owner else 0.0
            notice = state.notice(text, robot=name, alarm=lost and bool(now.owner), ago=ago)
            mine = standing(robot) is Standing.MINE
            yield dataclasses.replace(notice, quiet=mine or notice.past)
        elif before.asker and now.asker != before.asker:
            yield state.notice(now.why, robot=name)
        if now.asker and now.asker != before.asker:
            yield self._request(robot, now, state)

    @staticmethod
    def _request(robot: RobotState, control: ControlState, state: ConsoleState) -> Notice:
        """A request for control; an alarm if this console must answer it."""
        left = f"{seconds_left(robot, state.now)} s to answer"
        if asks(robot):
            return state.notice(
                f"{control.operator} is asked for control: {left}", robot=robot.name
            )
        here = standing(robot) is Standing.MINE
        keys = ", ".join(answer_keys(robot, state)) if here else ""
        text = f"{control.asker_operator} asks {'you' if here else control.operator} for control"
        words = "; ".join(filter(None, (f"{text}: {left}", keys)))
        return state.notice(words, robot=robot.name, alarm=here)

    def _capabilities(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """Capabilities that are missing, and those that are back."""
        name, now = robot.name, robot.link.lacking
        reported = dict(self._lacking.get(name, {}))
        had = self._had.setdefault(name, set())
        since = {each: self._since.get((name, each), state.now) for each in now}
        self._since = {key: at for key, at in self._since.items() if key[0] != name}
        self._since |= {(name, each): at for each, at in since.items()}
        for capability, lack in now.items():
            why, absent = lack.why, lack.kind is LackKind.ABSENT
            if absent and capability not in had and not can_have(robot.body, capability):
                continue
            new = reported.get(capability) != why
            lasting = lack.kind is not LackKind.COMING and state.now - since[capability] >= GRACE_S
            if new and (lasting or capability in had):
                reported[capability] = why
                text = f"it does not provide {capability}: {why}"
                yield state.notice(text, robot=name, alarm=not absent or capability in had)
        for capability in [known for known in reported if known not in now]:
            del reported[capability]
            yield state.notice(f"it provides {capability} again", robot=name)
        self._lacking[name] = reported
        reports = robot.newest(CAPABILITY_REPORTS)
        had |= {
            report.name
            for report in (reports.value.capabilities if reports else ())
            if report.phase is CapabilityPhase.RUNNING
        }
