"""A session that is killed within the questions of a freeze loses no answer, and has none twice."""

from __future__ import annotations

import itertools
import os
import random
import selectors
import signal
import subprocess
import sys
from pathlib import Path

from rune_study.data.probes import probes_of
from rune_study.questionnaires.answers import read_answers
from rune_study.session.freezing import ANSWERS, PROBE
from rune_study.session.journal import BEGIN, DONE, JOURNAL, Record, read_journal
from tests.study.studies import study_of
from tests.support.repetitions import repetitions

STUDY = """
    [factors]
    layout = ["minimal"]
    [trial]
    seconds = 60
    [freeze]
    count = 2
    not_before_s = 1
    apart_s = 1
    """
WORKER = """
import asyncio, dataclasses, sys
from pathlib import Path
from rune_study.plan.steps import plan
from rune_study.plan.study_file import read_study
from rune_study.questionnaires.answers import Answers
from rune_study.questionnaires.asking import QuestionnaireScreen
from rune_study.questionnaires.items import NumberItem
from rune_study.questionnaires.questionnaire import Questionnaire
from rune_study.session.freezing import ANSWERS, FROZEN, PROBE, AskedQuery, occasion_of
from rune_study.session.journal import Journal
from rune_study.session.progress import run_steps

study = read_study(Path(sys.argv[1]))
items = tuple(NumberItem(id=f"q{n}", text="?", truth="battery") for n in range(2))
asked = Questionnaire(name="sagat", title="Now", items=items)
queries = [
    AskedQuery(id=each.id, truth="battery", kind="number", level=1, robot=1, right=5.0,
               tolerance=0.0)
    for each in items
]

def do(step, attempt):
    journal.put("trial-begin", n=step.number, moment_s=0.0)
    for freeze in (1, 2):
        journal.put(FROZEN, n=step.number, number=freeze,
                    queries=[dataclasses.asdict(each) for each in queries])
        occasion = occasion_of(step.name, attempt, freeze)
        def note(given):
            journal.put(PROBE, n=step.number, number=freeze, id=given.item)
        with Answers(journal.path.parent / ANSWERS) as answers:
            async def run():
                app = QuestionnaireScreen(asked, answers, occasion, "s", None, note)
                async with app.run_test(size=(80, 24)) as pilot:
                    for _ in items:
                        await pilot.press("5", "enter")
                        print("x", flush=True)
            asyncio.run(run())
        journal.put("unfrozen", n=step.number, number=freeze)
    return {}

with Journal.of(study, 1) as journal:
    print("x", flush=True)
    run_steps(plan(study, 1), journal, do)
"""


def test_answers_of_a_freeze_survive_kills_and_come_once(tmp_path: Path) -> None:
    lot = random.Random(5)
    kills = 0
    for number in itertools.count():
        folder = tmp_path / str(number)
        folder.mkdir()
        study_of(folder, STUDY)
        kills += _session(folder, lot)
        if kills >= repetitions(1, 200):
            break


def _session(study: Path, lot: random.Random) -> int:
    """A session that is killed again and again, up to its end; returns the number of kills."""
    folder = study / "sub-01"
    path = folder / ANSWERS
    before: list[tuple[str, str, object]] = []
    kills = 0
    while not _killed_after(lot.randrange(7), lot.random() * 0.01, study):
        kills += 1
        kept = _answers(path)
        assert kept[: len(before)] == before, "an answer was lost"
        assert len({each[:2] for each in kept}) == len(kept), "an answer came twice"
        before = kept
    records = read_journal(folder / JOURNAL)
    begins = [each.data["attempt"] for each in records if each.what == BEGIN]
    assert begins == list(range(1, len(begins) + 1))
    assert [each.data["attempt"] for each in records if each.what == DONE] == begins[-1:]
    scored = probes_of(_of_attempt(records, begins[-1]), "t1", begins[-1], read_answers(path))
    assert [each.query.right for each in scored] == [True] * 4
    noted = [each for each in records if each.what == PROBE]
    answers = len(_answers(path))
    assert answers - kills <= len(noted) <= answers
    return kills


def _answers(path: Path) -> list[tuple[str, str, object]]:
    given = read_answers(path) if path.exists() else []
    return [(each.occasion, each.item, each.value) for each in given]


def _of_attempt(records: list[Record], attempt: int) -> list[Record]:
    begin = next(
        at
        for at, each in enumerate(records)
        if each.what == BEGIN and each.data["attempt"] == attempt
    )
    return records[begin:]


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
