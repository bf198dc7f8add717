"""`rune-hub halt`: stop the robot, and wait until it reports that it stands."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence

from hub.command_line import ExitCode, login_name
from hub.command_output import print_error, put, put_json
from hub.errors import HubError
from hub.gcm.control import CONTROL_STATE, PLAYED, ControlState
from hub.gcm.navigation import ROBOT_STATE, STOP, MotionState, RobotState, Stop
from hub.hub_sockets import RunningHub
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo

LIMIT_S = 2.0
"""A robot that does not stand after this time still moves [s]."""
STILL_M_S = 0.01
"""A robot that is slower than this stands [m/s]."""
STILL_RAD_S = 0.02
"""A robot that turns more slowly than this stands [rad/s]."""
_ROUND_TRIPS = 8
"""Round trips that may pass as well: stops and reports need connections first."""
_REPEAT_S = 0.1
_MOVING = (MotionState.MOVING, MotionState.GOING, MotionState.NO_DRIVER)


class Halt:
    """The robot's reports since the first stop; pure.

    Attributes:
        report: The newest report; None: none arrived.
        seen: Whether the robot has reported a stop.
        played: Whether the hub plays a recording.
    """

    def __init__(self, limit: float = LIMIT_S) -> None:
        """Wait for `limit` [s]."""
        self._limit = limit
        self.report: RobotState | None = None
        self.seen = False
        self.played = False
        self._stops_before: int | None = None

    def take(self, report: RobotState) -> None:
        """Take a report of the robot."""
        if self._stops_before is None:
            self._stops_before = report.stops
        # A console that sends neutral ends the state STOPPED at once, but the count stays.
        stopped = report.motion is MotionState.STOPPED or report.stops != self._stops_before
        self.seen = self.seen or stopped
        self.report = report

    @property
    def stands(self) -> bool:
        """Whether the robot has reported a stop, and that it stands."""
        report = self.report
        return (
            self.seen
            and not self.played
            and report is not None
            and report.motion not in _MOVING
            and report.commanded_linear == report.commanded_angular == 0.0
            and abs(report.linear) < STILL_M_S
            and abs(report.angular) < STILL_RAD_S
        )

    def problem(self) -> str:
        """A sentence with the reason why it does not stand, and the remedy."""
        if self.played:
            return "this hub plays a recording, so no robot was stopped; nothing moves there"
        report = self.report
        if report is None:
            return (
                "the robot reports nothing, so it may still move; "
                "`rune-hub modules` shows whether navigation runs"
            )
        if report.motion is MotionState.NO_DRIVER:
            return (
                "the driver reports nothing, so the robot may still move; "
                "`rune-hub modules` shows why"
            )
        what = "still moves" if self.seen else "has not reported a stop"
        speeds = f"{report.linear:.2f} m/s, {report.angular:.2f} rad/s"
        return f"the robot {what} after {self._limit:.0f} s ({speeds}); use its emergency stop"


def halt(client: Client, *, as_json: bool, hub: str = "") -> int:
    """Stop the robot until a neutral command.

    Sends stops until the robot has reported one, because a single stop may be lost.

    Args:
        client: Connected to the robot's hub.
        as_json: Whether to report as JSON.
        hub: Name of the hub, for what is written; empty: it is the only one.

    Returns:
        The exit code: 1 if the robot does not report in time that it stands, and where a recording
        is played.
    """
    round_trip = 0.0 if math.isnan(client.round_trip) else client.round_trip
    limit = LIMIT_S + _ROUND_TRIPS * round_trip
    course = Halt(limit)
    stop = Stop(reason=f"rune-hub halt {login_name()}".rstrip())
    client.demand_right(STOP)
    client.define(STOP)
    begun = time.monotonic()

    def take(report: RobotState, how: MessageInfo) -> None:
        if how.measured >= begun:
            course.take(report)

    def look(control: ControlState, how: MessageInfo) -> None:
        # On a robot the owner is a console, never the hub that says so.
        course.played = control.owner_name == PLAYED and control.owner == how.publisher

    def send() -> None:
        if not course.seen:
            client.publish(STOP, stop)

    send()
    client.subscribe(ROBOT_STATE, take)
    client.subscribe(CONTROL_STATE, look)
    timer = client.every(_REPEAT_S, send)
    while not course.stands and time.monotonic() < begun + limit:
        client.listen(_REPEAT_S)
    timer.cancel()
    lasted = time.monotonic() - begun
    if as_json:
        problem = "" if course.stands else course.problem()
        put_json(halt_facts(course.report, hub=hub, seconds=lasted, problem=problem))
    prefix = f"{hub}: " if hub else ""
    if not course.stands:
        print_error(prefix + course.problem())
        return 1
    if not as_json:
        text = f"the robot stands, {lasted:.1f} s after the first stop; it waits for neutral"
        put(prefix + text)
    return 0


def halt_facts(
    report: RobotState | None, *, hub: str, seconds: float, problem: str
) -> dict[str, object]:
    """What a stop reports as JSON; speeds are null where they are not known.

    Args:
        report: The newest report of the robot; None: there is none.
        hub: Name of the hub; empty: it is the only one.
        seconds: How long the stop took [s].
        problem: Why the robot does not stand, as far as is known; empty: it stands.
    """
    named = {"hub": hub} if hub else {}
    return {
        **named,
        "stands": not problem,
        "seconds": round(seconds, 3),
        "linear": report.linear if report else None,
        "angular": report.angular if report else None,
        "problem": problem or None,
    }


def halt_each(hubs: Sequence[RunningHub], halt_one: Callable[[RunningHub], int]) -> int:
    """Stop the robots of several hubs at the same time; the largest exit code.

    A hub that does not answer must not delay the stop of another robot.

    Args:
        hubs: The hubs.
        halt_one: Stops the robot of a hub; returns the exit code.
    """
    codes: list[int] = []

    def stop(hub: RunningHub) -> None:
        try:
            codes.append(halt_one(hub))
        except HubError as error:
            print_error(f"{hub.name}: {error}")
            codes.append(ExitCode.NO_HUB)

    threads = [threading.Thread(target=stop, args=(hub,), daemon=True) for hub in hubs]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    return max(codes) if len(codes) == len(hubs) else ExitCode.FAULT
