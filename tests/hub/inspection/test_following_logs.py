"""`rune-hub logs -f` while the daemon ends and begins anew, or is busy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from hub.errors import (
    HandlerFailedError,
    NoHandlerError,
    QueryTimeoutError,
    UnknownModuleError,
)
from hub.gcm.supervision import LogLines, ModuleReports
from hub.inspection import module_commands


class Daemons:
    """Answers as daemons do, one after the other; at the end the module is unknown."""

    def __init__(self, *answers: LogLines | Exception) -> None:
        self.connected, self.endpoint = True, "ipc://nowhere"
        self.asked: list[int] = []
        self._answers: Iterator[LogLines | Exception] = iter(answers)

    def listen(self, timeout: float) -> None:
        """Nothing comes."""

    def query_response(self, _: object, request: Any, *__: object, timeout: float) -> LogLines:
        del timeout
        self.asked.append(request.first)
        answer = next(self._answers, HandlerFailedError("there is no module"))
        if isinstance(answer, Exception):
            raise answer
        return answer

    def last_value(self, _: object, *, timeout: float) -> ModuleReports:
        del timeout
        return ModuleReports(robot="test", modules=())


def lines(first: int, *words: str) -> LogLines:
    text = "".join(f"{word}\n" for word in words)
    return LogLines(first=first, next=first + len(words), text=text)


def follow(daemons: Any) -> None:
    with pytest.raises(UnknownModuleError):
        module_commands.logs(daemons, "one", lines=10, follow=True)


def test_daemon_that_does_not_answer_yet_is_waited_for(capsys: pytest.CaptureFixture[str]) -> None:
    nobody = NoHandlerError("nobody answers")
    daemons = Daemons(lines(50, "a"), nobody, nobody, lines(1, "b"), lines(2))
    follow(daemons)
    assert capsys.readouterr().out == "a\nb\n"
    assert daemons.asked == [0, 51, 1, 1, 2, 2]


def test_busy_daemon_is_asked_again_for_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    daemons = Daemons(lines(50, "a"), QueryTimeoutError("no answer"), lines(51, "b"))
    follow(daemons)
    assert capsys.readouterr().out == "a\nb\n"
    assert daemons.asked == [0, 51, 51, 52]


def test_daemon_that_began_anew_between_two_questions_is_noticed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    daemons = Daemons(lines(50, "a"), lines(3), lines(1, "b", "c"))
    follow(daemons)
    assert capsys.readouterr().out == "a\nb\nc\n"
    assert daemons.asked == [0, 51, 1, 3]
