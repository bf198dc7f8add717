"""What the operator pressed, what became of it, and which robot he had chosen."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hub.gcm.vision import IMAGE
from hub.values import dataclass
from rune_study.metrics.driving import stick_moves
from rune_study.trial_data.trial_log import TrialLog
from rune_tui.model.held_inputs import HeldInputs
from rune_tui.model.own_records import (
    RUNE_FRAME,
    RUNE_INPUT,
    RUNE_SELECT,
    RUNE_SHOWN,
    InputOutcome,
    InputRecord,
    Selection,
    SelectRecord,
)

_TURNS = {"a": 1, "left": 1, "d": -1, "right": -1}
"""Keys that turn robots in the layouts of Rune, and their direction."""
_JOYSTICK = "joystick "
"""Names of inputs of joysticks and gamepads begin with this word."""
_Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class OperatorInputs:
    """The operator's inputs.

    Attributes:
        by_robot: When an input commanded a robot [s of the trial] (n,), by the robot's name.
        held: Begin and end of each time with a key down or a stick moved [s of the trial] (k, 2).
        selections: When a robot was chosen [s of the trial] (n,), by its name.
        inputs: All inputs with their times [s of the trial], in their order; those before the trial
            have negative times, because their keys may still be down.
        refused: Number of inputs that were refused with a reason.
    """

    by_robot: dict[str, _Floats]
    held: dict[str, _Floats]
    selections: dict[str, _Floats]
    inputs: tuple[tuple[float, InputRecord], ...]
    refused: int

    def steering(self, robot: str) -> tuple[_Floats, _Floats]:
        """Times [s of the trial] and directions of the keys that turn a robot: left is 1."""
        held: set[str] = set()
        found = []
        for time, record in self.inputs:
            if record.robot == robot and record.input in _TURNS:
                (held.add if record.pressed else held.discard)(record.input)
                found.append((time, float(np.sign(sum(_TURNS[each] for each in held)))))
        times, values = np.array(found, float).reshape(-1, 2).T
        return times, values

    def axis(self, name: str) -> tuple[_Floats, _Floats]:
        """Times [s of the trial] and positions (-1 to 1) of an axis, by its name in layouts."""
        found = [(time, record.value) for time, record in self.inputs if record.input == name]
        times, values = np.array(found, float).reshape(-1, 2).T
        return times, values


def inputs_of(log: TrialLog) -> OperatorInputs:
    """The inputs of a trial; what repeats by itself, as a held key, counts as one input.

    A stick is an input where `stick_moves` finds a new intention, not at each report.
    Inputs while control was withheld are left out: they are no interaction.
    """
    selections: dict[str, list[float]] = {}
    inputs: list[tuple[float, InputRecord]] = []
    down = HeldInputs()
    records: list[tuple[float, InputRecord | SelectRecord]] = [
        *log.own(RUNE_INPUT, before=True),
        *log.own(RUNE_SELECT, before=True),
    ]
    for time, record in sorted(records, key=lambda each: each[0]):
        if isinstance(record, SelectRecord):
            if record.what is Selection.CHOSEN and record.robot and time >= 0.0:
                selections.setdefault(record.robot, []).append(time)
            elif record.what is Selection.FOCUS and not record.on:
                down.focus_lost(time)
            continue
        withheld = down.withheld(record.input) and not record.pressed
        down.take(time, record)
        if withheld or record.outcome is InputOutcome.WITHHELD:
            continue
        inputs.append((time, record))
    held: dict[str, list[tuple[float, float]]] = {}
    for span in down.until(min(log.seconds, log.last_of_console)):
        held.setdefault(span.robot, []).append((span.begin, span.end))
    return OperatorInputs(
        by_robot=_intentions(inputs),
        held={robot: np.array(sorted(spans)) for robot, spans in held.items()},
        selections={robot: np.array(times) for robot, times in selections.items()},
        inputs=tuple(inputs),
        refused=sum(
            record.outcome is InputOutcome.REFUSED and time >= 0.0 for time, record in inputs
        ),
    )


def _intentions(inputs: Sequence[tuple[float, InputRecord]]) -> dict[str, _Floats]:
    """When the operator wanted something else of each robot [s of the trial] (n,), by its name."""
    of_axes: dict[str, list[tuple[float, float]]] = {}
    for time, record in inputs:
        if record.input.startswith(_JOYSTICK):
            of_axes.setdefault(record.input, []).append((time, record.value))
    moves = {
        name: frozenset(stick_moves(*np.array(places).T).tolist())
        for name, places in of_axes.items()
        if any(value not in (0.0, 1.0) for _, value in places)  # else it is a button
    }
    found: dict[str, list[float]] = {}
    for time, record in inputs:
        repeats = record.repeat and record.value == 1
        counts = time in moves[record.input] if record.input in moves else not repeats
        if time >= 0.0 and record.robot and record.handlers and counts:
            found.setdefault(record.robot, []).append(time)
    return {robot: np.array(times) for robot, times in found.items()}


def frames_shown(log: TrialLog, role: str) -> tuple[_Floats, _Floats]:
    """When the picture of each frame was taken, and when the frame was shown (frames,) [s].

    Frames without a new picture of the robot's main camera are left out. A terminal that says
    nothing shows a frame when it is handed over.

    Args:
        log: The trial.
        role: The robot's name in the layout.
    """
    taken_at = log.numbers(role, IMAGE)
    pictures: dict[int, float] = {}
    for _, frame in log.own(RUNE_FRAME):
        for robot in frame.robots:
            for each in robot.pictures:
                if robot.robot == role and not each.camera and each.number in taken_at:
                    pictures[frame.number] = taken_at[each.number]
    taken, shown = [], []
    for time, record in log.own(RUNE_SHOWN):
        if record.number in pictures:
            waited = record.answered - record.handed
            taken.append(pictures[record.number])
            shown.append(time + (waited if math.isfinite(waited) else 0.0))
    return np.array(taken), np.array(shown)
