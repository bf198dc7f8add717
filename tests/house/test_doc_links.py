"""Links between pages lead somewhere, and pages are drawn as they are meant."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from tests.support.cases import for_each

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


@for_each("page", PAGES)
def test_links_of_a_page_exist(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)", page.read_text())
    local = [link for link in links if "://" not in link]
    assert [link for link in local if not (page.parent / link).exists()] == []


@for_each("page", PAGES)
def test_code_blocks_of_a_page_are_closed(page: Path) -> None:
    """An open one turns all that follows inside out, and hides its commands from the tests."""
    is_open = False
    for language in re.findall(r"^```(.*)$", page.read_text(), re.MULTILINE):
        assert not (is_open and language), f"a block begins within another: {language}"
        is_open = not is_open
    assert not is_open


HALVES = ("hub", "rune_study", "rune_tui", "tests", "benchmarks")
FILES = [f"/{path.relative_to(ROOT)}" for half in HALVES for path in (ROOT / half).rglob("*.py")]
OF_THE_HOUSE = [
    *sorted((ROOT / "docs" / "decisions").glob("*.md")),
    *(ROOT / "docs" / f"{name}.md" for name in ("architecture", "glossary", "safety", "security")),
    ROOT / "CONTRIBUTING.md",
]


@for_each("page", OF_THE_HOUSE)
def test_files_that_a_page_names_exist(page: Path) -> None:
    """A table that names a test that is gone promises what nobody shows."""
    named = set(re.findall(r"`([\w/]+\.py)`", page.read_text()))
    assert [each for each in named if not any(path.endswith(f"/{each}") for path in FILES)] == []
    rooms = set(re.findall(rf"`((?:{'|'.join(HALVES)})/[\w/]*/)`", page.read_text()))
    assert [room for room in rooms if not (ROOT / room).is_dir()] == []


@pytest.mark.parametrize("name", ["architecture", "glossary"])
def test_classes_that_a_page_names_exist(name: str) -> None:
    text = (ROOT / "docs" / f"{name}.md").read_text()
    code = " ".join(re.findall(r"`([^`\n]+)`", text))
    named = set(re.findall(r"\b([A-Z][a-z]+(?:[A-Z][a-z]+)+)\b", code))
    classes = {
        each
        for path in FILES
        if path.startswith(("/hub", "/rune_tui"))
        for each in re.findall(r"^class (\w+)", (ROOT / path[1:]).read_text(), re.MULTILINE)
    }
    assert named
    assert named <= classes


def test_no_class_name_stands_for_two_things() -> None:
    """One name, one thing, in each half."""
    for half in ("hub", "rune_study", "rune_tui"):
        names = [
            each
            for path in (ROOT / half).rglob("*.py")
            for each in re.findall(r"^class (\w+)", path.read_text(), re.MULTILINE)
        ]
        assert {name for name, count in Counter(names).items() if count > 1} == set()
