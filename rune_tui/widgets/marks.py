"""Widgets that mark victims and landmarks, by a click on the video or the map."""

from __future__ import annotations

import math
from typing import ClassVar, Final

import numpy as np
import numpy.typing as npt

from hub.gcm.mapping import POINT_COMMAND, InterestPoint, PointCommand, PointKind
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import ChoiceOption, HandlerRule, Section, TextOption
from rune_tui.layout.spec import WidgetSpec
from rune_tui.model.cameras import seen_by
from rune_tui.model.console_state import ConsoleState, Ghost
from rune_tui.model.effects import Effect, ShowGhost
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint, metres_text
from rune_tui.raster.thumbnail import thumbnail
from rune_tui.widgets.confirming import USES, Confirming
from rune_tui.widgets.pointing import PointedWidget

OPERATOR: Final = TextOption(longest=64, meaning="who marks; empty: the user's name")
GHOST_S = 10.0
"""A mark that is not confirmed is forgotten after this [s]."""
_SAME_M = 0.3
"""A click no farther from a ghost than this, or than the ghost may be off, confirms it [m]."""
_NO_PICTURE: Final = np.empty(0, np.uint8)


def _rule(what: str) -> HandlerRule:
    """The rule of a widget that makes marks of this kind."""
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
        uses=USES,
        pointed=True,
    )


class _SetMark(PointedWidget):
    """Marks the clicked place, and reports whether the robot keeps the mark."""

    kind: ClassVar[PointKind]
    purpose: ClassVar[str] = "marked"

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._confirming = Confirming(_marked_words)
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
        """The mark; the robot's map adds its time, by its own clock."""
        mark = InterestPoint(
            kind=self.kind,
            x=place.x,
            y=place.y,
            uncertainty=place.uncertainty,
            distance=place.distance,
            by=self.spec.options.word("operator") or state.operator,
            note=self.spec.options.word("note"),
            thumbnail=picture,
            height=place.height,
        )
        return self._confirming.send(PointCommand(point=mark), robot, state)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """The outcomes of sent marks, and the end of ghosts without a second click."""
        ended = [
            ShowGhost(robot=name, ghost=None)
            for name, ghost in state.ghosts.items()
            if ghost.kind is self.kind and state.now >= ghost.until
        ]
        return (*ended, *self._confirming.tick(state))


class SetVictim(_SetMark):
    """Marks a victim."""

    kind: ClassVar[PointKind] = PointKind.VICTIM
    rule: ClassVar = _rule("victim")


class SetLandmark(_SetMark):
    """Marks a landmark."""

    kind: ClassVar[PointKind] = PointKind.LANDMARK
    rule: ClassVar = _rule("landmark")


def _marked_words(command: PointCommand, kept: InterestPoint | None) -> str:
    """The report of a mark that the robot keeps."""
    mark = kept or command.point
    where = f"at {mark.x:.1f}, {mark.y:.1f} m"
    return f"{mark.kind.name.lower()} {mark.number} is marked {where}{_sure_words(mark)}"


def _sure_words(mark: InterestPoint) -> str:
    """The error of a mark and its distance at the sighting, if known."""
    off, away = metres_text(mark.uncertainty, 2), metres_text(mark.distance, 1)
    words = f", give or take {off} m" if off else ""
    return f"{words}, seen from {away} m away" if away else words


def _same(ghost: WorldPoint, place: WorldPoint) -> bool:
    off = ghost.uncertainty if math.isfinite(ghost.uncertainty) else 0.0
    return math.hypot(place.x - ghost.x, place.y - ghost.y) <= max(_SAME_M, off)


def picture_at(event: ControlEvent, robot: RobotState) -> npt.NDArray[np.uint8]:
    """A small picture of the clicked place, a JPEG file; empty: it was not in the video."""
    for hit in event.hits:
        picture = seen_by(robot, hit.camera).picture
        if hit.robot == robot.name and hit.in_picture is not None and picture is not None:
            pixels = picture.value.pixels
            return thumbnail(pixels, hit.in_picture) if pixels.size else _NO_PICTURE
    return _NO_PICTURE
