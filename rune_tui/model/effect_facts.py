"""What the console needs to know about an effect before it executes it."""

from __future__ import annotations

import dataclasses
from typing import ClassVar, Self

from hub.values import dataclass
from rune_tui.layout.spec import CHOSEN


class EffectFacts:
    """Facts about an effect that the console needs before it executes the effect.

    Attributes:
        moves_view: Whether it may move viewports.
    """

    __slots__ = ()

    moves_view: ClassVar[bool] = False

    @property
    def ends_holds(self) -> bool:
        """Whether held inputs must be released: they belong to another robot or view."""
        return False

    @property
    def ends_driving(self) -> bool:
        """Whether held inputs that drive must be released; the others stay."""
        return False

    @property
    def stopped(self) -> str:
        """The robot that it stops; empty: none."""
        return ""

    @property
    def driven(self) -> str:
        """The robot whose velocity it sets; empty: none."""
        return ""

    @property
    def controlled(self) -> str:
        """The robot whose control it needs; empty: none."""
        return ""

    @property
    def takes_control(self) -> bool:
        """Whether a new press takes control of a free robot for it."""
        return False

    def addressed(self, _chosen: str) -> Self | None:
        """The effect with the chosen robot's name, if it is for that one; None: there is none."""
        return self


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotEffect(EffectFacts):
    """An effect on one robot, which may be the chosen one.

    Attributes:
        robot: The robot's name in the layout; `CHOSEN` until it is addressed.
    """

    robot: str

    def addressed(self, chosen: str) -> Self | None:
        """The effect with the chosen robot's name, if it is for that one; None: there is none."""
        if self.robot != CHOSEN:
            return self
        return dataclasses.replace(self, robot=chosen) if chosen else None
