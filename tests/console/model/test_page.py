"""How keys turn and search a page over the view."""

from __future__ import annotations

from rune_tui.model.page import LONGEST_SEARCH, Page, scrolled, turned
from tests.support.cases import for_each

ROWS = 24


@for_each(
    ("key", "top"),
    [("down", 11), ("up", 9), ("pagedown", 22), ("pageup", 0), ("home", 0), ("w", 10)],
)
def test_keys_scroll_by_lines_and_by_half_the_terminal(key: str, top: int):
    assert turned(Page(top=10), key, ROWS).top == top


def test_the_end_is_farther_than_any_page():
    assert turned(Page(), "end", ROWS).top > 10_000
    assert scrolled(Page(top=2), -5).top == 0


def test_a_slash_begins_a_search_that_takes_every_letter():
    page = Page(top=7)
    for key in ("/", "q", "space", "?", "x", "backspace"):
        page = turned(page, key, ROWS)
    assert page == Page(search="q ?", typing=True)
    assert turned(page, "enter", ROWS) == Page(search="q ?")
    assert turned(page, "escape", ROWS) == Page()


def test_escape_first_shows_all_lines_again():
    assert turned(Page(search="map", top=3), "escape", ROWS) == Page()
    assert turned(Page(top=3), "escape", ROWS) == Page(top=3)


def test_what_is_searched_for_has_an_end():
    page = Page(typing=True)
    for _ in range(2 * LONGEST_SEARCH):
        page = turned(page, "a", ROWS)
    assert len(page.search) == LONGEST_SEARCH
    assert turned(page, "joystick pad b", ROWS) == page
