"""What stands in the list of actions, and in which order."""

from __future__ import annotations

from pathlib import Path

import pytest

from rune_tui.layout.actions import actions_of
from rune_tui.startup.opening import open_layout
from rune_tui.ui.palette import choices, match

LAYOUTS = sorted((Path(__file__).parents[3] / "layouts").glob("*.xml"))


def listed(path: Path) -> list[str]:
    """Titles of the list before anything is typed."""
    return list(choices(actions_of(open_layout(path))))


@pytest.mark.parametrize("path", LAYOUTS, ids=lambda path: path.stem)
def test_a_careless_enter_neither_ends_the_console_nor_commands_a_robot(path: Path):
    titles = listed(path)
    if "Quit" in titles and len(titles) > 1:
        assert titles[-1] == "Quit"
    assert len(titles) == 1 or titles[0] == "This help" or titles[0].endswith("Stop")


def found(query: str) -> list[str]:
    """What the list of `search` has for some words, the best first."""
    listed = choices(actions_of(open_layout(LAYOUTS[0].with_name("search.xml"))))
    scores = {
        title: match(query, title, f"{action.help} {action.also}")
        for title, action in listed.items()
    }
    return sorted((title for title, score in scores.items() if score), key=lambda t: -scores[t])


@pytest.mark.parametrize(
    ("query", "first"),
    [
        ("st", "Stop"),
        ("mark", "Take back your newest mark"),
        ("sp li up", "Speed limit up"),
        ("pan", "Look left"),
        ("mode", "Night mode on or off"),
        ("photo", "Keep a picture of the screen"),
        ("screenshot", "Keep a picture of the screen"),
        ("snap", "Keep a picture of the screen"),
        ("autonomy", "Explore by itself"),
        ("undo", "Take back your newest mark"),
    ],
)
def test_words_of_the_title_come_before_words_of_the_help(query: str, first: str):
    titles = found(query)
    assert titles[0] == first, titles


def test_letters_of_other_words_are_no_match():
    assert "Night mode on or off" not in found("go")
    assert found("") == []


def test_titles_are_plain_words_with_the_robot_where_there_are_several():
    assert "Explore by itself" in listed(LAYOUTS[0].with_name("search.xml"))
    assert "left: Stop" in listed(LAYOUTS[0].with_name("two-robots.xml"))
