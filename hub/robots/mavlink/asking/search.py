"""Finds the one vehicle at an address, or says why there is none."""

from __future__ import annotations

from typing import Final

from hub.errors import VehicleSilentError
from hub.robots.mavlink.asking.findings import VehicleFinder
from hub.robots.mavlink.asking.session import VehicleSession
from hub.robots.mavlink.asking.silence import unanswered
from hub.robots.mavlink.kinds import kind_name

_ANSWERING_S: Final = 6.0
"""Longest time after the first heartbeat [s]."""


def find_vehicle(
    session: VehicleSession,
    system: int = 0,
    seconds: float = 5.0,
    *,
    reads: bool = True,
    extra: tuple[str, ...] = (),
) -> VehicleFinder:
    """Find a vehicle, and what it is; one that is not asked for more has to answer.

    Args:
        session: A link.
        system: Number of the vehicle; 0: the only one.
        seconds: How long to listen for a first heartbeat [s].
        reads: Whether to read its parameters and streams.
        extra: Parameters to read besides those of its kind.

    Raises:
        VehicleSilentError: There is none, there are several, or it does not answer.
    """
    finder = VehicleFinder(system, reads=reads, extra=extra)
    if not session.ask(finder, seconds) and finder.begun:
        session.ask(finder, _ANSWERING_S)
    if finder.vehicle is not None:
        if not finder.answers and not reads:
            words = unanswered(signed=finder.vehicle.signed, signs=session.signs)
            text = f"vehicle {finder.vehicle.system} at {session.address.text}: {words}"
            raise VehicleSilentError(text)
        return finder
    known = [f"{each.system} ({kind_name(each.kind)})" for each in finder.vehicles]
    if not known:
        raise VehicleSilentError(session.silence())
    if system:
        text = f"vehicle {system} is not at {session.address.text}; there are: {', '.join(known)}"
    else:
        text = f"several vehicles are at {session.address.text}: {', '.join(known)}; give --system"
    raise VehicleSilentError(text)
