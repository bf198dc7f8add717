"""What happened, made fit to be read in a few rows."""

from __future__ import annotations

from typing import Any

from rune_tui.model.console_state import Notice
from rune_tui.model.notices import KEPT_S, by_importance, merged, shortened
from tests.support.cases import for_each


def notice(text: str, when: float = 0.0, **how: Any) -> Notice:
    return Notice(text=text, when=when, clock=f"12:00:{int(when):02d}", **how)


def test_what_is_said_again_and_again_is_one_notice_with_the_time_of_the_last():
    said = (notice("refused", 1.0), notice("refused", 2.0), notice("refused", 3.0))
    (one,) = merged(said)
    assert (one.text, one.when) == ("refused (3 times)", 3.0)


def test_what_differs_or_comes_back_later_is_told_by_itself():
    said = (notice("a"), notice("a", robot="blimp"), notice("a", alarm=True), notice("a"))
    assert merged(said) == said
    assert merged(()) == ()


@for_each(
    ("text", "short"),
    [
        ("the screenshot is /home/jane/Pictures/Rune/r-1.png and .txt", "…/r-1.png"),
        ("recording into ~/Documents/Rune/run1.mcap", "…/run1.mcap"),
        ("0.5 m/s of 1/2", "0.5 m/s of 1/2"),
        ("answer yes/no", "answer yes/no"),
    ],
)
def test_of_a_path_the_name_of_the_file_is_left(text: str, short: str):
    assert short in shortened(text)
    assert "/Rune/" not in shortened(text)


def test_for_a_while_alarms_come_first_and_files_last():
    alarm = notice("refused", 1.0, alarm=True)
    said = [alarm, notice("marked", 2.0), notice("a file", 3.0, routine=True)]
    assert [each.text for each in by_importance(said, 4.0)] == ["refused", "marked", "a file"]
    later = 1.0 + KEPT_S + 0.1
    assert [each.text for each in by_importance(said, later)] == ["marked", "a file", "refused"]


def test_of_what_weighs_the_same_the_newest_comes_first():
    said = [notice(str(number), float(number)) for number in range(5)]
    assert [each.text for each in by_importance(said, 5.0)] == ["4", "3", "2", "1", "0"]
