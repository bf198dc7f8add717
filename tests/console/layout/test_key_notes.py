"""What is said of keys that not every terminal tells."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rune_tui.layout.key_notes import key_notes, unreported_keys
from rune_tui.layout.spec import LayoutSpec
from rune_tui.startup.opening import open_layout

LAYOUT = """<rune>
  <robot name="magellan"><capability name="NAV_MOVE"/></robot>
  <view xsize="60" ysize="40">
    <widget handler="widgetQuit"><event key="q"/></widget>
    <viewport name="all" robot="magellan" xpos="0" ypos="0" xsize="60" ysize="40">
      <widget handler="widgetSetSpeed">{events}</widget>
      <widget handler="widgetStop"><event key="5"/></widget>
    </viewport>
  </view>
</rune>
"""
ONLY = "only terminals with the kitty keyboard protocol tell it, others report"


@pytest.fixture
def layout(tmp_path: Path) -> Callable[[str], LayoutSpec]:
    """A layout whose speed is set by such keys: name, and value if it is not 1."""

    def opened(keys: str) -> LayoutSpec:
        events = [f'<event key="{key}" control="translate"/>' for key in keys.split()]
        back = '<event key="s" control="translate" value="-1"/>'
        path = tmp_path / "layout.xml"
        path.write_text(LAYOUT.format(events="".join((*events, back))))
        return open_layout(path)

    return opened


@pytest.mark.parametrize(
    ("keys", "notes"),
    [
        ("w", []),
        ("kp_8", [f'key kp_8: {ONLY} it as 8: bind "8" as well']),
        ("kp_8 w", [f'key kp_8: {ONLY} it as 8: bind "8" as well']),
        ("kp_8 8", []),
        ("kp_5", [f"key kp_5: {ONLY} it as 5, which means something else here"]),
        ("left_shift", [f"key left_shift: {ONLY} nothing: bind another key as well"]),
        ("left_shift w", []),
    ],
)
def test_a_note_says_what_to_bind_unless_that_is_bound(
    layout: Callable[[str], LayoutSpec], keys: str, notes: list[str]
) -> None:
    assert list(key_notes(layout(keys))) == notes


def test_a_key_that_means_something_else_stands_for_no_other(
    layout: Callable[[str], LayoutSpec], tmp_path: Path
) -> None:
    layout("kp_8 8")
    path = tmp_path / "layout.xml"
    path.write_text(path.read_text().replace('"8" control="translate"', '"8" control="rotate"'))
    assert "something else" in key_notes(open_layout(path))[0]


@pytest.mark.parametrize(
    ("keys", "named"),
    [
        ("kp_8", "kp_8"),
        ("kp_8 kp_2 kp_4", "kp_8, kp_2, kp_4"),
        ("kp_8 kp_2 kp_4 kp_6 left_alt", "kp_8, kp_2, kp_4 and 2 more"),
    ],
)
def test_one_sentence_names_the_first_of_the_keys(
    layout: Callable[[str], LayoutSpec], keys: str, named: str
) -> None:
    said = f"this terminal does not tell {named}: rune check says what to bind as well"
    assert unreported_keys(layout(keys)) == said


def test_of_keys_that_all_terminals_tell_nothing_is_said(
    layout: Callable[[str], LayoutSpec],
) -> None:
    assert unreported_keys(layout("w kp_8 8 kp_add +")) == ""


def test_a_button_of_the_mouse_means_the_viewport_that_is_clicked(tmp_path: Path) -> None:
    path = tmp_path / "layout.xml"
    seen = '<visualizer function="visualizeLabel" text="x"/>'
    other = (
        '<viewport name="stop" robot="magellan" xpos="0" ypos="0" xsize="9" ysize="9">'
        f"{seen}"
        '<widget handler="widgetStop"><event mouse="left"/></widget></viewport></view>'
    )
    text = LAYOUT.format(events='<event mouse="left" control="translate"/>')
    text = text.replace('ysize="40">\n      <', 'ysize="40">' + seen + "<")
    path.write_text(text.replace("</view>", other))
    assert key_notes(open_layout(path)) == ()
    path.write_text(text.replace('<event key="5"/>', '<event mouse="left"/>'))
    assert "mouse left wakes" in key_notes(open_layout(path))[0]
