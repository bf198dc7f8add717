"""Widgets that mark what was found: victims and landmarks, by a click on the video or the map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
import numpy.typing as npt

from hub.gcm.mapping import (
    INTEREST_POINTS,
    POINT_COMMAND,
    InterestPoint,
    PointCommand,
    PointKind,
)
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import ChoiceOption, HandlerRule, Section, TextOption
from rune_tui.layout.spec import WidgetSpec
from rune_tui.model.console_state import ConsoleState, Ghost
from rune_tui.model.effects import Effect, SendEffect, ShowGhost, Tell
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint, metres_text
from rune_tui.raster.thumbnail import thumbnail
from rune_tui.widgets.pointing import PointedWidget

OPERATOR: Final = TextOption(longest=64, meaning="who marks; empty: the user's name")
ANSWER_S = 3.0
"""A mark that is not among the robot's points after this was not taken [s]."""
GHOST_S = 10.0
"""A mark that is not confirmed is forgotten after this [s]."""
_SAME_M = 0.3
"""A click no farther from a ghost than this, or than the ghost may be off, confirms it [m]."""
_NO_PICTURE: Final = np.empty(0, np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Pending:
    """A mark that is not yet among the robot's points.

    Attributes:
        robot: On whose map.
        place: Where, in `map` [m].
        after: The highest number of a point when it was made; its own will be higher.
        since: When it was made [s].
    """

    robot: str
    place: tuple[float, float]
    after: int
    since: float


def _rule(what: str) -> HandlerRule:
    """What layouts may say of a widget that marks such things."""
    return HandlerRule(
        section=Section.MARK,
        says={"": f"Mark a {what} there"},
        meaning=f"Marks a {what} where you click, with a small picture of it. "
        "The first click shows where it would be and how far away, a second one there marks it.",
        options={
            "confirm": ChoiceOption(
                default="on",
                choices=("on", "off"),
                meaning="whether a second click has to confirm what the first one shows",
            ),
            "note": TextOption(longest=200, meaning="words to go with it"),
            "operator": OPERATOR,
        },
        sends=(POINT_COMMAND.name,),
        uses=(INTEREST_POINTS.name,),
        pointed=True,
    )


class _SetMark(PointedWidget):
    """Marks the place that was clicked, and says whether the robot took it."""

    kind: ClassVar[PointKind]
    purpose: ClassVar[str] = "marked"

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._pending: list[_Pending] = []
        self._picture = _NO_PICTURE

    def point(
        self, place: WorldPoint, event: ControlEvent, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The ghost of a mark, or the mark if there is a ghost of it already."""
        if self.spec.options.word("confirm") != "on":
            return self._mark(place, picture_at(event, robot), robot, state)
        ghost = state.ghosts.get(robot.name)
        if ghost is not None and ghost.kind is self.kind and _same(ghost.place, place):
            picture = self._picture if self._picture.size else picture_at(event, robot)
            gone = ShowGhost(robot=robot.name, ghost=None)
            return (gone, *self._mark(ghost.place, picture, robot, state))
        self._picture = picture_at(event, robot)
        ghost = Ghost(kind=self.kind, place=place, until=state.now + GHOST_S)
        return (ShowGhost(robot=robot.name, ghost=ghost),)

    def _mark(
        self,
        place: WorldPoint,
        picture: npt.NDArray[np.uint8],
        robot: RobotState,
        state: ConsoleState,
    ) -> tuple[Effect, ...]:
        """The mark; when it was made, the robot's map notes by its own clock."""
        mark = InterestPoint(
            kind=self.kind,
            x=place.x,
            y=place.y,
            uncertainty=place.uncertainty,
            distance=place.distance,
            by=self.spec.options.word("operator") or state.operator,
            note=self.spec.options.word("note"),
            length=len(picture),
            thumbnail=picture,
        )
        after = max((known.number for known in points_of(robot)), default=0)
        self._pending.append(
            _Pending(robot=robot.name, place=(mark.x, mark.y), after=after, since=state.now)
        )
        command = PointCommand(point=mark)
        return (SendEffect(robot=robot.name, definition=POINT_COMMAND, value=command),)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """What became of the marks that were sent."""
        told: list[Effect] = [
            ShowGhost(robot=name, ghost=None)
            for name, ghost in state.ghosts.items()
            if ghost.kind is self.kind and state.now >= ghost.until
        ]
        for pending in tuple(self._pending):
            taken = self._taken(pending, state)
            if taken is None and state.now - pending.since < ANSWER_S:
                continue
            self._pending.remove(pending)
            where = f"at {pending.place[0]:.1f}, {pending.place[1]:.1f} m"
            if taken is None:
                text = f"the {self.kind.name.lower()} {where} was not taken; its log says why"
            else:
                sure = _sure_words(taken)
                text = f"{self.kind.name.lower()} {taken.number} is marked {where}{sure}"
            told.append(Tell.now(state, text, robot=pending.robot, alarm=taken is None))
        return tuple(told)

    def _taken(self, pending: _Pending, state: ConsoleState) -> InterestPoint | None:
        """The mark as the robot keeps it; None if the robot does not have it."""
        robot = state.robot(pending.robot)
        for point in points_of(robot) if robot is not None else ():
            there = (point.x, point.y) == pending.place and point.kind is self.kind
            if there and point.number > pending.after:
                return point
        return None


class SetVictim(_SetMark):
    """Marks a victim."""

    kind: ClassVar[PointKind] = PointKind.VICTIM
    rule: ClassVar = _rule("victim")


class SetLandmark(_SetMark):
    """Marks a landmark."""

    kind: ClassVar[PointKind] = PointKind.LANDMARK
    rule: ClassVar = _rule("landmark")


def points_of(robot: RobotState) -> tuple[InterestPoint, ...]:
    """What is marked on a robot's map, as far as the console knows."""
    newest = robot.newest(INTEREST_POINTS)
    return newest.value.points if newest is not None else ()


def _sure_words(mark: InterestPoint) -> str:
    """How far off a mark may be and from how far away it was seen, as far as that is known."""
    off, away = metres_text(mark.uncertainty, 2), metres_text(mark.distance, 1)
    words = f", give or take {off} m" if off else ""
    return f"{words}, seen from {away} m away" if away else words


def _same(ghost: WorldPoint, place: WorldPoint) -> bool:
    off = ghost.uncertainty if math.isfinite(ghost.uncertainty) else 0.0
    return math.hypot(place.x - ghost.x, place.y - ghost.y) <= max(_SAME_M, off)


def picture_at(event: ControlEvent, robot: RobotState) -> npt.NDArray[np.uint8]:
    """A small picture of what was clicked, a JPEG file; empty if it was not in the video."""
    for hit in event.hits:
        if hit.robot == robot.name and hit.in_picture is not None and robot.picture is not None:
            pixels = robot.picture.value.pixels
            return thumbnail(pixels, hit.in_picture) if pixels.size else _NO_PICTURE
    return _NO_PICTURE
