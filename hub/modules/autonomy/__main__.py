"""The autonomy process: reads the state of the robot and sends navigation to places."""

from __future__ import annotations

import dataclasses
import logging
import sys
import time
from collections import deque

import numpy as np

from hub.control_gate import ControlGate
from hub.errors import CodecError, QueryError
from hub.gcm import autonomy, mapping, navigation
from hub.gcm.beam_scans import LARGEST_TILT
from hub.gcm.beams import beams_of
from hub.gcm.capability import Abilities, Capability
from hub.gcm.control import ControlState
from hub.gcm.geometry import TwistStamped
from hub.grids.grid import grid_of
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.modules.autonomy.autonomy_driver import AutonomyDriver
from hub.modules.autonomy.novelty import Limits
from hub.robots.description import RobotDescription
from hub.runtime import publish_on_request, run_module, stop_after_sleep
from hub.vehicle_watch import VehicleWatch

_logger = logging.getLogger(__name__)

_ACT_PERIOD = 0.1
_STATE_PERIOD = 1.0 / autonomy.AUTONOMY_STATE.rate_hz
_MAP_TIMEOUT = 2.0
_MOST_NUMBERS = 8
"""Most own numbers that are remembered; central draws them by chance, so none comes twice."""
_NO_RANGES = (
    "it has no range sensors that look along the ground, so it cannot make a map to explore"
)


class Autonomy:
    """Connects the autonomy driver with the bus."""

    def __init__(self, client: Client, robot: RobotDescription) -> None:
        self._client = client
        self._clock = time.monotonic
        limits = Limits(
            seconds=robot.nothing_new_s,
            share=robot.nothing_new_share,
            longest=robot.longest_exploring_s,
        )
        self._pilot = AutonomyDriver(
            radius=robot.radius + robot.margin, seed=robot.seed, limits=limits
        )
        self._numbers: deque[int] = deque(maxlen=_MOST_NUMBERS)
        self._said = ""
        self._why = ""
        self._cannot_explore = "" if _maps(robot) else _NO_RANGES
        self._gate = ControlGate(client, self._on_owner_change)
        self._vehicle = VehicleWatch(client, self._not_followed)
        client.subscribe(autonomy.AUTONOMY_COMMAND, self._command)
        client.subscribe(navigation.STOP, lambda message, _: self._stop(message.reason))
        stop_after_sleep(client, self._stop)
        client.subscribe(navigation.VELOCITY_COMMAND, self._stick)
        client.subscribe(navigation.ROBOT_STATE, self._robot)
        client.subscribe(navigation.NAVIGATION_STATUS, self._navigation)
        client.define(navigation.GOAL_COMMAND, autonomy.AUTONOMY_STATE, mapping.MAP_REQUEST)
        publish_on_request(client, autonomy.AUTONOMY_STATE, self._publish)
        client.every(_ACT_PERIOD, self._act)
        client.every(_STATE_PERIOD, self._publish)

    def finish(self) -> None:
        """Stop navigation, if it drives for autonomy."""
        self._pilot.command(autonomy.AutonomyCommand(), self._clock())
        self._act()

    def _command(self, command: autonomy.AutonomyCommand, reception: MessageInfo) -> None:
        if not self._gate.admits(autonomy.AUTONOMY_COMMAND, reception):
            return
        self._pilot.command(command, self._clock(), self._refusal(command.behaviour))
        _logger.info("asked for %s", command.behaviour.name)
        self._act()

    def _stop(self, reason: str) -> None:
        self._pilot.see_stop(reason, self._clock())
        self._act()

    def _on_owner_change(self, state: ControlState, before: int) -> None:
        """Another client has control than before; a new owner gets a robot at rest."""
        if state.owner and before:
            self._pilot.see_other(f"{state.operator} has control now", self._clock())
            self._act()

    def _not_followed(self, why: str) -> None:
        """End the task: when the vehicle follows again, it begins to move only on an order."""
        self._pilot.see_other(why, self._clock(), autonomy.Phase.LOST)
        self._act()

    def _refusal(self, behaviour: autonomy.Behaviour) -> str:
        """Why the robot cannot do this now, for people; empty: it can."""
        if behaviour is autonomy.Behaviour.HOLD:
            return ""
        explores = behaviour is autonomy.Behaviour.EXPLORE
        return (self._cannot_explore if explores else "") or self._vehicle.why

    def _stick(self, command: TwistStamped, reception: MessageInfo) -> None:
        sender = reception.publisher
        if not command.neutral and sender != self._client.number and self._gate.obeys(sender):
            self._pilot.see_stick(self._clock())
            self._act()

    def _robot(self, state: navigation.RobotState, reception: MessageInfo) -> None:
        self._pilot.see_robot(state, reception.measured)

    def _navigation(self, status: navigation.NavigationStatus, _reception: MessageInfo) -> None:
        self._note_number()
        mine = status.sender in self._numbers
        self._pilot.see_navigation(status, self._clock(), mine=mine)
        self._act()

    def _note_number(self) -> None:
        """Note this client's number, which a new connection changes while a goal goes on."""
        number = self._client.number
        if number and number not in self._numbers:
            self._numbers.append(number)

    def _act(self) -> None:
        now = self._clock()
        if self._pilot.wants_map(now):
            self._ask_for_map()
        goal = self._pilot.act(now)
        if goal is not None:
            self._note_number()
            self._client.publish(navigation.GOAL_COMMAND, goal)
        if _shown(self._pilot.state(now)) != self._said:
            self._publish()

    def _ask_for_map(self) -> None:
        def answered(message: mapping.Map, _reception: MessageInfo) -> None:
            try:
                grid = grid_of(message)
            except CodecError as error:
                self._pilot.miss_map(str(error))
            else:
                self._pilot.see_map(grid, self._clock())

        def failed(error: QueryError) -> None:
            self._pilot.miss_map(str(error))

        self._client.query_notify(
            mapping.MAP_REQUEST,
            mapping.MapRequest(),
            mapping.MAP,
            timeout=_MAP_TIMEOUT,
            answered=answered,
            failed=failed,
        )

    def _publish(self) -> None:
        state = self._pilot.state(self._clock())
        self._note_number()
        state = dataclasses.replace(state, sender=self._numbers[-1] if self._numbers else 0)
        if state.why != self._why:
            _logger.info("%s: %s", state.behaviour.name, state.why)
        self._said, self._why = _shown(state), state.why
        self._client.publish(autonomy.AUTONOMY_STATE, state)


def _shown(state: autonomy.AutonomyState) -> str:
    """The visible part of a state; equal ones are not published again."""
    goal = f"{state.x:.2f} {state.y:.2f} {state.frontier_m:.1f}"
    return f"{state.behaviour} {state.pilot} {state.phase} {goal} {state.why}"


def _maps(robot: RobotDescription) -> bool:
    """Whether the robot makes a map: from its range sensors, or with its own navigation."""
    level = np.abs(beams_of(robot.body).elevation) <= LARGEST_TILT
    return bool(robot.ros.map) or bool(level.any())


def abilities(_robot: RobotDescription) -> Abilities:
    """The abilities of autonomy on a robot."""
    return Abilities(
        provides=(Capability.AUT_PILOT,),
        needs=(Capability.NAV_GOAL, Capability.NAV_STATE, Capability.PRO_MAP),
    )


def main() -> int:
    """Run the process."""
    purpose = "Explores, goes, returns and wanders by itself, until the operator takes over."
    return run_module(
        "autonomy", purpose, abilities, lambda client, robot: Autonomy(client, robot).finish
    )


if __name__ == "__main__":
    sys.exit(main())
