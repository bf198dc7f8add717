"""What metrics need to know of a trial, from any source; all times are those of the trial [s]."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from hub.values import dataclass
from rune_study.metrics.awareness import Query
from rune_study.metrics.bumps import SIXTEEN
from rune_study.metrics.driving import OFF_CENTRE, STEP_M
from rune_study.metrics.effectiveness import RATE_HZ, WINDOW_S, Signal
from rune_study.metrics.episodes import GAP_S, LEAST_S
from rune_study.metrics.map_quality import TOLERANCE_M
from rune_study.metrics.neglect import FRACTION, HOLD_S, LEAST_SEEN, SHORT_S
from rune_study.metrics.victims import RADIUS_M, Mark
from rune_study.statistics.arrays import Flags, Floats


def _none() -> Floats:
    return np.empty(0)


def _no_spans() -> Floats:
    return np.empty((0, 2))


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """How a robot moved; all of shape (n,).

    Attributes:
        times: Ascending [s].
        linear: Forward speed [m/s].
        angular: Rate of turn [rad/s].
        pan: Of its camera against the robot [rad]; None: it has none.
    """

    times: Floats
    linear: Floats
    angular: Floats
    pan: Floats | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Contacts:
    """Contacts of a robot; all of shape (n,).

    Attributes:
        times: Ascending [s].
        counts: Contacts so far.
        bumpers: Bit i is set while bumper i is pressed.
        linear: Forward speed [m/s].
        directions: Of each bumper, counter-clockwise from straight ahead [rad].
    """

    times: Floats
    counts: Floats
    bumpers: np.typing.NDArray[np.integer]
    linear: Floats
    directions: tuple[float, ...] = SIXTEEN


@dataclass(frozen=True, slots=True, kw_only=True)
class Travel:
    """A drive to a goal.

    Attributes:
        x: Positions of the robot on the true ground [m], shape (n,).
        y: The same.
        shortest: Length of the shortest path to the goal [m]; NaN: there is no goal, or no path.
        arrived: Whether it reached the goal.
    """

    x: Floats
    y: Floats
    shortest: float = math.nan
    arrived: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotData:
    """The data of one robot; None: it was not recorded.

    Attributes:
        name: Its name.
        inputs: When the hands did something for it [s]: edges of keys, clicks, and moves of a stick
            as `driving.stick_moves` finds them.
        selections: When the operator chose it [s].
        held: Begin and end of each time in which a key was down or a stick out of neutral [s],
            shape (k, 2).
        progress: Progress of its task so far, in the unit that the study chose.
        travel: Where it drove.
        motion: How it moved, and where its camera looked.
        contacts: What it touched.
        wheel: Steering by a wheel [deg].
        stick: Steering by a stick, as a share of its travel from -1 to 1.
        keys: Steering by keys: -1, 0 or 1.
    """

    name: str
    inputs: Floats = dataclasses.field(default_factory=_none)
    selections: Floats = dataclasses.field(default_factory=_none)
    held: Floats = dataclasses.field(default_factory=_no_spans)
    progress: Signal | None = None
    travel: Travel | None = None
    motion: Motion | None = None
    contacts: Contacts | None = None
    wheel: Signal | None = None
    stick: Signal | None = None
    keys: Signal | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Secondary:
    """A secondary task, beside the robot and alone.

    Attributes:
        correct: Correct answers beside the robot.
        seconds: Time beside the robot [s].
        correct_alone: Correct answers without a robot.
        seconds_alone: Time without a robot [s]; 0: the task was not done alone.
        asked: Questions beside the robot that could be answered.
        missed: Those of them without an answer.
        times: Time from a question beside the robot to its correct answer [s].
    """

    correct: int
    seconds: float
    correct_alone: int
    seconds_alone: float
    asked: int = 0
    missed: int = 0
    times: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Questionnaires:
    """Answers of the participant; None: it was not asked.

    Attributes:
        tlx: Rating of each scale of NASA-TLX, 0 to 100.
        tlx_choices: Of each pair of scales, the one that counts more.
        sus: Ten answers from 1 to 5; None is missing.
        sart: Ten ratings from 1 to 7; None is missing.
    """

    tlx: Mapping[str, float] | None = None
    tlx_choices: tuple[str, ...] | None = None
    sus: tuple[int | None, ...] | None = None
    sart: tuple[int | None, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialData:
    """The data of one trial; None: it was not recorded, or the truth is not known.

    Attributes:
        length: Its duration without freezes and pauses [s].
        robots: Its robots.
        inputs_known: Whether the operator's inputs were recorded, if there were any.
        marks: Marks of victims, in the frame of the true places.
        victims: True places of victims [m], shape (victims, 2).
        seen: Cells of the true grid that were seen or mapped, shape (height, width).
        reachable: Cells of it that the robot can reach, the same shape.
        marked: Middles of the occupied cells of the map [m], shape (n, 2).
        surface: Middles of the true surface [m], shape (n, 2).
        photons: Motion to photon of each input [s]; NaN: no frame showed its effect.
        queries: Queries of freezes, with answers.
        secondary: The secondary task.
        questionnaires: Answers after the trial.
    """

    length: float
    robots: tuple[RobotData, ...] = ()
    inputs_known: bool = True
    marks: tuple[Mark, ...] | None = None
    victims: Floats | None = None
    seen: Flags | None = None
    reachable: Flags | None = None
    marked: Floats | None = None
    surface: Floats | None = None
    photons: Floats | None = None
    queries: tuple[Query, ...] | None = None
    secondary: Secondary | None = None
    questionnaires: Questionnaires = Questionnaires()


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureSpec:
    """Numbers that a study fixes before its first participant.

    Attributes:
        gap: A longer pause between two inputs ends an episode [s].
        least: Shortest episode [s].
        window: Width of the window of TE [s].
        rate_hz: Samples of TE per second [1/s].
        silence: Progress that is silent for longer than this is not known [s].
        fraction: TE below this share of its median while attended is a drop.
        hold: Least duration of a drop [s].
        short: Least duration if the operator then returns [s].
        tau: Bound of the restricted mean [s]; 0: the longest neglect of the trial. To compare
            conditions it must be the same in all.
        least_seen: Share of drops that must be seen for neglect tolerance to be known.
        radius: Farthest distance of a mark from its victim [m].
        tolerance: Farthest distance of a map's cell from a surface [m].
        step: Shortest step of a path that counts at once [m].
        off_centre: Farthest pan of a camera that is centred [rad].
    """

    gap: float = GAP_S
    least: float = LEAST_S
    window: float = WINDOW_S
    rate_hz: float = RATE_HZ
    silence: float = 5.0
    fraction: float = FRACTION
    hold: float = HOLD_S
    short: float = SHORT_S
    tau: float = 0.0
    least_seen: float = LEAST_SEEN
    radius: float = RADIUS_M
    tolerance: float = TOLERANCE_M
    step: float = STEP_M
    off_centre: float = OFF_CENTRE
