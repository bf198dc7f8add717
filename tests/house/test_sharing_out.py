"""Workers that share the tests begin with those that wait."""

from __future__ import annotations

from itertools import groupby, pairwise

import pytest

from tests.support.cases import for_each
from tests.support.sharing_out import shared_out

Test = tuple[str, int]


def file_of(test: Test) -> str:
    return test[0]


def waits(test: Test) -> bool:
    return test[0].startswith("waits")


def written(**files: int) -> list[Test]:
    return [(file, number) for file, tests in files.items() for number in range(tests)]


@for_each("workers", [1, 2, 3, 4])
def test_each_worker_begins_with_whole_files_of_tests_that_wait(workers: int) -> None:
    tests = written(a=50, b=31, waits_1=4, waits_2=1, waits_3=3, waits_4=2, waits_5=2, z=20)
    ordered = shared_out(tests, workers, file_of, waits)
    assert sorted(ordered) == tests
    bounds = [len(tests) * number // workers for number in range(workers + 1)]
    for begin, end in pairwise(bounds):
        kinds = [waiting for waiting, _ in groupby(ordered[begin:end], waits)]
        assert kinds == [True, False]
    files = [file for file, _ in groupby(filter(waits, ordered), file_of)]
    assert len(files) == len(set(files))


@pytest.mark.parametrize("workers", [2, 3])
def test_tests_of_one_kind_are_all_run(workers: int) -> None:
    for tests in (written(a=7), written(waits_1=5, waits_2=1), []):
        assert sorted(shared_out(tests, workers, file_of, waits)) == tests
