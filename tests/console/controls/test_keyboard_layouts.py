"""Keys of other keyboard layouts, as those of a US keyboard."""

from __future__ import annotations

from rune_tui.controls.keyboard_layouts import LAYOUTS, US_KEYS, language_of, us_key
from tests.support.cases import for_each


def test_every_layout_has_one_character_for_each_key():
    for layout in LAYOUTS:
        assert len(layout.characters) == len(US_KEYS), layout.language
        typed = layout.characters.replace(" ", "")
        assert len(set(typed)) == len(typed), layout.language


@for_each(
    ("typed", "language", "meant"),
    [
        ("цфыв", "ru", "wasd"),
        ("цфів", "uk", "wasd"),
        ("уьяа", "bg", "wasd"),
        ("ςασδ", "", "wasd"),
        ("שדגכ", "", "asdf"),
        ("&é\"'(-è_çà", "fr", "1234567890"),
        ("üöä", "de", "[;'"),
    ],
)
def test_a_certain_character_is_a_key_of_a_us_keyboard(typed: str, language: str, meant: str):
    assert "".join(us_key(each, language) for each in typed) == meant


@for_each(
    ("typed", "language"), [("цфывй", ""), ("цфывй", "en"), ("é", ""), ("zqw", "fr"), ("日", "ja")]
)
def test_what_is_not_certain_is_no_key(typed: str, language: str):
    assert not any(us_key(each, language) for each in typed)


def test_the_locale_for_characters_has_the_language():
    assert language_of({"LANG": "ru_RU.UTF-8"}) == "ru"
    assert language_of({"LANG": "ru_RU.UTF-8", "LC_CTYPE": "", "LC_ALL": "el_GR"}) == "el"
    assert language_of({"LANG": "C.UTF-8"}) == "c.utf-8"
    assert language_of({}) == ""
