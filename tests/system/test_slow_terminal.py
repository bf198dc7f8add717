"""A console on a slow terminal leaves nothing of the terminal's answers to the shell."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

from tests.system.terminal_process import TerminalProcess

ROOT = Path(__file__).parents[2]
DELAY_S = 0.4
"""From a question of the console to its answer [s]."""
SHELL = 'printf "BEGIN\\n"; "$@"; printf "END\\n"; exec cat -v'
"""What runs the console, and then shows what is typed."""


def test_no_answer_of_the_terminal_is_left_at_the_prompt() -> None:
    layout = ROOT / "layouts" / "minimal.xml"
    console = [sys.executable, "-m", "rune_tui", "run", str(layout)]
    terminal = TerminalProcess(["sh", "-c", SHELL, "sh", *console])
    answers: list[threading.Timer] = []
    answer_now = terminal.screen.write_process_input

    def answer_late(data: str) -> None:
        timer = threading.Timer(DELAY_S, answer_now, (data,))
        answers.append(timer)
        timer.start()

    try:
        terminal.wait(lambda: "connecting" in terminal.text, 60.0, "no console")
        terminal.screen.write_process_input = answer_late  # type: ignore[method-assign]
        asked = len(answers) + 3
        terminal.wait(lambda: len(answers) > asked, 30.0, "no frame is acknowledged")
        terminal.type("q")
        terminal.wait(lambda: "END" in terminal.text, 30.0, "it does not end")
        terminal.wait(lambda: not any(each.is_alive() for each in answers), 30.0)
        terminal.type("typed\n")
        terminal.wait(lambda: terminal.text.count("typed") >= 2, 10.0, "no shell")
        assert "[2;" not in terminal.text
        assert "[3;" not in terminal.text
    finally:
        terminal.close()
