"""`rune-hub record` refuses marks that nobody can read, and ends although its disk hangs."""

from __future__ import annotations

import threading
from contextlib import closing
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.ipc.broker.central import Central
from tests.support.command_line import rune_hub


@pytest.mark.parametrize(
    ("order", "text", "why"),
    [
        ("--mark", "", "a mark needs words"),
        ("--mark", "  ", "a mark needs words"),
        ("--mark", "x" * 100_000, "the text has 100000 letters; 1000 are the most"),
        ("--snapshot", "x" * 1001, "the text has 1001 letters; 1000 are the most"),
    ],
)
def test_texts_without_words_and_long_ones_are_refused(order: str, text: str, why: str) -> None:
    done = rune_hub("record", order, text)
    assert done.returncode == 2
    assert why in done.stderr


def test_a_disk_that_hangs_is_waited_for_no_longer_than_the_robots_recorder_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = threading.Event()
    # The edge of the hardware: a disk that does not say that it has the data.
    monkeypatch.setattr("os.fdatasync", lambda _: answers.wait(30.0))
    path = tmp_path / "a.mcap"
    with closing(Central(["tcp://127.0.0.1:0"])) as central:
        place = ("--hub", central.endpoints[0], "-o", str(path))
        done = rune_hub("record", *place, "--duration", "0.2", "--least-free", "0")
    hung = not answers.is_set()
    answers.set()
    assert done.returncode == ExitCode.FAULT
    assert hung, "it waited for the disk"
    assert f"{path} has no end yet: the disk has not taken it for 2 s" in done.stderr
