"""No class grows beyond what one reads at once, and the console's app only puts parts together."""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DECISION = ROOT / "docs/decisions/0028-classes-have-at-most-300-lines.md"
APP = ROOT / "rune_tui/app.py"
MOST_LINES = 300
MOST_APP_LINES, MOST_APP_IMPORTS = 250, 25


def _classes() -> dict[str, int]:
    """Names of classes, and their length [lines]."""
    return {
        node.name: (node.end_lineno or 0) - node.lineno + 1
        for package in ("hub", "rune_tui")
        for path in (ROOT / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ClassDef)
    }


def test_classes_are_short_except_those_that_a_decision_names() -> None:
    excepted = set(re.findall(r"^\| `(\w+)` \|", DECISION.read_text(), re.MULTILINE))
    classes = _classes()
    long = {name for name, lines in classes.items() if lines > MOST_LINES}
    assert long <= excepted
    assert excepted <= long, "take classes that became short out of the decision"


def test_the_app_only_puts_parts_together() -> None:
    text = APP.read_text()
    imports = [
        node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    assert len(text.splitlines()) <= MOST_APP_LINES
    assert len(imports) <= MOST_APP_IMPORTS
