"""Sends the layout's wants to a robot, and keeps its missing capabilities.

A want lasts for a few intervals only, so it is repeated:

| event | sent next |
| --- | --- |
| new wants, or a restored link | at once, and each second, 2 times more |
| the end of an interval of `CON_REAL`, by default 6 s | then |
"""

from __future__ import annotations

from collections.abc import Callable

from hub.gcm.capability import Capability
from hub.gcm.supervision import (
    CAPABILITY_WANTS,
    LEASE_S,
    CapabilityPhase,
    CapabilityReports,
    CapabilityWants,
)
from hub.ipc.client import Client
from rune_tui.layout.names import CAPABILITY_INTERVALS_MS
from rune_tui.layout.spec import RobotSpec
from rune_tui.model.robot_state import Lack, LackKind

_USUAL_KEEP_ALIVE_S = CAPABILITY_INTERVALS_MS[Capability.CON_REAL] / 1000
_CHECK_S = 1.0
"""Time between two checks of the interval [s]."""
_REPEATED = 2
"""Number of repeats of new wants, once a second: the robot may be starting too."""
_LEASE_INTERVALS = 2.5
"""A lease lasts for this number of keep-alive intervals, because one keep-alive may be lost."""
_LACKS = {
    CapabilityPhase.AVAILABLE: Lack(kind=LackKind.COMING, why="not started yet"),
    CapabilityPhase.STARTING: Lack(kind=LackKind.COMING, why="starting"),
    CapabilityPhase.UNAVAILABLE: Lack(kind=LackKind.BROKEN, why="its modules cannot be started"),
}
_ABSENT = Lack(kind=LackKind.ABSENT, why="this robot has no module for it")
_UNDECLARED = Lack(kind=LackKind.COMING, why="its modules have not said yet what they can do")


class WantsLine:
    """Repeats the wants; used by the link's thread."""

    def __init__(self, client: Client, clock: Callable[[], float]) -> None:
        """Start without wants.

        Args:
            client: The link's.
            clock: The time [s].
        """
        self._client, self._clock = client, clock
        self._wanted: frozenset[str] = frozenset()
        self._interval_s = _USUAL_KEEP_ALIVE_S
        self._due, self._to_repeat = clock(), _REPEATED
        self._also: dict[str, float] = {}

    def begin(self) -> None:
        """Send wants from now on."""
        self._client.define(CAPABILITY_WANTS)
        self._client.every(_CHECK_S, self._check)

    def follow(self, spec: RobotSpec) -> None:
        """Set the layout's wants."""
        wanted = {capability.name: capability for capability in spec.capabilities}
        self._wanted = frozenset(wanted)
        self._due, self._to_repeat = self._clock(), _REPEATED
        real_time = wanted.get(Capability.CON_REAL)
        self._interval_s = real_time.interval_s if real_time else _USUAL_KEEP_ALIVE_S

    def want_also(self, capability: str, seconds: float) -> None:
        """Want something for some time [s] besides the layout's wants."""
        self._also[capability] = self._clock() + seconds
        self._send()

    def connected(self) -> None:
        """Send the wants now, after the link's start."""
        self._to_repeat = _REPEATED
        self._send()

    def lacking(self, reports: CapabilityReports) -> dict[str, Lack]:
        """The wanted capabilities that the robot does not provide now, by name."""
        known = {report.name: report for report in reports.capabilities if report.modules}
        unknown = _UNDECLARED if reports.undeclared else _ABSENT
        lacks = {
            name: _LACKS.get(known[name].phase) if name in known else unknown
            for name in sorted(self._wanted)
            if name != Capability.CON_REAL
        }
        return {name: lack for name, lack in lacks.items() if lack is not None}

    def _check(self) -> None:
        if self._clock() >= self._due:
            self._send()

    def _send(self) -> None:
        now = self._clock()
        self._also = {name: until for name, until in self._also.items() if now < until}
        wanted = self._wanted | self._also.keys()
        if not (self._client.connected and wanted):
            return
        wants = CapabilityWants(
            holder=self._client.name,
            capabilities=" ".join(sorted(wanted)),
            lease_s=max(LEASE_S, _LEASE_INTERVALS * self._interval_s),
        )
        self._client.publish(CAPABILITY_WANTS, wants)
        # Checks come once a second, so half a second early is better than late.
        self._due = self._clock() - _CHECK_S / 2
        self._due += min(self._interval_s, _CHECK_S) if self._to_repeat else self._interval_s
        self._to_repeat = max(0, self._to_repeat - 1)
