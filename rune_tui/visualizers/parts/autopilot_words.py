"""What a robot's autopilot does and measures, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from hub.gcm.autopilot import AutopilotPhase, AutopilotState, UnsafeParameter
from hub.gcm.vehicle import Arming
from rune_tui.model.robot_state import RobotState
from rune_tui.model.vehicle import autopilot_of, vehicle_of
from rune_tui.visualizers.parts.severity import Part, Severity
from rune_tui.visualizers.parts.staleness import age_text

ARMED: Final = frozenset({AutopilotPhase.DRIVING, AutopilotPhase.ELSEWHERE})
"""The phases of an armed vehicle."""
PHASES: Final = {
    AutopilotPhase.LINKING: "NO AUTOPILOT YET",
    AutopilotPhase.LEARNING: "asks it for all",
    AutopilotPhase.DISARMED: "",
    AutopilotPhase.ARMING: "is armed now",
    AutopilotPhase.DRIVING: "follows you",
    AutopilotPhase.ELSEWHERE: "does not follow",
    AutopilotPhase.GONE: "GONE",
}
"""What can be done with a vehicle now; a disarmed one says so itself."""
_SHORT_PHASES: Final = {
    AutopilotPhase.DRIVING: "follows",
    AutopilotPhase.ELSEWHERE: "not driven",
}
_ASKED: Final = (AutopilotPhase.DISARMED, AutopilotPhase.ARMING, AutopilotPhase.DRIVING)
"""The phases of a vehicle that was asked for all, in which its times to stop hold."""
_SILENT_S: Final = 1.5
"""Age of a heartbeat that is a caution: they come every second [s]."""
_SLOW_S: Final = 0.3
"""Time of an echo that is a caution [s]."""
_SOME: Final = 0.01
_MUCH: Final = 0.2
"""Shares of lost echoes that are shown, and that are a caution."""
_NO_SATELLITES: Final = 255


def head_of(robot: RobotState, autopilot: AutopilotState) -> Part:
    """Whether it is armed, its mode, and what can be done with it."""
    vehicle = vehicle_of(robot)
    armed = autopilot.phase in ARMED or (
        autopilot.phase in (AutopilotPhase.LEARNING, AutopilotPhase.GONE)
        and vehicle is not None
        and vehicle.arming is Arming.ARMED
    )
    words = [PHASES[autopilot.phase]]
    severity = Severity.WARNING if armed else Severity.GOOD
    if autopilot.phase is AutopilotPhase.GONE:
        words.append("it was armed" if armed else "it was disarmed")
        severity = Severity.ALARM
    elif autopilot.phase is not AutopilotPhase.LINKING:
        words[:0] = ["ARMED" if armed else "DISARMED", autopilot.mode]
    known = [*filter(None, words)]
    return Part(" · ".join(known), 10, severity, short=" · ".join(known[:2]))


def shorter_heads(head: Part, autopilot: AutopilotState) -> tuple[str, ...]:
    """The words of `head_of`, and fewer of them: whether it follows is left out last."""
    follows = _SHORT_PHASES.get(autopilot.phase, "")
    forms = (f"{head.short} · {follows}", f"{head.short} {follows}") if follows else ()
    return (head.text, *forms, head.short)


def autopilot_parts(
    robot: RobotState, autopilot: AutopilotState, follow: str = ""
) -> Iterator[Part]:
    """A row each, after `head_of`.

    Args:
        robot: The robot.
        autopilot: What its autopilot does.
        follow: The key that asks it to follow the operator; empty: none does.
    """
    if autopilot.why:
        still = autopilot.phase is AutopilotPhase.DISARMED and autopilot.armable
        key = f" ({follow})" if follow and autopilot.phase is AutopilotPhase.ELSEWHERE else ""
        yield Part(autopilot.why + key, 9, Severity.PLAIN if still else Severity.WARNING)
    if autopilot.failsafe:
        yield Part("A FAILSAFE ACTS", 9, Severity.ALARM)
    yield from _stops(autopilot)
    if autopilot.phase is AutopilotPhase.LINKING:
        return
    yield _link(autopilot)
    if autopilot.phase is not AutopilotPhase.GONE:  # else it was so, and may be no longer
        yield _place(autopilot)
        yield from _battery(robot)
        if math.isfinite(autopilot.gain):
            yield Part(f"sticks have {autopilot.gain:.0%} of their effect", 2)
    if autopilot.unsafe:
        yield Part(f"{unsafe_words(autopilot)}: see help", 6, Severity.WARNING)
    kind = autopilot.vehicle or "a vehicle of no known kind"
    named = ", ".join(filter(None, (kind, autopilot.firmware)))
    if autopilot.verified or not autopilot.vehicle:
        yield Part(named, 1, Severity.FAINT)
    else:
        said = "NOT VERIFIED, its rules follow documents only"
        yield Part(f"{named}: {said}", 5, Severity.WARNING, short=said)


def never_words(autopilot: AutopilotState) -> str:
    """That it never stops by itself; empty: it does, or that is not known."""
    after = [
        name
        for name, seconds in (
            ("a command of zero", autopilot.stops_after_zero_s),
            ("the link is cut", autopilot.stops_after_cut_s),
        )
        if math.isinf(seconds)
    ]
    return f"NEVER STOPS after {' or '.join(after)}" if after else ""


def unsafe_words(autopilot: AutopilotState) -> str:
    """How many parameters are unsafe, and how many were not read."""
    unread = sum(math.isnan(each.value) for each in autopilot.unsafe)
    count = len(autopilot.unsafe) - unread
    known = f"{count} unsafe parameter{'' if count == 1 else 's'}" if count else ""
    return ", ".join(filter(None, (known, f"{unread} NOT READ" if unread else "")))


def unsafe_lines(robot: RobotState) -> Iterator[tuple[str, str]]:
    """Each parameter that is unsafe or was not read, the value wanted, and why."""
    autopilot = autopilot_of(robot)
    for each in autopilot.unsafe if autopilot is not None else ():
        yield _change(each), each.why


def _change(parameter: UnsafeParameter) -> str:
    if math.isnan(parameter.value):
        return f"{parameter.name} was not read, has to be {parameter.wanted:.6g}"
    wanted = "" if math.isnan(parameter.wanted) else f", not {parameter.wanted:.6g}"
    return f"{parameter.name} {parameter.value:.6g}{wanted}"


def _stops(autopilot: AutopilotState) -> Iterator[Part]:
    if never := never_words(autopilot):
        yield Part(never, 9, Severity.ALARM)
    if autopilot.phase is AutopilotPhase.ELSEWHERE:
        return  # in a mode of its own it stops otherwise
    times = (
        (autopilot.stops_after_zero_s, "zero", "zero"),
        (autopilot.stops_after_cut_s, "the link is cut", "cut"),
    )
    known = [each for each in times if math.isfinite(each[0])]
    if all(math.isnan(seconds) for seconds, _, _ in times) and autopilot.phase in _ASKED:
        yield Part("TIMES TO STOP NOT KNOWN", 7, Severity.WARNING)
    if known:
        stops = "will stop" if autopilot.phase is AutopilotPhase.DISARMED else "stops"
        after = ", ".join(f"{seconds:.1f} s after {what}" for seconds, what, _ in known)
        short = ", ".join(f"{word} {seconds:.1f} s" for seconds, _, word in known)
        yield Part(f"{stops} {after}", 7, short=f"stops: {short}")


def _link(autopilot: AutopilotState) -> Part:
    heard = autopilot.heard_s
    words = ["not heard" if math.isnan(heard) else f"heard {age_text(heard)} ago"]
    if math.isfinite(autopilot.round_trip_s):
        words.append(f"echo {max(1.0, 1000.0 * autopilot.round_trip_s):.0f} ms")
    if autopilot.lost >= _SOME:
        words.append(f"{autopilot.lost:.0%} lost")
    bad = autopilot.round_trip_s > _SLOW_S or autopilot.lost > _MUCH or not heard <= _SILENT_S
    severity = Severity.WARNING if bad else Severity.PLAIN
    return Part(", ".join(words), 5 if bad else 4, severity, short=", ".join(words[1:]))


def _place(autopilot: AutopilotState) -> Part:
    words = ["knows its place" if autopilot.position else "DOES NOT KNOW ITS PLACE"]
    if autopilot.satellites != _NO_SATELLITES:
        words.append(f"{autopilot.satellites} satellites")
    return Part(", ".join(words), 4, Severity.PLAIN if autopilot.position else Severity.WARNING)


def _battery(robot: RobotState) -> Iterator[Part]:
    known = robot.navigation
    if known is None:
        return
    words = []
    if math.isfinite(known.value.battery_fraction):
        words.append(f"{known.value.battery_fraction:.0%}")
    if math.isfinite(known.value.battery_voltage):
        words.append(f"{known.value.battery_voltage:.1f} V")
    if words:
        yield Part(f"battery {', '.join(words)}", 3)
