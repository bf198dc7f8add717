"""What navigation knows to be wrong, and the edges that it knows; pure."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hub.gcm.beam_scans import TILTED_REACH
from hub.gcm.diagnostics import SLEEP, DiagnosticStatus, KeyValue, Severity
from hub.gcm.edges import MOST_EDGES, Edges
from hub.gcm.geometry import Point3D
from hub.gcm.navigation import VELOCITY_COMMAND, Assistance
from hub.gcm.standard import Header
from hub.modules.navigation.ground_memory import CELL
from hub.modules.navigation.path_follower import CAREFUL_SPEED, PathFollower

EDGE_NEAR = 1.5
"""An edge within this distance of the robot is reported [m]."""
_LONGEST_NAME = 64
_LATE_S = 2.0
"""Time for which a command that came too late is a problem [s]."""
_SLEPT_S = 10.0
"""Time for which a sleep of the robot's computer is a problem [s]."""
_SIDES = ("ahead", "on the left", "behind", "on the right")


def problems(pilot: PathFollower, now: float) -> tuple[DiagnosticStatus, ...]:
    """The present problems."""
    found = []
    assisted = pilot.assistance(now) is Assistance.ON
    if pilot.tilt:
        text = f"tilted by {math.degrees(pilot.tilt):.0f} degrees: the map gets no ranges"
        if assisted:
            text += f", assistance sees {TILTED_REACH:.0f} m far and drives {CAREFUL_SPEED:g} m/s"
        found.append(DiagnosticStatus(level=Severity.WARN, name="tilt", message=text))
    found += _silent_ranges(pilot, assisted=assisted)
    x, y = pilot.edges
    away = pilot.away(x, y)
    if len(away) and away.min() <= EDGE_NEAR:
        nearest = int(away.argmin())
        side = _SIDES[round(math.atan2(y[nearest], x[nearest]) / (math.pi / 2)) % 4]
        metres = max(float(away[nearest]), 0.0)
        text = f"edge {metres:.1f} m {side}" + ("" if assisted else ", and assistance is off")
        value = KeyValue(key="distance", value=f"{metres:.2f}")
        found.append(
            DiagnosticStatus(level=Severity.WARN, name="edge", message=text, values=(value,))
        )
    return tuple(found)


class Lately:
    """What happened of late, which the present state does not show."""

    def __init__(self) -> None:
        self._late = (0.0, -math.inf)
        self._slept = ("", -math.inf)

    def came_late(self, age: float, now: float) -> None:
        """Note that a command of motion was refused because of its age [s]."""
        self._late = (age, now)

    def slept(self, why: str, now: float) -> None:
        """Note that the robot's computer slept; `why` says so in a sentence."""
        self._slept = (why, now)

    def problems(self, now: float) -> Iterator[DiagnosticStatus]:
        """The problems at `now` [s]."""
        age, at = self._late
        if now - at < _LATE_S:
            lifespan = VELOCITY_COMMAND.lifespan_s
            text = (
                f"a command came too late to drive: up to {age:.2f} s old, "
                f"{lifespan:g} s is the most"
            )
            value = KeyValue(key="age_s", value=f"{age:.2f}")
            yield DiagnosticStatus(
                level=Severity.ERROR, name="late commands", message=text, values=(value,)
            )
        why, at = self._slept
        if now - at < _SLEPT_S:
            yield DiagnosticStatus(level=Severity.WARN, name=SLEEP, message=why)


def _silent_ranges(pilot: PathFollower, *, assisted: bool) -> Iterator[DiagnosticStatus]:
    blind = pilot.senses.blind
    meaning = "assistance sees no obstacle" if blind else "obstacles that it alone sees are missed"
    for name, seconds in pilot.senses.silent.items():
        text = f"range sensor {name} is silent: {meaning}"
        if assisted:
            text += f", and drives {CAREFUL_SPEED:g} m/s"
        yield DiagnosticStatus(
            level=Severity.ERROR if blind else Severity.WARN,
            name=f"range {name}"[:_LONGEST_NAME],
            message=text,
            hardware_id=name,
            values=(KeyValue(key="silent_s", value=f"{seconds:.1f}"),),
        )


def known_edges(pilot: PathFollower) -> Edges:
    """The message of all known edges, in `map`."""
    x, y = pilot.pose.outward(*pilot.edges)
    step = 1 + len(x) // MOST_EDGES
    places = np.stack((x, y), axis=1)[::step].tolist()
    return Edges(
        header=Header(frame_id="map"),
        cell_width=CELL,
        cell_height=CELL,
        cells=tuple(Point3D(x=x, y=y) for x, y in places),
    )
