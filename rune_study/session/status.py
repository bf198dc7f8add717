"""How far a study is: who did what, as far as their journals say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hub.plain_text import counted
from hub.values import dataclass
from rune_study.plan.conditions import condition_lines
from rune_study.plan.steps import TRIAL, plan
from rune_study.plan.study_spec import MOST_PARTICIPANTS, StudySpec
from rune_study.session.journal import (
    BEGIN,
    DONE,
    Record,
    has_declined,
    head_of,
    journal_path,
    participants_of,
    read_journal,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How far a participant is.

    Attributes:
        participant: The number.
        replaces: The participant whose order this one took over; 0: none.
        done: Steps that are done.
        steps: Steps in all.
        trials: Trials that are done.
        order: Codes of all trials.
        attempts: Begun steps more than done ones.
        now: The step that was begun last and is not done; empty: none.
        other_study: Whether it began with another study than the folder has now.
        declined: Whether the participant did not agree to take part.
        passed: False: practice is done, and its criterion was not met.
    """

    participant: int
    replaces: int
    done: int
    steps: int
    trials: int
    order: str
    attempts: int
    now: str
    other_study: bool
    declined: bool
    passed: bool


def progress_of(study: StudySpec, participant: int) -> Progress:
    """How far a participant is.

    Raises:
        StudyError: The journal cannot be read.
    """
    return progress_in(study, participant, read_journal(journal_path(study.folder, participant)))


def progress_in(study: StudySpec, participant: int, records: list[Record]) -> Progress:
    """The same from the records of a journal."""
    head = head_of(records)
    replaces = int(head.data["replaces"]) if head is not None else 0
    steps = plan(study, participant, replaces)
    done = {int(each.data["n"]) for each in records if each.what == DONE}
    begun = [int(each.data["n"]) for each in records if each.what == BEGIN]
    last = begun[-1] if begun else -1
    trials = [step for step in steps if step.kind == TRIAL]
    open_step = 0 <= last < len(steps) and last not in done
    return Progress(
        participant=participant,
        replaces=replaces,
        done=len(done),
        steps=len(steps),
        trials=sum(step.number in done for step in trials),
        order="".join(step.code for step in trials),
        attempts=len(begun) - len(set(begun)),
        now=steps[last].name if open_step else "",
        other_study=head is not None and head.data["study"] != study.digest,
        declined=has_declined(records),
        passed=all(_passed(each) for each in records if each.what == DONE),
    )


def next_participant(known: Sequence[int]) -> int:
    """The first number that is free."""
    return next((n for n in range(1, MOST_PARTICIPANTS) if n not in known), 0)


def _passed(done: Record) -> bool:
    result = done.data.get("result")
    return not isinstance(result, dict) or result.get("passed") is not False


def state_words(progress: Progress) -> str:
    """How far a participant is, in words."""
    done, steps = progress.done, progress.steps
    what = "complete" if done == steps else f"{done} of {counted(steps, 'step')}"
    notes = ["declined" if progress.declined else what]
    notes += [f"replaces {progress.replaces}"] if progress.replaces else []
    notes += [f"at {progress.now}"] if progress.now and not progress.declined else []
    notes += [f"{progress.attempts} begun again"] if progress.attempts else []
    notes += ["with another study"] if progress.other_study else []
    notes += [] if progress.passed else ["practice not passed"]
    return ", ".join(notes)


def status_lines(study: StudySpec) -> Iterator[str]:
    """A line for each condition unless the study is blind, for each participant, and the next."""
    known = participants_of(study)
    if not study.design.blind:
        yield from condition_lines(study)
    complete = 0
    open_sessions: list[int] = []
    declined: set[int] = set()
    taken: set[int] = set()
    for participant in known:
        each = progress_of(study, participant)
        complete += each.done == each.steps
        if each.done < each.steps and not each.declined and not each.other_study:
            open_sessions.append(participant)
        (declined if each.declined else taken).add(each.replaces or participant)
        yield f"{participant:3}  {each.order}  {state_words(each)}"
    are = "is" if study.participants == 1 else "are"
    yield f"{complete} of {counted(study.participants, 'participant')} {are} complete"
    for participant in open_sessions:
        yield f"go on: rune study run {study.folder} --participant {participant}"
    line = f"next: rune study run {study.folder} --participant {next_participant(known)}"
    free = declined - taken
    yield f"{line} --replaces {min(free)}" if free else line
