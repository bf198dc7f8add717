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
