"""Each file in tests/bad_layouts begins with the problems it must cause, and causes no others.

A problem is `line:column: message`, without the column where there is none, and with the name of a
part in front where it is there.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rune_tui.errors import LayoutError, LayoutProblem
from rune_tui.startup.opening import open_layout
from tests.support.cases import for_each

FOLDER = Path(__file__).parents[2] / "bad_layouts"
FILES = sorted(FOLDER.glob("*.xml"))


def expected(path: Path) -> list[tuple[str, str]]:
    """Places and what is said of them."""
    comment = path.read_text(encoding="utf-8", errors="replace").split("-->")[0]
    found = re.findall(r"^((?:parts/\w+\.xml:)?\d+(?::\d+)?): (.*)$", comment, re.MULTILINE)
    return [(place, message) for place, message in found]


def place(problem: LayoutProblem, path: Path) -> str:
    shown = f"{problem.line}:{problem.column}" if problem.column else str(problem.line)
    inner = "" if problem.path == str(path) else f"{Path(problem.path).relative_to(FOLDER)}:"
    return inner + shown


def test_there_are_bad_layouts_and_all_of_them_say_what_is_wrong():
    assert len(FILES) >= 90
    assert all(expected(path) for path in FILES)


@for_each("path", FILES)
def test_a_bad_layout_causes_exactly_the_problems_it_announces(path: Path):
    with pytest.raises(LayoutError) as caught:
        open_layout(path)
    remaining = list(caught.value.problems)
    for where, part in expected(path):
        found = [one for one in remaining if place(one, path) == where and part in one.message]
        assert found, f"missing {where}: {part}\nleft:\n" + "\n".join(map(str, remaining))
        remaining.remove(found[0])
    assert remaining == []
    for problem in caught.value.problems:
        assert problem.message.isprintable()
        assert str(problem).startswith(f"{problem.path}:{problem.line}:")
