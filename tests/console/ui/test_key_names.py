"""Keys of a terminal with Shift and Alt, by their names in layouts."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import pytest
from textual import events

from rune_tui.dispatch import Dispatch
from rune_tui.layout.names import ALT_KEYS, SHIFT_KEYS, is_key
from rune_tui.startup.opening import open_layout
from rune_tui.ui.current_layout import CurrentLayout
from rune_tui.ui.key_names import KeyNames
from rune_tui.ui.sturdy_driver import SturdyParser
from tests.support.cases import for_each
from tests.support.waiting import until


class Open:
    """What names need of the open layout."""

    def __init__(self, dispatch: Dispatch) -> None:
        self.dispatch = dispatch


@pytest.fixture
def names(tmp_path: Path) -> KeyNames:
    layout = tmp_path / "keys.xml"
    bound = ("shift+a", "shift+up", "shift+f5", "alt+e", "alt+down", "alt+f4", "w", "a")
    events = "".join(f'<event key="{key}"/>' for key in bound)
    layout.write_text(
        f"""<rune><robot name="r" hub="tcp://127.0.0.1:1381"/>
        <view xsize="80" ysize="48"><widget handler="widgetHelp">{events}</widget>
        <viewport name="keys" xpos="0" ypos="0" xsize="80" ysize="2">
        <visualizer function="visualizeLabel" text="keys"/></viewport></view></rune>"""
    )
    return KeyNames(cast("CurrentLayout", Open(Dispatch(open_layout(layout)))))


@for_each(
    ("sequence", "name", "fine"),
    [
        ("A", "shift+a", False),
        ("W", "w", True),
        ("\x1b[1;2A", "shift+up", False),
        ("\x1b[1;2B", "down", True),
        ("\x1b[15;2~", "shift+f5", False),
        ("\x1be", "alt+e", False),
        ("\x1b[1;3B", "alt+down", False),
        ("\x1b[1;3S", "alt+f4", False),
        ("\x1b[101;3u", "alt+e", False),
        ("\x1b[97;2;65u", "shift+a", False),
    ],
)
def test_keys_with_shift_and_alt_have_names(
    names: KeyNames, sequence: str, name: str, *, fine: bool
):
    parser = SturdyParser()
    keys = [*parser.feed(sequence)]
    until(lambda: keys.extend(parser.tick()) or keys, 5.0)
    (key,) = keys
    assert isinstance(key, events.Key)
    assert names.named(key.key, key.character) == (name, fine)


def test_every_such_name_may_stand_in_a_layout():
    assert all(map(is_key, (*SHIFT_KEYS, *ALT_KEYS)))
    assert not any(map(is_key, ("shift+1", "alt+W", "shift+space", "alt+[", "alt+b", "super+w")))
