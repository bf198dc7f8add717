"""What happens to robots that the operator must see, told once each."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping

from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityPhase
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.robot_state import LinkPhase, RobotState

_TRANSIENT = frozenset({"starting", "not started yet"})
"""Why a capability is not there yet, of which nothing needs to be said at the start."""

GRACE_S = 4.0
"""What is missing for no longer than this is not told of: hubs begin so [s]."""


class Watch:
    """Compares what is known of each robot with what was known before.

    Links that are lost and found, wanted capabilities that a robot does not provide, and messages
    that say more than the console takes.
    """

    def __init__(self) -> None:
        self._phases: dict[str, LinkPhase] = {}
        self._lacking: dict[str, Mapping[str, str]] = {}
        self._had: dict[str, set[str]] = {}
        self._since: dict[tuple[str, str], float] = {}
        self._cut: dict[str, frozenset[str]] = {}

    def look(self, state: ConsoleState) -> tuple[Notice, ...]:
        """What has happened since the last look."""
        return tuple(notice for robot in state.robots.values() for notice in self._of(robot, state))

    def _of(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
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
        for message in sorted(link.cut - self._cut.get(name, frozenset())):
            text = f"{message} says more than can be shown: only part of it is"
            yield state.notice(text, robot=name, alarm=True)
        self._cut[name] = link.cut
        if link.phase is LinkPhase.CONNECTED:
            yield from self._capabilities(robot, state)

    def _capabilities(self, robot: RobotState, state: ConsoleState) -> Iterator[Notice]:
        """Capabilities that are missing, and those that are back."""
        name, now = robot.name, robot.link.lacking
        told = dict(self._lacking.get(name, {}))
        had = self._had.setdefault(name, set())
        since = {each: self._since.get((name, each), state.now) for each in now}
        self._since = {key: at for key, at in self._since.items() if key[0] != name}
        self._since |= {(name, each): at for each, at in since.items()}
        for capability, why in now.items():
            new = told.get(capability) != why
            lasting = why not in _TRANSIENT and state.now - since[capability] >= GRACE_S
            if new and (lasting or capability in had):
                told[capability] = why
                reason = f": {why}" if why else ""
                text = f"it does not provide {capability}{reason}"
                yield state.notice(text, robot=name, alarm=True)
        for capability in [known for known in told if known not in now]:
            del told[capability]
            yield state.notice(f"it provides {capability} again", robot=name)
        self._lacking[name] = told
        reports = robot.newest(CAPABILITY_REPORTS)
        had |= {
            report.name
            for report in (reports.value.capabilities if reports else ())
            if report.phase is CapabilityPhase.RUNNING
        }
