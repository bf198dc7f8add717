"""The topics of a recording: what is in it, the fields of one of them, and a number over time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.values import dataclass
from rune_tui.model.robot_state import Received, RobotState

TOPICS: Final = "RuneTopics"
"""Name of the topics among a robot's messages; it never leaves the console."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicEntry:
    """A topic.

    Attributes:
        name: Its name, with slashes between its parts.
        kind: The type of its messages.
        count: Number of its messages; -1: not known.
        rate_hz: Messages per second; NaN: not known.
        trouble: Why it cannot be read; empty: it can.
    """

    name: str
    kind: str
    count: int = -1
    rate_hz: float = math.nan
    trouble: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicField:
    """A field of a topic's newest message.

    Attributes:
        path: As in `twist.linear.x`.
        text: Its value.
        numeric: Whether it can be plotted.
    """

    path: str
    text: str
    numeric: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class NumberSeries:
    """A number over time.

    Attributes:
        times: Times of its values on the console's clock [s], shape (n,).
        values: Its values, shape (n,); NaN leaves a gap.
    """

    times: npt.NDArray[np.float64]
    values: npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Topics:
    """The topics of a recording, and what the operator looks at; read when it is drawn.

    Attributes:
        entries: All topics, by name.
        chosen: Name of the chosen topic; empty: there is none.
        newest: Number of its newest message; 0: there is none.
        age_s: Age of that message [s]; NaN: there is none.
        field: Path of the chosen field; empty: there is no number.
        seconds: Time that its values cover [s].
        read_fields: The fields of that message.
        read_series: The values of that field.
    """

    entries: tuple[TopicEntry, ...]
    chosen: str = ""
    newest: int = 0
    age_s: float = math.nan
    field: str = ""
    seconds: float = 30.0
    read_fields: Callable[[], tuple[TopicField, ...]]
    read_series: Callable[[], NumberSeries]


def topics_of(robot: RobotState) -> Received[Topics] | None:
    """The topics of a robot; None: it is no recording."""
    return robot.messages.get(TOPICS)
