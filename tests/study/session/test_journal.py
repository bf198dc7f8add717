"""A session goes on after any crash at the first step that is not done."""

from __future__ import annotations

import os
import random
import selectors
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from rune_study.errors import ChangedStudyError, StudyError
from rune_study.plan.folder import participant_folder
from rune_study.plan.steps import plan
from rune_study.session.journal import JOURNAL, Journal, read_journal
from rune_study.session.progress import DeclinedError, LeftError, run_steps
from rune_study.session.session import length_in_words, misses_aim
from rune_study.session.status import status_lines
from rune_study.session.warnings import warnings_of
from tests.study.studies import FOUR, HEAD, study_of
from tests.support.repetitions import repetitions

WORKER = """
import sys
from pathlib import Path
from rune_study.plan.steps import plan
from rune_study.plan.study_file import read_study
from rune_study.session.journal import Journal
from rune_study.session.progress import run_steps

study = read_study(Path(sys.argv[1]))

def do(step, attempt):
    print("x", flush=True)
    return {"attempt": attempt}

with Journal.of(study, 3) as journal:
    for step in plan(study, 3):
        run_steps([step], journal, do)
        print("y", flush=True)
"""


class CutError(Exception):
    """Stands for the end of a process."""


def test_a_session_killed_at_any_moment_goes_on(tmp_path: Path) -> None:
    """Each process gets some way, is killed without warning, and the next one goes on."""
    study = study_of(tmp_path, FOUR)
    steps = plan(study, 3)
    path = tmp_path / "sub-03" / JOURNAL
    lot = random.Random(1)
    kills = 0
    while kills < repetitions(10, 200):
        if path.exists():
            path.unlink()
        before: list[tuple[str, dict[str, object]]] = []
        while True:
            ended = _killed_after(lot.randrange(8), lot.random() * 0.004, tmp_path)
            records = read_journal(path) if path.exists() else []
            kept = [(each.what, each.data) for each in records]
            assert kept[: len(before)] == before, "a record was lost"
            before = kept
            if ended:
                break
            kills += 1
        done = [each.data["n"] for each in records if each.what == "done"]
        assert done == [step.number for step in steps]


def _killed_after(lines: int, later: float, folder: Path) -> bool:
    """Whether the process ended before it had written some lines and was killed."""
    with subprocess.Popen([sys.executable, "-c", WORKER, str(folder)], stdout=-1) as worker:
        assert worker.stdout is not None
        for _ in range(lines):
            if not worker.stdout.readline():
                assert worker.wait() == 0
                return True
        with selectors.DefaultSelector() as nothing:
            nothing.select(later)
        os.kill(worker.pid, signal.SIGKILL)
        worker.stdout.read()
    return False


def test_nothing_is_lost_and_nothing_twice_at_any_cut(tmp_path: Path) -> None:
    """The model of the same: also with a last line that is torn anywhere."""
    study = study_of(tmp_path, FOUR)
    steps = plan(study, 3)
    path = tmp_path / "sub-03" / JOURNAL
    for seed in range(repetitions(30, 1000)):
        lot = random.Random(seed)
        path.unlink(missing_ok=True)
        finished: Counter[int] = Counter()

        def do(step, attempt, lot=lot, finished=finished):
            if lot.random() < 0.2:
                raise CutError
            finished[step.number] += 1
            return {"attempt": attempt}

        while True:
            try:
                with Journal.of(study, 3) as journal:
                    assert run_steps(steps, journal, do)
                break
            except CutError:
                raw = path.read_bytes()
                torn = lot.randrange(1, 20) if lot.random() < 0.5 else 0
                last = raw[:-1].rfind(b"\n") + 1
                path.write_bytes(raw[: max(last, len(raw) - torn)])
        done = [each.data["n"] for each in read_journal(path) if each.what == "done"]
        assert sorted(done) == [step.number for step in steps]
        assert set(finished.values()) == {1}


def test_a_changed_study_is_refused(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    Journal.of(study, 1).close()
    changed = study_of(tmp_path, FOUR + "\n")
    with pytest.raises(ChangedStudyError, match="was changed after the session"):
        Journal.of(changed, 1)
    (tmp_path / "study.toml").write_text(HEAD)
    Journal.of(study, 1).close()


def test_who_replaces_is_written_down(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    with Journal.of(study, 17, replaces=7) as journal:
        assert journal.replaces == 7
    with Journal.of(study, 17) as journal:
        assert journal.replaces == 7
    with pytest.raises(ChangedStudyError, match="in the place of 7"):
        Journal.of(study, 17, replaces=8)


def test_a_step_that_is_left_or_failed_is_begun_again(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    steps = plan(study, 1)
    seen: list[tuple[int, int]] = []

    def do(step, attempt):
        seen.append((step.number, attempt))
        if step.number == 1 and attempt == 1:
            return None
        if step.number == 2 and attempt == 1:
            text = "the participant left"
            raise LeftError(text)
        return {}

    with Journal.of(study, 1) as journal:
        assert not run_steps(steps, journal, do)
        assert run_steps(steps, journal, do)
    assert seen == [(0, 1), (1, 1), (1, 2), (2, 1), (2, 2), (3, 1)]


def test_other_lines_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / JOURNAL
    with Journal(path) as journal:
        journal.put("begin", other=1)
        journal.put("note", text="hello")
        journal.put("done", n="three")
    assert [each.what for each in read_journal(path)] == ["note"]


def test_a_session_runs_once(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    with Journal.of(study, 1), pytest.raises(StudyError, match="runs in another terminal"):
        Journal.of(study, 1)
    Journal.of(study, 1).close()


def test_a_changed_study_is_refused_for_further_participants(tmp_path: Path) -> None:
    Journal.of(study_of(tmp_path, FOUR), 1).close()
    changed = study_of(tmp_path, FOUR + "\n")
    with pytest.raises(ChangedStudyError, match="session of participant 1 began; undo"):
        Journal.of(changed, 2)
    Journal.of(study_of(tmp_path, FOUR), 2).close()


def test_a_folder_of_another_participant_is_refused(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    Journal.of(study, 1).close()
    participant_folder(tmp_path, 1).rename(participant_folder(tmp_path, 2))
    with pytest.raises(ChangedStudyError, match="has the session of participant 1; give"):
        Journal.of(study, 2)
    assert "has the session of participant 1" in "".join(warnings_of(study, [2]))


def test_damaged_lines_are_counted(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    with Journal.of(study, 1) as journal:
        journal.put("note", text="one")
        journal.put("note", text="two")
    assert list(warnings_of(study, [1, 2])) == []
    journal.path.write_bytes(journal.path.read_bytes().replace(b"one", b"on3"))
    assert list(warnings_of(study, [1])) == [f"1 line of {journal.path} is damaged, and left out"]


def test_warnings_name_who_began_with_another_study(tmp_path: Path) -> None:
    Journal.of(study_of(tmp_path, FOUR), 1).close()
    changed = study_of(tmp_path, FOUR + "\n")
    assert "participant 1 began with another version" in "".join(warnings_of(changed, [1]))


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(10.0, "10 seconds"), (90.0, "90 seconds"), (120.0, "2 minutes"), (600.0, "10 minutes")],
)
def test_short_trials_have_their_length_in_seconds(seconds: float, words: str) -> None:
    assert length_in_words(seconds) == words


def test_who_declines_is_replaced(tmp_path: Path) -> None:
    """Also when the one who takes over declines, it is the order of the first."""
    study = study_of(tmp_path, FOUR)

    def refuse(step, attempt):
        text = f"{step.name} {attempt}"
        raise DeclinedError(text)

    for participant, replaces in ((1, 0), (2, 1)):
        with Journal.of(study, participant, replaces) as journal:
            assert not run_steps(plan(study, participant, replaces), journal, refuse)
            assert journal.declined
        *lines, following = status_lines(study)
        assert lines[participant - 1].startswith(f"  {participant}  ")
        assert "declined" in lines[participant - 1]
        assert following.endswith(f"--participant {participant + 1} --replaces 1")
    Journal.of(study, 3, 1).close()
    assert "--replaces" not in list(status_lines(study))[-1]


def test_practice_without_its_aim_is_in_the_status(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    for passed, words in ((True, False), (False, True)):
        with Journal.of(study, 1 + passed) as journal:
            journal.put("done", n=0, result={"passed": passed})
        found = [line for line in status_lines(study) if line.startswith(f"  {1 + passed}  ")]
        assert ["practice not passed" in line for line in found] == [words]


def test_only_practice_that_was_quit_misses_its_aim() -> None:
    assert misses_aim({"passed": False, "ended": "operator"})
    assert not misses_aim({"passed": True, "ended": "criterion"})
    assert not misses_aim({"ended": "operator"})
