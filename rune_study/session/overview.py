"""What the experimenter has to know of a session at a glance; pure, from its journal."""

from __future__ import annotations

import enum
from collections.abc import Iterator, Mapping, Sequence

from hub.values import dataclass
from rune_study.plan.design_report import minutes_of
from rune_study.plan.steps import PRACTICE, TRIAL, Step, plan
from rune_study.plan.study_spec import StudySpec
from rune_study.session.journal import BEGIN, DONE, Record, has_declined, head_of
from rune_study.session.orders import BEGIN as GO_ON
from rune_study.session.orders import MARK, PAUSE

_SILENT_S = 1.5
"""A robot that says nothing for longer is an alarm [s]."""
_LOST_S = 6.0
"""A running trial without a sign of life for longer is an alarm [s]."""
_RECENT_S = 60.0
"""Trials that failed within this time are an alarm [s]."""


_ENDS = ("trial-end", "failed", "left", "lost")
"""Records after which a step is open no more."""


class State(enum.Enum):
    """What a session does; the value is for people."""

    ABSENT = "has not begun yet"
    BETWEEN = "is between steps, or was left"
    PAGE = "is at a page or questionnaire"
    WAITS = "waits for the begin of the trial"
    RUNS = "the trial runs"
    PAUSED = "the trial is paused"
    FROZEN = "the trial is frozen for questions"
    COMPLETE = "is complete"
    DECLINED = "is over: the participant declined"


@dataclass(frozen=True, slots=True, kw_only=True)
class Overview:
    """A session at a glance.

    Attributes:
        state: What it does.
        step: The step; None: none is open.
        attempt: Which attempt at it.
        elapsed: Time of the trial, without pauses [s].
        done: Numbers of the steps that are done.
        steps: All of them.
        minutes: Expected time until the end of the session [min].
        silence: Time since the last entry of the journal [s].
        marks: Number of marks.
        alarms: What needs the experimenter, a sentence each.
    """

    state: State
    step: Step | None = None
    attempt: int = 0
    elapsed: float = 0.0
    done: frozenset[int] = frozenset()
    steps: tuple[Step, ...] = ()
    minutes: float = 0.0
    silence: float = 0.0
    marks: int = 0
    alarms: tuple[str, ...] = ()


def overview(
    study: StudySpec,
    participant: int,
    records: Sequence[Record],
    robots: Sequence[Mapping[str, float]],
    *,
    now: float,
    seen: float,
) -> Overview:
    """A session at a glance.

    Args:
        study: The study.
        participant: The number.
        records: Its journal.
        robots: What the session says of its robots, see `live.RobotSigns`.
        now: The time [s since 1970].
        seen: When the session said so [s since 1970].
    """
    head = head_of(records)
    steps = plan(study, participant, int(head.data["replaces"]) if head is not None else 0)
    done = frozenset(int(each.data["n"]) for each in records if each.what == DONE)
    last = max((at for at, each in enumerate(records) if each.what == BEGIN), default=-1)
    own = records[last:] if last >= 0 else []
    number = int(own[0].data["n"]) if own else -1
    step = steps[number] if 0 <= number < len(steps) and number not in done else None
    state = _state(step, own)
    if not records:
        state = State.ABSENT
    elif has_declined(records):
        state, step = State.DECLINED, None
    elif len(done) == len(steps):
        state = State.COMPLETE
    elapsed = _elapsed(own, now) if state in (State.RUNS, State.PAUSED, State.FROZEN) else 0.0
    minutes = sum(minutes_of(each) for each in steps if each.number not in done)
    runs = state is State.RUNS
    return Overview(
        state=state,
        step=step,
        attempt=int(own[0].data["attempt"]) if own and step is not None else 0,
        elapsed=elapsed,
        done=done,
        steps=steps,
        minutes=0.0 if state is State.DECLINED else max(0.0, minutes - elapsed / 60.0),
        silence=now - records[-1].at if records else 0.0,
        marks=sum(each.what == "order" and each.data.get("do") == MARK for each in records),
        alarms=(
            *_failures(records, steps, now),
            *(_silences(robots, now, seen) if runs and elapsed > _LOST_S else ()),
        ),
    )


def _state(step: Step | None, own: Sequence[Record]) -> State:
    """What the step that was begun last does."""
    if step is None:
        return State.BETWEEN
    state = State.WAITS if step.kind in (TRIAL, PRACTICE) else State.PAGE
    for each in own:
        state = _after(state, each)
    return state


def _after(state: State, record: Record) -> State:
    """The state after a record of the same step."""
    order = record.data.get("do") if record.what == "order" else ""
    if record.what in _ENDS:
        return State.BETWEEN
    if record.what == "frozen":
        return State.FROZEN
    if record.what in ("trial-begin", "unfrozen"):
        return State.RUNS
    if state is State.RUNS and order == PAUSE:
        return State.PAUSED
    return State.RUNS if state is State.PAUSED and order == GO_ON else state


def _elapsed(own: Sequence[Record], now: float) -> float:
    """Time of a trial without freezes and pauses [s]."""
    total, since = 0.0, 0.0
    state = State.WAITS
    for each in own:
        before, state = state, _after(state, each)
        if state is State.RUNS and before is not State.RUNS:
            since = each.at
        elif before is State.RUNS and state is not State.RUNS:
            total += each.at - since
    return max(0.0, total + (now - since if state is State.RUNS else 0.0))


def _failures(records: Sequence[Record], steps: Sequence[Step], now: float) -> Iterator[str]:
    """Trials that did not count lately."""
    for each in records:
        number = each.data.get("n")
        if each.what in _ENDS[1:] and now - each.at < _RECENT_S:
            known = isinstance(number, int) and 0 <= number < len(steps)
            name = steps[number].name if known and isinstance(number, int) else "a step"
            why = f": {each.data['why']}" if each.data.get("why") else ""
            yield f"{name} does not count and begins again{why}"


def _silences(robots: Sequence[Mapping[str, float]], now: float, seen: float) -> Iterator[str]:
    if now - seen > _LOST_S:
        yield f"the session gave no sign of life for {now - seen:.0f} s"
        return
    for number, robot in enumerate(robots, 1):
        silent = robot.get("silent", 0.0)
        if silent > _SILENT_S:
            yield f"robot {number} says nothing for {silent:.1f} s"
