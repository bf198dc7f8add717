"""Asking a real pseudo terminal with somebody behind it."""

from __future__ import annotations

import os
import pty
import termios
import threading
import tty
from collections.abc import Iterator

import pytest

from rune_tui.terminal.asking import ask
from rune_tui.terminal.questions import QUESTIONS, Answers
from tests.console.terminal.test_questions import MODERN


@pytest.fixture
def pair() -> Iterator[tuple[int, int]]:
    """The outer and the inner end of a terminal."""
    outer, inner = pty.openpty()
    yield outer, inner
    for end in (outer, inner):
        os.close(end)


def answer(outer: int, *pieces: bytes) -> threading.Thread:
    """A terminal that reads all questions and then answers."""

    def run() -> None:
        seen = b""
        while QUESTIONS.encode() not in seen:
            seen += os.read(outer, 4096)
        for piece in pieces:
            os.write(outer, piece)

    thread = threading.Thread(target=run)
    thread.start()
    return thread


def test_a_terminal_that_answers_is_understood_and_left_as_it_was(pair: tuple[int, int]) -> None:
    outer, inner = pair
    before = termios.tcgetattr(inner)
    thread = answer(outer, MODERN[:30], MODERN[30:])
    answers, took = ask(inner, inner, 20.0)
    thread.join()
    assert answers.complete
    assert answers.truecolour
    assert took < 20.0
    assert termios.tcgetattr(inner) == before


def test_what_a_killed_console_left_behind_is_ended_before_anything_is_asked(
    pair: tuple[int, int],
) -> None:
    outer, inner = pair
    usual = termios.tcgetattr(inner)
    tty.setraw(inner)
    ask(inner, inner, 0.0)
    written = ""
    while QUESTIONS not in written:
        written += os.read(outer, 65_536).decode()
    asked = written.index(QUESTIONS)
    for mode in ("?1000l", "?1003l", "?1006l", "?2004l", "<9u"):
        assert 0 <= written.find(f"\x1b[{mode}") < asked, mode
    now = termios.tcgetattr(inner)
    for flag in (termios.ICANON, termios.ECHO, termios.ISIG):
        assert now[3] & flag == usual[3] & flag != 0


def test_a_terminal_that_says_nothing_is_waited_for_so_long_and_no_longer(
    pair: tuple[int, int],
) -> None:
    answers, took = ask(pair[1], pair[1], 0.05)
    assert answers == Answers()
    assert took >= 0.05


def test_a_file_that_is_no_terminal_is_no_fault() -> None:
    source, sink = os.pipe()
    os.close(sink)
    answers, _ = ask(source, os.open(os.devnull, os.O_WRONLY), 1.0)
    assert answers == Answers()
    os.close(source)
