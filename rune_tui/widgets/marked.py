"""Widgets for existing marks: take back, remove, export, and correct the pose by them."""

from __future__ import annotations

import dataclasses
import math
from abc import abstractmethod
from typing import ClassVar, Final

import numpy as np

from hub.gcm.mapping import (
    INTEREST_POINTS,
    MAP,
    POINT_COMMAND,
    InterestPoint,
    PointAction,
    PointCommand,
    PointKind,
)
from hub.gcm.navigation import LANDMARK_CORRECTION, ROBOT_STATE, LandmarkCorrection
from hub.gcm.ranges import RANGES
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import HandlerRule, NumberOption, Section
from rune_tui.layout.spec import WidgetSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, Effect, ExportEffect, Notify, SendEffect
from rune_tui.model.pose import Pose
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.widgets.confirming import USES, Confirming, nearest_mark, points_of
from rune_tui.widgets.marks import OPERATOR
from rune_tui.widgets.pointing import FRESH_S, PointedWidget
from rune_tui.widgets.widget import EffectWidget, OrderWidget

_FIXED_M = 0.3
"""Largest error of a victim's place by which the robot's place is corrected [m]."""
_REMOVED_S = 3.0
"""Time for which a removed point may still be in the last report [s]."""
_RADIUS: Final = NumberOption(
    default=0.5, least=0.05, most=20.0, unit="m", meaning="no mark farther away counts"
)


class UndoMark(OrderWidget):
    """Takes back the newest mark of this operator."""

    rule: ClassVar = HandlerRule(
        section=Section.MARK,
        says={"": "Take back your newest mark"},
        meaning="Takes back your newest mark.",
        options={"operator": OPERATOR},
        sends=(POINT_COMMAND.name,),
        uses=USES,
    )

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._removed: dict[tuple[str, int], float] = {}
        self._confirming = Confirming(_removed_words)

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The removal; numbers are never given twice, so the highest is the newest."""
        operator = self.spec.options.word("operator") or state.operator
        mine = [
            point
            for point in points_of(robot)
            if point.by == operator and not self._gone(robot.name, point.number, state.now)
        ]
        if not mine:
            return (Notify.now(state, "you have marked nothing yet", robot=robot.name),)
        newest = max(mine, key=lambda point: point.number)
        self._removed[robot.name, newest.number] = state.now
        return self._confirming.send(_removal(newest), robot, state)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Results of the removals."""
        return self._confirming.tick(state)

    def _gone(self, robot: str, number: int, now: float) -> bool:
        return now - self._removed.get((robot, number), -math.inf) < _REMOVED_S


def _rule(meaning: str, says: str) -> HandlerRule:
    """The rule of a widget that acts on the clicked mark."""
    return HandlerRule(
        section=Section.MARK,
        says={"": says},
        meaning=meaning,
        options={"radius": _RADIUS},
        sends=(POINT_COMMAND.name,),
        uses=USES,
        pointed=True,
    )


class _MarkWidget(PointedWidget):
    """A widget that does something with the mark that was clicked."""

    def __init__(self, spec: WidgetSpec, robot: str) -> None:
        super().__init__(spec, robot)
        self._confirming = Confirming(_outcome_words)

    def tick(self, state: ConsoleState) -> tuple[Effect, ...]:
        """Its result."""
        return self._confirming.tick(state)

    @abstractmethod
    def mark(
        self, mark: InterestPoint, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects of a click on a mark."""

    def point(
        self, place: WorldPoint, _event: ControlEvent, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """Effects for the nearest mark, or a sentence that there is none."""
        radius = self.spec.options.number("radius")
        nearest = nearest_mark(place, robot, radius)
        if nearest is None:
            text = f"not {self.purpose}: no mark is within {radius:g} m of where you clicked"
            return (Notify.now(state, text, robot=robot.name),)
        return self.mark(nearest, robot, state)


class RemoveMark(_MarkWidget):
    """Removes the mark that was clicked."""

    purpose: ClassVar[str] = "removed"
    rule: ClassVar = _rule("Removes the mark nearest to where you click.", "Remove the mark there")

    def mark(
        self, mark: InterestPoint, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The removal."""
        return self._confirming.send(_removal(mark), robot, state)


class EditMark(_MarkWidget):
    """Changes the words that go with a mark."""

    purpose: ClassVar[str] = "changed"
    rule: ClassVar = _rule(
        "Asks for other words to go with the mark nearest to where you click.",
        "Change the words of the mark there",
    )

    def mark(
        self, mark: InterestPoint, robot: RobotState, _state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The question."""
        asked = f"Words for {mark.kind.name.lower()} {mark.number} of {robot.title}"

        def answer(note: str, later: ConsoleState) -> tuple[Effect, ...]:
            changed = PointCommand(point=dataclasses.replace(mark, note=note))
            return self._confirming.send(changed, later.robot(robot.name) or robot, later)

        return (AskEffect(robot=robot.name, asked=asked, text=mark.note, answer=answer),)


class CorrectLandmark(PointedWidget):
    """Corrects the robot's pose: a mark with a sure place is seen where the operator clicks."""

    purpose: ClassVar[str] = "corrected"
    rule: ClassVar = HandlerRule(
        section=Section.MARK,
        says={"": "Correct where the robot is: a landmark's foot"},
        meaning=(
            "Corrects where the robot thinks it is: click on the foot of a marked landmark, where "
            "you see it. The nearest marked landmark is the one that is meant. A victim counts too "
            "where its place is known to 0.3 m."
        ),
        options={
            "radius": NumberOption(
                default=3.0, least=0.1, most=20.0, unit="m", meaning="largest error to correct"
            )
        },
        sends=(LANDMARK_CORRECTION.name,),
        uses=(INTEREST_POINTS.name, ROBOT_STATE.name, RANGES.name),
        pointed=True,
    )

    def point(
        self, place: WorldPoint, _event: ControlEvent, robot: RobotState, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The correction with a sentence, or the reason why there is none.

        A place on screen follows from the pose that the robot believes; seen from that pose it is
        where the camera really saw it, however wrong the pose is.
        """
        radius = self.spec.options.number("radius")
        landmark = nearest_mark(place, robot, radius, _is_fixed)
        known = robot.navigation
        if landmark is None:
            text = f"not corrected: no landmark is marked within {radius:g} m of where you clicked"
            victim = nearest_mark(place, robot, radius)
            if victim is not None:
                text += f"; the place of victim {victim.number} is not known to {_FIXED_M:g} m"
        elif known is None or known.age(state.now) > FRESH_S:
            text = "not corrected: where the robot is now is not known"
        else:
            way = math.hypot(landmark.x - place.x, landmark.y - place.y)
            named = f"{landmark.kind.name.lower()} {landmark.number}"
            text = f"{named} is seen {way:.2f} m beside its place: corrected"
            pose = Pose(x=known.value.x, y=known.value.y, theta=known.value.theta)
            seen_x, seen_y = pose.from_map((place.x, place.y)).tolist()
            value = LandmarkCorrection(x=landmark.x, y=landmark.y, seen_x=seen_x, seen_y=seen_y)
            send = SendEffect(robot=robot.name, definition=LANDMARK_CORRECTION, value=value)
            return (send, Notify.now(state, text, robot=robot.name))
        return (Notify.now(state, text, robot=robot.name),)


class ExportMarks(EffectWidget):
    """Writes the marks and the map into files."""

    rule: ClassVar = HandlerRule(
        section=Section.MARK,
        says={"": "Write all marks into files"},
        meaning=(
            "Writes all marks into files in your documents folder: CSV, GeoJSON, and a page with "
            "the map and the pictures."
        ),
        uses=(INTEREST_POINTS.name, MAP.name),
    )

    def effect(self) -> Effect:
        """The files."""
        return ExportEffect(robot=self.robot)


def _removal(point: InterestPoint) -> PointCommand:
    emptied = InterestPoint(
        number=point.number,
        kind=point.kind,
        x=point.x,
        y=point.y,
        version=point.version,
        thumbnail=np.empty(0, np.uint8),
    )
    return PointCommand(action=PointAction.REMOVE, point=emptied)


def _is_fixed(point: InterestPoint) -> bool:
    """Whether the place of a mark may correct the robot's; an unknown error may not."""
    return point.kind is PointKind.LANDMARK or 0.0 < point.uncertainty <= _FIXED_M


def _removed_words(command: PointCommand, _kept: InterestPoint | None) -> str:
    """The report of a removed mark."""
    return f"{command.point.kind.name.lower()} {command.point.number} is removed"


def _outcome_words(command: PointCommand, kept: InterestPoint | None) -> str:
    """The report of a changed or removed mark."""
    if kept is None:
        return _removed_words(command, kept)
    return f"{kept.kind.name.lower()} {kept.number} is changed"
