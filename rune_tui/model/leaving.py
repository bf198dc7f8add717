"""Reasons against the end of the console: unsaved data, and robots that move or stay armed."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from typing import Final

from hub.gcm.navigation import MotionState
from hub.gcm.vehicle import Arming
from rune_tui.layout.rules import Purpose
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.control import Standing, standing
from rune_tui.model.effects import SendEffect
from rune_tui.model.mission import mission_of
from rune_tui.model.vehicle import autopilot_of, vehicle_of

ORDERED_S: Final = 3.0
"""Time after an order to go in which a robot counts as moving, even without a report [s]."""


def ordered(state: ConsoleState, effect: SendEffect, now: float) -> ConsoleState:
    """The state with an order to go somewhere, before the robot reports it.

    Args:
        state: The state before.
        effect: The order; nothing changes if it sends no robot anywhere.
        now: The time [s].
    """
    if not effect.sent_off:
        return state
    return dataclasses.replace(state, sent_off={**state.sent_off, effect.sent_off: now})


def reasons_to_stay(state: ConsoleState) -> tuple[str, ...]:
    """Why the console asks before it ends; empty if it may end at once."""
    return tuple(reason for found in _REASONS for reason in found(state))


def _recording(state: ConsoleState) -> Iterator[str]:
    if state.recording:
        yield "the recording ends"


def _moving_robots(state: ConsoleState) -> Iterator[str]:
    """Robots of this console that move by themselves."""
    for robot in state.robots.values():
        going = robot.navigation is not None and robot.navigation.value.motion is MotionState.GOING
        # The robot's state does not show a new order yet.
        ordered = state.now - state.sent_off.get(robot.name, -math.inf) < ORDERED_S
        moves = going or ordered
        if moves and standing(robot) is not Standing.OTHERS:
            yield f"{state.title(robot.name)} goes on by itself, and nobody watches it"


def _armed_vehicles(state: ConsoleState) -> Iterator[str]:
    """Vehicles of this console whose autopilot has armed motors."""
    for robot in state.robots.values():
        autopilot, vehicle = autopilot_of(robot), vehicle_of(robot)
        armed = vehicle is not None and vehicle.arming is Arming.ARMED
        if autopilot is not None and armed and standing(robot) is not Standing.OTHERS:
            key = state.input_of(Purpose.DISARM, robot.name)
            disarms = f" ({key.upper()} disarms it)" if key else ""
            yield f"{state.title(robot.name)} STAYS ARMED, and nobody drives it{disarms}"


def _unsaved(state: ConsoleState) -> Iterator[str]:
    """Marks without confirmation, and missions that robots cannot save."""
    waiting = sum(state.unconfirmed.values())
    if waiting:
        marks = "1 mark is" if waiting == 1 else f"{waiting} marks are"
        yield f"{marks} lost, which no robot has confirmed"
    for robot in state.robots.values():
        mission = mission_of(robot)
        if mission is not None and mission.unkept:
            title = state.title(robot.name)
            yield f"nobody sees that {title} does not keep its mission: {mission.fault}"


_REASONS: tuple[Callable[[ConsoleState], Iterator[str]], ...] = (
    _recording,
    _moving_robots,
    _armed_vehicles,
    _unsaved,
)
"""Functions that give reasons against the end."""


def question(reasons: tuple[str, ...]) -> str:
    """The question to the operator; empty: there is no reason against the end."""
    if not reasons:
        return ""
    return f"QUIT? Then {'; '.join(reasons)}. Q or enter: quit. Any other key: stay."
