"""The ways of a link to a hub that is at no address that people write."""

from __future__ import annotations

from typing import Protocol

from rune_tui.layout.spec import RobotSpec


class Way(Protocol):
    """A way that is kept open beside the link: a tunnel, or the mirror of a robot in a fleet."""

    @property
    def endpoint(self) -> str:
        """Where the hub is found on this machine."""

    @property
    def shown(self) -> str:
        """What it is, for people."""

    @property
    def trouble(self) -> str:
        """Why it is closed now, in one sentence; empty: it is open."""

    @property
    def may_command(self) -> bool:
        """Whether the operator's role on this way allows to drive."""

    def next_notice(self) -> str:
        """What the operator has to read about the way, each once; empty: no more."""


class FleetWays(Protocol):
    """The ways to the robots of fleets."""

    def way(self, robot: RobotSpec) -> Way:
        """The way to a robot that names a fleet."""
