"""The questions of a freeze, and what is true at that moment.

The journal has all truths before the first question is shown, and the file of answers has each
answer before the next one is. So both follow from the files, however the session ends.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from hub.pose import Pose
from hub.values import dataclass
from rune_study.errors import StudyError
from rune_study.lots import shuffled
from rune_study.metrics.awareness import AnswerKind
from rune_study.metrics.awareness import Query as AnsweredQuery
from rune_study.metrics.coverage import TrueGrid
from rune_study.plan.folder import arena_of, questionnaire_path
from rune_study.plan.steps import Step
from rune_study.plan.study_spec import StudySpec
from rune_study.questionnaires.answers import GivenAnswer
from rune_study.questionnaires.asking import ask
from rune_study.questionnaires.entries import Grounds
from rune_study.questionnaires.ground import Ground
from rune_study.questionnaires.items import Answer, ComparedItem, GroundShown, Item, PlaceItem
from rune_study.questionnaires.questionnaire import Questionnaire
from rune_study.questionnaires.questionnaire import read as read_questionnaire
from rune_study.questionnaires.truths import Moment, Value, rounded, with_moving
from rune_study.session.journal import Journal
from rune_study.session.progress import LeftError
from rune_study.session.reading import forget_keys
from rune_study.session.robots import WatchedRobot, listening, state_of
from rune_study.session.stage import Stage
from rune_study.trial_data.truth import truth_of, walls_of

ANSWERS = "answers.log"
FROZEN, PROBE = "frozen", "probe"
"""Kinds of the journal's records: with all truths, and with each answer."""
_OCCUPIED = 65
"""Share from which on a cell of a map is a wall [%], as in ROS 2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AskedQuery:
    """A question of a freeze with its truth.

    Attributes:
        id: Of the item.
        truth: Name of the truth.
        kind: How the answer is compared.
        level: Level of awareness.
        robot: Number of the robot in the layout, from 1.
        right: The right answer.
        tolerance: Largest error of a right answer.
    """

    id: str
    truth: str
    kind: str
    level: int
    robot: int
    right: Value
    tolerance: float

    def query(self, answer: Answer | None) -> AnsweredQuery:
        """The question with its answer, as metrics take it; None: there is no answer."""
        return AnsweredQuery(
            level=self.level,
            kind=AnswerKind(self.kind),
            answer=answer,
            truth=self.right if self.right is not None else "",
            tolerance=self.tolerance,
        )


def occasion_of(step: str, attempt: int, freeze: int) -> str:
    """How answers name a freeze of a trial's attempt."""
    return f"{step}-a{attempt}-f{freeze}"


def _whole(arena: str) -> TrueGrid:
    return truth_of(arena).grid


class Freezes:
    """Asks the questions of a trial's freezes."""

    def __init__(
        self, study: StudySpec, step: Step, attempt: int, journal: Journal, stage: Stage
    ) -> None:
        self._study = study
        self._step = step
        self._attempt = attempt
        self._journal = journal
        self._stage = stage

    def ask(self, number: int, time_left: float) -> bool:
        """Ask all questions of a freeze; the view is away, and robots stand still.

        Args:
            number: Of the freeze, from 1.
            time_left: Until the end of the trial [s].

        Returns:
            Whether all are answered.

        Raises:
            LeftError: There is no such questionnaire.
            StudyError: Journal or answers cannot be written.
        """
        robots = self._stage.robots
        states = [state_of(robot) for robot in robots]
        moments = with_moving([self._moment(each, time_left) for each in robots])
        whole = self._questionnaire(number)
        grounds = dict(self._grounds(own=_asks_for_places(whole.items, GroundShown.ROBOT)))
        most = self._study.freeze.draws if self._study.freeze is not None else 0
        items, queries, unknown = choose(whole.items, moments, grounds, most or len(whole.items))
        self._journal.put(
            FROZEN,
            n=self._step.number,
            number=number,
            truth=states,
            queries=[dataclasses.asdict(each) for each in queries],
            unknown=unknown,
        )
        if not items:
            return True
        chosen = dataclasses.replace(whole, items=tuple(items))
        occasion = occasion_of(self._step.name, self._attempt, number)
        path = self._journal.path.parent / ANSWERS
        given = self._note_of({each.id: each for each in queries}, number)
        with listening(robots):
            forget_keys()
            seed = f"{self._study.seed} {occasion}"
            return ask(chosen, path, occasion, seed, grounds=grounds, given=given)

    def _note_of(
        self, queries: Mapping[str, AskedQuery], freeze: int
    ) -> Callable[[GivenAnswer], None]:
        """What writes an answer with its truth into the journal."""

        def note(given: GivenAnswer) -> None:
            asked = queries.get(given.item)
            if asked is not None:
                self._journal.put(
                    PROBE,
                    n=self._step.number,
                    number=freeze,
                    id=asked.id,
                    about=asked.truth,
                    level=asked.level,
                    robot=asked.robot,
                    asked=given.moment - given.seconds,
                    answered=given.moment,
                    answer=given.value,
                    truth=asked.right,
                    tolerance=asked.tolerance,
                    correct=asked.query(given.value).right,
                    seconds=given.seconds,
                )

        return note

    def _questionnaire(self, number: int) -> Questionnaire:
        """All questions, in the order in which they are drawn."""
        spec = self._study.freeze
        path = questionnaire_path(self._study, spec.questions) if spec is not None else None
        if spec is None or path is None:
            why = f"there is no questionnaire {spec.questions if spec else ''!r} for freezes"
            raise LeftError(why)
        whole = read_questionnaire(path)
        if not spec.draws:
            return whole
        drawn = shuffled(whole.items, self._study.seed, self._step.seed, "draws", number)
        return dataclasses.replace(whole, items=tuple(drawn))

    def _moment(self, robot: WatchedRobot, time_left: float) -> Moment | None:
        """What is true of a robot; None: it sends nothing."""
        truth, state, frame = robot.truth, robot.state, robot.map_in_arena
        battery = state.battery_fraction if state is not None else math.nan
        known: dict[str, Any] = {
            "battery": battery,
            "pan": robot.camera.pan if robot.camera is not None else math.nan,
            "marks": robot.marks,
            "found": robot.victims if robot.number_of_victims else None,
            "victims": robot.number_of_victims or None,
            "time_left": time_left,
            "ground": self._arena(robot),
        }
        if truth is not None and frame is not None:
            pose = Pose(x=truth.x, y=truth.y, theta=truth.theta).seen_from(frame)
            known |= {"pose": pose, "collisions": robot.collisions}
            moving: Any = truth
        elif state is not None:  # a real robot: its own state
            known["pose"] = Pose(x=state.x, y=state.y, theta=state.theta)
            moving = state
        else:
            return None
        return Moment(
            **known,
            linear=moving.linear,
            angular=moving.angular,
            commanded_linear=moving.commanded_linear,
            commanded_angular=moving.commanded_angular,
        )

    def _arena(
        self, robot: WatchedRobot, grid_of: Callable[[str], TrueGrid] = _whole
    ) -> Ground | None:
        """The true ground, where the study names the arena and the robot is simulated."""
        spec = self._study.conditions[max(self._step.condition, 0)]
        if not spec.arena or robot.map_in_arena is None:
            return None
        grid = grid_of(arena_of(self._study, spec))
        return Ground(
            walls=grid.blocked,
            resolution=grid.resolution,
            origin_x=grid.origin_x,
            origin_y=grid.origin_y,
            frame=robot.map_in_arena,
        )

    def _grounds(self, *, own: bool) -> Iterator[tuple[tuple[str, int], Ground]]:
        """What questions about places show; without a known arena, the robot's map."""
        for number, robot in enumerate(self._stage.robots, 1):
            arena = self._arena(robot, walls_of)
            drawn = robot.own_map() if own or arena is None else None
            if drawn is not None:
                ground = Ground(
                    walls=drawn.cells >= _OCCUPIED,
                    resolution=drawn.resolution,
                    origin_x=drawn.origin_x,
                    origin_y=drawn.origin_y,
                )
                yield (GroundShown.ROBOT, number), ground
                arena = arena or ground
            if arena is not None:
                yield (GroundShown.ARENA, number), arena


def _asks_for_places(items: Sequence[Item], ground: GroundShown) -> bool:
    return any(isinstance(item, PlaceItem) and item.ground == ground for item in items)


def choose(
    items: Sequence[Item], moments: Sequence[Moment | None], grounds: Grounds, most: int
) -> tuple[list[Item], list[AskedQuery], dict[str, str]]:
    """The first items that can be asked, those of them with a truth, and why others are not asked.

    Args:
        items: All items, in the order in which they are drawn.
        moments: What is true of each robot; None: it sends nothing.
        grounds: What questions about places show.
        most: Largest number of items.

    Raises:
        StudyError: An item names a robot that there is not.
    """
    asked: list[Item] = []
    queries: list[AskedQuery] = []
    unknown: dict[str, str] = {}
    for item in items:
        if len(asked) == most:
            break
        if not isinstance(item, ComparedItem):
            asked.append(item)
            continue
        if item.robot > len(moments):
            text = f"{item.id} asks about robot {item.robot}, and there are {len(moments)}"
            raise StudyError(text)
        if isinstance(item, PlaceItem) and (item.ground, item.robot) not in grounds:
            unknown[item.id] = "there is no ground to show"
            continue
        truth = item.compared()
        if truth is None:
            asked.append(item)
            continue
        moment = moments[item.robot - 1]
        value = rounded(truth.value(moment)) if moment is not None else None
        right = item.right_answer(value) if value is not None else None
        if right is None:
            unknown[item.id] = f"{truth.name} is not known"
            continue
        asked.append(item)
        queries.append(
            AskedQuery(
                id=item.id,
                truth=truth.name,
                kind=truth.kind,
                level=item.level or truth.level,
                robot=item.robot,
                right=right,
                tolerance=truth.tolerance if item.tolerance is None else item.tolerance,
            )
        )
    return asked, queries, unknown
