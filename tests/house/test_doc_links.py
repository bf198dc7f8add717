"""Links between pages lead somewhere, and pages are drawn as they are meant."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_of_a_page_exist(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)", page.read_text())
    local = [link for link in links if "://" not in link]
    assert [link for link in local if not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_code_blocks_of_a_page_are_closed(page: Path) -> None:
    """An open one turns all that follows inside out, and hides its commands from the tests."""
    is_open = False
    for language in re.findall(r"^```(.*)$", page.read_text(), re.MULTILINE):
        assert not (is_open and language), f"a block begins within another: {language}"
        is_open = not is_open
    assert not is_open


@pytest.mark.parametrize("name", ["safety", "security"])
def test_files_that_show_a_rule_exist(name: str) -> None:
    """A table that names a test that is gone promises what nobody shows."""
    named = set(re.findall(r"`([\w/]+\.py)`", (ROOT / "docs" / f"{name}.md").read_text()))
    there = [
        f"/{path.relative_to(ROOT)}"
        for folder in ("hub", "rune_tui", "tests", "benchmarks")
        for path in (ROOT / folder).rglob("*.py")
    ]
    assert len(named) > 10
    assert [each for each in named if not any(path.endswith(f"/{each}") for path in there)] == []
