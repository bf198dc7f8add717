"""In which order tests run that several workers of pytest-xdist share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import islice
from typing import TypeVar

Test = TypeVar("Test")


def shared_out(
    tests: Sequence[Test],
    workers: int,
    file_of: Callable[[Test], object],
    waits: Callable[[Test], bool],
) -> list[Test]:
    """The tests, so that each worker begins with files whose tests mostly wait.

    Waiting, they leave the processors to each other; what only computes comes last, where workers
    take it from each other until all of them end. A worker gets a file whole, and starts once what
    its tests share.

    Args:
        tests: All of them, those of a file one after the other.
        workers: How many there are; each is given as many tests, one after the other.
        file_of: The file of a test.
        waits: Whether a test is one that mostly waits.
    """
    files: dict[object, list[Test]] = {}
    for test in filter(waits, tests):
        files.setdefault(file_of(test), []).append(test)
    hands: list[list[Test]] = [[] for _ in range(workers)]
    for number, file in enumerate(files.values()):
        hands[number % workers] += file
    others = (test for test in tests if not waits(test))
    ordered: list[Test] = []
    for number, hand in enumerate(hands, start=1):
        share = len(tests) * number // workers - len(ordered) - len(hand)
        ordered += [*hand, *islice(others, max(0, share))]
    return [*ordered, *others]
