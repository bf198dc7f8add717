"""Each file in tests/bad_layouts begins with the problems it must cause, and causes no others."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rune_tui.errors import LayoutError
from rune_tui.opening import open_layout

FILES = sorted((Path(__file__).parents[2] / "bad_layouts").glob("*.xml"))


def expected(path: Path) -> list[tuple[int, str]]:
    comment = path.read_text(encoding="utf-8", errors="replace").split("-->")[0]
    return [
        (int(found[1]), found[2]) for found in re.finditer(r"^(\d+): (.*)$", comment, re.MULTILINE)
    ]


def test_there_are_bad_layouts_and_all_of_them_say_what_is_wrong():
    assert len(FILES) >= 20
    assert all(expected(path) for path in FILES)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_bad_layout_causes_exactly_the_problems_it_announces(path: Path):
    with pytest.raises(LayoutError) as caught:
        open_layout(path)
    remaining = list(caught.value.problems)
    for line, part in expected(path):
        found = [one for one in remaining if one.line == line and part in one.message]
        assert found, f"missing {line}: {part}\nleft:\n" + "\n".join(map(str, remaining))
        remaining.remove(found[0])
    assert remaining == []
    assert {problem.path for problem in caught.value.problems} == {str(path)}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_problem_is_one_printable_line(path: Path):
    with pytest.raises(LayoutError) as caught:
        open_layout(path)
    for problem in caught.value.problems:
        assert problem.message.isprintable()
        assert str(problem).startswith(f"{path}:{problem.line}:")
