"""Tests use what the code offers to everybody, so that a part can change inside without them."""

from __future__ import annotations

import functools
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
EXCEPTED = {
    "tests/console/controls/finger_model.py",  # it compares all that a keyboard's rules remember
    "tests/console/ui/test_textual_inside.py",  # it says what of Textual's inside the console uses
}
_PRIVATE = r"(_(?!_)\w+)"
DEFINED = re.compile(
    rf"\b(?:def|class) {_PRIVATE}"
    rf"|\bself\.{_PRIVATE}(?:, self\.{_PRIVATE})* ?[:=]"
    rf"|^{_PRIVATE} ?[:=]",
    re.MULTILINE,
)
USED = re.compile(
    rf"(?<!\bself)(?<!\bcls)\.{_PRIVATE}"
    rf"|setattr\([^()]*\"(?:[\w.]+\.)?{_PRIVATE}\""
    rf"|^from [\w.]+ import (?:\([^()]*?|[^(\n]*?)\b{_PRIVATE}",
    re.MULTILINE,
)


@functools.cache
def _names(pattern: re.Pattern[str], *folders: str) -> tuple[tuple[str, str], ...]:
    """Files, and the private names in them that a pattern finds."""
    return tuple(
        (str(path.relative_to(ROOT)), name)
        for folder in folders
        for path in sorted((ROOT / folder).rglob("*.py"))
        for groups in pattern.findall(path.read_text())
        for name in groups
        if name
    )


def test_tests_use_no_private_names_of_other_objects() -> None:
    ours = {name for _, name in _names(DEFINED, "hub", "rune_study", "rune_tui", "tests")}
    used = [each for each in _names(USED, "tests") if each[0] not in EXCEPTED]
    # What is private in a library is for that library to say.
    assert [f"{path}: {name}" for path, name in used if name in ours] == []


def test_the_exceptions_are_needed() -> None:
    assert {path for path, _ in _names(USED, "tests")} >= EXCEPTED
