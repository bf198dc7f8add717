"""A questionnaire in a terminal survives a kill between any two answers."""

from __future__ import annotations

import asyncio
import math
import os
import pty
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rune_study.errors import AnswersError
from rune_study.questionnaires.answers import Answers
from rune_study.questionnaires.asking import QuestionnaireScreen, is_refused
from rune_study.questionnaires.questionnaire import Questionnaire, find, read

SUS = read(find("sus"))
CONSENT = read(find("consent"))


def press(questionnaire: Questionnaire, answers: Answers, *keys: str) -> tuple[bool | None, str]:
    """What the screen returned, and what it showed at the end."""

    async def run() -> tuple[bool | None, str]:
        app = QuestionnaireScreen(questionnaire, answers, "t1", "p01")
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.press(*keys)
            await pilot.pause()
            shown = str(app.query_one("#item").render())
        return app.return_value, shown

    return asyncio.run(run())


def test_answers_are_there_after_each_item_and_the_rest_is_asked_later(tmp_path: Path) -> None:
    with Answers(tmp_path / "answers.journal") as answers:
        ended, shown = press(SUS, answers, "4", "enter", "2", "enter", "3")
        assert ended is None
        assert "3 of 10" in shown
    with Answers(tmp_path / "answers.journal") as again:
        assert again.of(SUS, "t1") == {"q1": 4.0, "q2": 2.0}
        ended, _ = press(SUS, again, *["5", "enter"] * 8)
        assert ended is True
        assert len(again.of(SUS, "t1")) == 10
        assert press(SUS, again)[0] is True


def test_a_torn_last_answer_is_asked_again(tmp_path: Path) -> None:
    path = tmp_path / "answers.journal"
    with Answers(path) as answers:
        press(SUS, answers, "4", "enter", "2", "enter")
    path.write_bytes(path.read_bytes()[:-7])
    with Answers(path) as again:
        assert again.of(SUS, "t1") == {"q1": 4.0}


def test_who_does_not_agree_is_asked_nothing_further(tmp_path: Path) -> None:
    with Answers(tmp_path / "answers.journal") as answers:
        ended, shown = press(CONSENT, answers, "enter", "2", "enter")
        assert ended is None
        assert "No ends the session" in shown
        assert answers.of(CONSENT, "t1") == {}
        assert press(CONSENT, answers, "enter", "2", "enter", "enter")[0] is False
        assert press(CONSENT, answers)[0] is False
    assert is_refused(CONSENT, tmp_path / "answers.journal", "t1")
    assert not is_refused(CONSENT, tmp_path / "answers.journal", "t2")


def test_a_no_can_be_taken_back(tmp_path: Path) -> None:
    with Answers(tmp_path / "answers.journal") as answers:
        assert press(CONSENT, answers, "enter", "2", "enter", "up", "enter")[0] is True


def test_the_text_is_read_before_the_first_item(tmp_path: Path) -> None:
    with Answers(tmp_path / "answers.journal") as answers:
        _, shown = press(CONSENT, answers, "1", "2")
        assert "You may stop at any time" in shown
        assert answers.of(CONSENT, "t1") == {}


def test_an_answer_outside_its_scale_is_refused(tmp_path: Path) -> None:
    with Answers(tmp_path / "answers.journal") as answers:
        for wrong in (0.0, 6.0, 2.5, math.nan, "3", True):
            with pytest.raises(AnswersError, match="is no answer to q1 of sus"):
                answers.give(SUS, "t1", SUS.items[0], wrong, 1.0)


def test_a_killed_terminal_loses_no_answer(tmp_path: Path) -> None:
    path = tmp_path / "answers.journal"
    code = (
        "import sys; from pathlib import Path\n"
        "from rune_study.questionnaires.asking import ask\n"
        "from rune_study.questionnaires.questionnaire import find, read\n"
        "ask(read(find('sus')), Path(sys.argv[1]), 't1', 'p01')\n"
    )
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(path)],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        env=os.environ | {"TERM": "xterm-256color"},
    )
    os.close(theirs)
    shown = b""
    try:
        for number in range(1, 4):
            while f"{number} of 10".encode() not in shown:
                shown += os.read(ours, 65536)
            shown = b""
            os.write(ours, b"4\r")
        while b"4 of 10" not in shown:
            shown += os.read(ours, 65536)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
        os.close(ours)
    with Answers(path) as answers:
        assert answers.of(SUS, "t1") == {"q1": 4.0, "q2": 4.0, "q3": 4.0}
