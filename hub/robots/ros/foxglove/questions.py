"""Questions to a bridge that wait for their answers; pure."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Final, Generic, TypeVar

MOST_QUESTIONS: Final = 100

Answer = TypeVar("Answer")


class OpenQuestions(Generic[Answer]):
    """Questions of one kind, each with its time; each ends once."""

    def __init__(self) -> None:
        self._waiting: dict[Hashable, tuple[Callable[[Answer | None, str], None], float]] = {}

    @property
    def full(self) -> bool:
        """Whether there is no room for another."""
        return len(self._waiting) >= MOST_QUESTIONS

    def add(
        self, name: Hashable, answered: Callable[[Answer | None, str], None], end: float
    ) -> None:
        """Wait for an answer.

        Args:
            name: Names the question.
            answered: Takes the answer and ""; or None and the reason why there is none.
            end: When it ends without an answer [s, monotonic].
        """
        self._waiting[name] = (answered, end)

    def end(self, name: Hashable, answer: Answer | None, why: str = "") -> bool:
        """Pass an answer on; returns whether there was the question."""
        found = self._waiting.pop(name, None)
        if found is not None:
            found[0](answer, why)
        return found is not None

    def expire(self, now: float) -> None:
        """End the questions that are too old."""
        if self._waiting:
            for name in [name for name, (_, end) in self._waiting.items() if now > end]:
                self.end(name, None, "the robot does not answer")

    def fail(self, why: str) -> None:
        """End all."""
        for name in tuple(self._waiting):
            self.end(name, None, why)
