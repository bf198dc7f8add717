"""Keys answer items, and nothing is answered before a key."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from rune_study.questionnaires.entries import WIDTH, entry_of, wrapped
from rune_study.questionnaires.items import (
    Agreement,
    Answer,
    Bearing,
    Choice,
    Item,
    NumberItem,
    Pair,
    Scale,
    TextItem,
)

SCALE = Scale(id="a", text="?", low="Very Low", high="Very High", step=5.0)
ITEMS: list[Item] = [
    SCALE,
    Scale(id="b", text="?", low="Strongly disagree", high="Strongly agree", marks=5, least=1.0),
    Choice(id="c", text="?", options=("one", "two", "three")),
    NumberItem(id="d", text="?", least=16, most=110, unit="years", whole=True),
    TextItem(id="e", text="?", longest=200),
    Agreement(id="f", text="?"),
    Bearing(id="g", text="?"),
    Pair(id="h", text="?", first=("a", "Mental Demand"), second=("b", "Effort")),
]
KEYS = ["left", "right", "up", "down", "home", "end", "enter", "backspace", *"0123456789,.-ex"]


def typed(item: Item, *keys: str) -> Answer | None:
    entry = entry_of(item)
    answers = [entry.press(key, key if len(key) == 1 else None) for key in keys]
    assert answers[:-1] == [None] * (len(keys) - 1)
    return answers[-1]


def test_the_first_arrow_sets_the_middle_mark_and_further_ones_move_it() -> None:
    assert typed(SCALE, "enter") is None
    assert typed(SCALE, "right", "enter") == 50
    assert typed(SCALE, "left", "left", "enter") == 45
    assert typed(SCALE, "end", "right", "enter") == 100


def test_few_marks_have_numbers() -> None:
    assert typed(ITEMS[1], "4", "enter") == 4
    assert typed(ITEMS[1], "9", "enter") is None


def test_a_number_out_of_its_bounds_is_said() -> None:
    entry = entry_of(ITEMS[3])
    for key in "7":
        entry.press(key, key)
    assert entry.press("enter", None) is None
    assert "Please give a whole number from 16 to 110." in entry.lines()
    assert typed(ITEMS[3], "3", "4", "enter") == 34
    assert typed(ITEMS[3], "3", ".", "5", "enter") is None


def test_a_dial_turns_to_the_left_by_positive_angles() -> None:
    assert typed(ITEMS[6], "left", "left", "enter") == 15
    assert typed(ITEMS[6], "left", "right", "enter") == 345


def test_a_pair_is_answered_by_one_arrow() -> None:
    assert typed(ITEMS[7], "left") == "a"
    assert typed(ITEMS[7], "right") == "b"


@given(number=st.integers(0, len(ITEMS) - 1), keys=st.lists(st.sampled_from(KEYS), max_size=30))
def test_any_keys_give_only_answers_that_fit_and_lines_that_fit(
    number: int, keys: list[str]
) -> None:
    item = ITEMS[number]
    entry = entry_of(item)
    for key in keys:
        answer = entry.press(key, key if len(key) == 1 else None)
        assert answer is None or item.accepts(answer)
        assert all(len(line) <= WIDTH for line in entry.lines())
        if answer is not None:
            entry = entry_of(item)


@given(st.text(max_size=300))
def test_questions_and_typed_words_fit_into_their_columns(words: str) -> None:
    entry = entry_of(TextItem(id="e", text="?", longest=300))
    for character in words:
        entry.press(character, character)
    for line in [*wrapped(words), *entry.lines()]:
        assert cell_len(line) <= WIDTH


def test_wide_labels_stay_at_the_ends_of_their_row() -> None:
    low, high = "まったくない", "とても"
    row, words, *_ = entry_of(Scale(id="a", text="?", low=low, high=high)).lines()
    assert cell_len(words) == cell_len(row)
    (line,) = entry_of(Pair(id="p", text="?", first=("a", low), second=("b", high))).lines()
    assert cell_len(line) == WIDTH
