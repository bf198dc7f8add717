"""Classes are short and have the attributes that they name; the app only puts parts together."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DECISION = ROOT / "docs/decisions/0028-classes-have-at-most-300-lines.md"
APP = ROOT / "rune_tui/app.py"
MOST_LINES = 300
MOST_APP_LINES, MOST_APP_IMPORTS = 250, 25


@dataclass(frozen=True, slots=True, kw_only=True)
class ClassFacts:
    """What is read of a class.

    Attributes:
        path: File that it stands in.
        name: Its name.
        lines: Its length [lines].
        absent: Attributes that its docstring names and its body does not; none if it inherits.
    """

    path: Path
    name: str
    lines: int
    absent: frozenset[str]


@pytest.fixture(scope="module")
def classes() -> list[ClassFacts]:
    return [
        ClassFacts(
            path=path.relative_to(ROOT),
            name=node.name,
            lines=(node.end_lineno or 0) - node.lineno + 1,
            absent=frozenset() if node.bases else _absent(node),
        )
        for package in ("hub", "rune_study", "rune_tui")
        for path in (ROOT / package).rglob("*.py")
        for node in _classes_in(ast.parse(path.read_text()))
    ]


def _classes_in(node: ast.Module | ast.ClassDef) -> Iterator[ast.ClassDef]:
    for each in node.body:
        if isinstance(each, ast.ClassDef):
            yield each
            yield from _classes_in(each)


def _absent(node: ast.ClassDef) -> frozenset[str]:
    part = (ast.get_docstring(node) or "").partition("Attributes:\n")[2]
    named = frozenset(re.findall(r"^    (\w+):", part, re.MULTILINE))
    return named.difference(map(_name_in, ast.walk(node))) if named else named


def _name_in(node: ast.AST) -> str | None:
    """The name that a node of a class uses or defines; texts count, they may name a slot."""
    match node:
        case ast.Attribute(attr=name) | ast.Name(id=name) | ast.FunctionDef(name=name):
            return name
        case ast.Constant(value=str() as text):
            return text
    return None


def test_classes_are_short_except_those_that_a_decision_names(classes: list[ClassFacts]) -> None:
    excepted = set(re.findall(r"^\| `(\w+)` \|", DECISION.read_text(), re.MULTILINE))
    long = {each.name for each in classes if each.lines > MOST_LINES}
    assert long <= excepted
    assert excepted <= long, "take classes that became short out of the decision"


def test_attributes_that_a_docstring_names_exist(classes: list[ClassFacts]) -> None:
    """A renamed attribute takes its line along; classes that inherit may name what they inherit."""
    absent = [f"{each.path}: {each.name}.{name}" for each in classes for name in each.absent]
    assert absent == []


def test_the_app_only_puts_parts_together() -> None:
    text = APP.read_text()
    imports = [
        node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    assert len(text.splitlines()) <= MOST_APP_LINES
    assert len(imports) <= MOST_APP_IMPORTS
