"""visualizeVehicle: what a vehicle does, holds and has: arming, joints, lights, tether, trim."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from typing import ClassVar

from hub.gcm.body import ROBOT_DESCRIPTION, HoldKind
from hub.gcm.joints import JOINT_STATES
from hub.gcm.vehicle import VEHICLE_STATE, Arming, HoldPhase, HoldState, VehicleState
from hub.gcm.vision import CAMERA_STATE
from rune_tui.layout.rules import VisualizerRule
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import brightness, joint_angle
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.fitting import write_fitted
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.parts.staleness import age_look, draw_age, pause_of
from rune_tui.visualizers.visualizer import PlainVisualizer

_PAUSE_S = pause_of(VEHICLE_STATE)
_FULL = 0.9
"""From this share on a tether that is out is said as a warning."""
_TURNS = 2.0
"""From this many turns on a twist of the tether is said as a warning."""


class VisualizeVehicle(PlainVisualizer):
    """A row each: what it does, its holds, joints, lights, tether, and the trim."""

    rule: ClassVar = VisualizerRule(
        meaning="what the vehicle does: whether it is armed, what it holds and how far it is off, "
        "its joints, lights and tether, and the trim of your controls",
        message=VEHICLE_STATE.name,
        others=(JOINT_STATES.name, CAMERA_STATE.name, ROBOT_DESCRIPTION.name),
    )
    urgency: ClassVar[Urgency] = Urgency.DRIVE

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        """Write the rows that fit, what fails first."""
        canvas.fill(state.theme.panel)
        write_fitted(canvas, _parts(robot, state), state.theme)
        known = robot.newest(VEHICLE_STATE)
        if known is not None:
            draw_age(canvas, known.age(state.now), state.theme, _PAUSE_S)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        """Changes with any word, and with the fading of its age."""
        known = robot.newest(VEHICLE_STATE)
        look = known and age_look(known, state.now, _PAUSE_S)
        return _parts(robot, state), look, state.theme.name


def _parts(robot: RobotState, state: ConsoleState) -> tuple[Part, ...]:
    known = robot.newest(VEHICLE_STATE)
    if known is None:
        return (Part("no state of the vehicle", 0, Severity.FAINT),)
    vehicle = known.value
    parts = [_activity(vehicle), *(_hold(each) for each in vehicle.holds)]
    parts += [*_joints(robot), *_lights(robot), *_tether(vehicle)]
    trims = [f"{name} {trim:+.3g}" for name, trim in state.trim(robot.name).items() if trim]
    parts += [Part(f"trim {', '.join(trims)}", 4)] * bool(trims)
    return tuple(parts)


def _activity(vehicle: VehicleState) -> Part:
    armed = {Arming.NONE: "", Arming.ARMED: ", armed", Arming.DISARMED: ""}[vehicle.arming]
    if vehicle.arming is Arming.DISARMED:
        return Part("DISARMED: its motors are off", 9, Severity.WARNING)
    targets = "".join(f" {target_words(hold)}" for hold in vehicle.holds if _is_kept(hold))
    return Part(f"{vehicle.activity.upper()}{targets}{armed}", 7)


def _is_kept(hold: HoldState) -> bool:
    return hold.phase is HoldPhase.HOLDING and math.isfinite(hold.target)


def target_words(hold: HoldState) -> str:
    """What a hold keeps, shortly: "1.2 m", or a heading of a compass, "034"."""
    if hold.kind is HoldKind.HEADING:
        # Where north is, is a layout's matter; 90 deg from x, as the compass has it.
        return f"{round(90.0 - math.degrees(hold.target)) % 360:03d}"
    return f"{hold.target:.1f} m"


def _hold(hold: HoldState) -> Part:
    name = hold.kind.name.lower()
    if hold.phase is HoldPhase.OFF:
        return Part(f"{name}: no hold", 2, Severity.FAINT)
    if hold.phase is HoldPhase.READY or not math.isfinite(hold.target):
        return Part(f"{name}: holds when you let go", 1, Severity.FAINT)
    if not math.isfinite(hold.error):
        off = ""
    elif hold.kind is HoldKind.HEADING:
        # Headings of a compass go the other way round.
        off = f" ({0.0 - round(math.degrees(hold.error)):+.0f} deg)"
    else:
        off = f" ({round(hold.error, 2) + 0.0:+.2f} m)"
    if hold.phase is HoldPhase.FAILING:
        text = f"{name}: HOLD FAILS {target_words(hold)}{off}"
        return Part(text, 8, Severity.WARNING, short=f"{name} FAILS {target_words(hold)}")
    text = f"{name}: holds {target_words(hold)}{off}"
    return Part(text, 6, Severity.GOOD, short=f"{name} {target_words(hold)}")


def _lights(robot: RobotState) -> Iterator[Part]:
    for light in robot.body.lights if robot.body is not None else ():
        lit = brightness(robot, light)
        if lit > 0.0:
            yield Part(f"{light.name} {lit:.0%}", 4)
        else:
            yield Part(f"{light.name} {'?' if math.isnan(lit) else 'off'}", 2, Severity.FAINT)


def _joints(robot: RobotState) -> Iterator[Part]:
    for joint in robot.body.joints if robot.body is not None else ():
        angle = joint_angle(robot, joint.name)
        words = "?" if math.isnan(angle) else f"{math.degrees(angle):+.0f} deg"
        yield Part(f"{joint.name} {words}", 5)


def _tether(vehicle: VehicleState) -> Iterator[Part]:
    if not math.isfinite(vehicle.tether_length + vehicle.tether_paid):
        return
    turns = vehicle.tether_turns
    words = f"tether {vehicle.tether_paid:.1f} of {vehicle.tether_length:.0f} m"
    if abs(turns) >= 0.05:
        words += f", {abs(turns):.1f} turns {'left' if turns > 0.0 else 'right'}"
    used = vehicle.tether_paid > _FULL * vehicle.tether_length
    severity = Severity.WARNING if used or abs(turns) > _TURNS else Severity.PLAIN
    yield Part(words, 8 if severity is Severity.WARNING else 3, severity)
