"""The messages of recordings about a study; they go over no bus, and stand under `/study/`.

| message | written |
| --- | --- |
| `RuneStudy` | for each record of the session's journal within a trial |
| `RuneProbe` | for each answer to a question of a freeze that has a truth |
| `RuneSecondary` | for each question of the secondary task, when it is over |

Times are of the monotonic clock of the machine [s].
"""

from __future__ import annotations

from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.wire_types import Uint8, Uint16
from hub.values import dataclass

STUDY = "study"
"""First part of the topics."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyRecord:
    """Something that happened in a session.

    Attributes:
        study: SHA-256 of the study, in hexadecimal digits.
        participant: The participant's code, such as "p07"; never a name.
        step: The step, such as "t3".
        trial: Number of the trial in the session, from 1; 0: practice.
        condition: Code of the condition; empty: none.
        attempt: Which attempt at the step, from 1.
        what: Kind of the journal's record, such as "frozen".
        detail: The rest of it, as JSON.
    """

    study: str
    participant: str
    step: str
    trial: Uint16
    condition: str
    attempt: Uint16
    what: str
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeRecord:
    """A question of a freeze and its answer.

    Attributes:
        id: The question, by its name in the questionnaire.
        about: What is asked for, by its name among the truths.
        freeze: Number of the freeze in the trial, from 1.
        robot: Number of the robot in the layout, from 1.
        level: 1 perception, 2 comprehension, 3 projection.
        asked: When it was shown [s].
        answered: When it was answered [s].
        answer: The answer, as JSON.
        truth: The right answer, as JSON.
        tolerance: Largest error of a right answer.
        correct: Whether it is right.
        rt: Time from the question to the answer [s].
    """

    id: str
    about: str
    freeze: Uint16
    robot: Uint8
    level: Uint8
    asked: float
    answered: float
    answer: str
    truth: str
    tolerance: float
    correct: bool
    rt: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondaryRecord:
    """A question of the secondary task.

    Attributes:
        id: Its number in the trial, from 1.
        text: What was shown.
        asked: When it was shown [s].
        answered: When a key was pressed [s]; NaN: none was.
        answer: The key; empty: none.
        truth: The right key.
        counts: Whether it could be answered in time.
        correct: Whether the answer is right.
        rt: Time from the question to the answer [s]; NaN: there is none.
    """

    id: Uint16
    text: str
    asked: float
    answered: float
    answer: str
    truth: str
    counts: bool
    correct: bool
    rt: float


RUNE_STUDY = MessageDefinition(name="RuneStudy", type=StudyRecord)
RUNE_PROBE = MessageDefinition(name="RuneProbe", type=ProbeRecord)
RUNE_SECONDARY = MessageDefinition(name="RuneSecondary", type=SecondaryRecord)
