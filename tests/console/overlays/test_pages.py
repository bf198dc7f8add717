"""The help and the page of messages: what they say, how they are scrolled, searched and drawn."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from rune_tui.dispatch import Dispatch
from rune_tui.layout.rules import Section
from rune_tui.model.console_state import ConsoleState, Notice
from rune_tui.model.effects import Effect, StateEffect
from rune_tui.model.page import Page
from rune_tui.model.state_changes import changed
from rune_tui.model.theme import LIGHT
from rune_tui.overlays.page_layer import PageLayer
from rune_tui.raster.canvas import Canvas
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from tests.console.dispatching import down, stops
from tests.console.view_scenes import STATE, robot, words
from tests.support.autopilot import UNSAFE, piloted, rover
from tests.support.cases import for_each

LAYOUTS = Path(__file__).parents[3] / "layouts"
SEARCH = open_layout(LAYOUTS / "search.xml")
TEAM = open_layout(LAYOUTS / "land-sea-air.xml")
TWO = open_layout(LAYOUTS / "two-robots.xml")
HELPED = ConsoleState(now=0.0, help=True)


def text_of(canvas: Canvas) -> list[str]:
    rows = ("".join(chr(glyph or 32) for glyph in row) for row in canvas.glyphs.tolist())
    return [row.rstrip() for row in rows]


def page(state: ConsoleState, columns: int = 80, rows: int = 24, layout=SEARCH) -> list[str]:
    layer = PageLayer(layout)
    layer.refresh(columns, 0, rows, 1, state)
    return text_of(layer.layers[0].canvas)


def whole(state: ConsoleState, columns: int = 80, layout=SEARCH) -> list[str]:
    return page(state, columns, 200, layout)[2:]


def test_the_help_begins_with_the_stop_and_how_to_drive():
    rows = page(HELPED)
    assert rows[0].startswith(" HELP")
    assert rows[2:8] == [
        " Stop and drive",
        " space, pad B               Stop",
        " W, up, pad left stick up   Drive forward",
        " S, down, pad left stick    Drive backward",
        " down",
        " A, left, pad left stick    Turn left",
    ]


def test_a_key_that_does_the_same_to_all_robots_has_one_row_and_no_word_is_missing():
    rows = [" ".join(row.split()) for row in whole(HELPED, layout=TEAM)]
    assert "0, pad X Stop: all robots" in rows
    assert rows[rows.index("Stop and drive: blimp") + 1] == 'Shift+2 (@ ") Stop'
    assert "V Camera: the next one" in rows


def test_the_help_has_its_sections_in_order_and_the_keys_of_the_console():
    rows = whole(HELPED)
    headings = [row.strip() for row in rows if row.strip() in {each.value for each in Section}]
    assert headings == [each.value for each in Section]
    text = "\n".join(rows)
    for said in ("ctrl+p", "ctrl+e", "f1", "Mark a victim there", "Explore by itself"):
        assert said in text
    for raw in ("order explore", "theme next", "factor 1.25", "linear 0.5"):
        assert raw not in text


def test_with_several_robots_a_section_has_a_heading_for_each():
    text = "\n".join(whole(HELPED, layout=TWO))
    assert "Stop and drive: left" in text
    assert "Stop and drive: right" in text


@for_each("columns", [20, 30, 40, 60, 80, 109, 110, 160, 300])
def test_the_hint_is_never_cut_and_says_how_to_close(columns: int):
    hint = page(HELPED, columns, 10)[1]
    assert "close" in hint
    assert "…" not in hint


def test_the_help_ends_with_the_parameters_that_make_a_vehicle_unsafe():
    known = piloted(rover(unsafe=(UNSAFE,)))
    state = dataclasses.replace(HELPED, robots={known.name: known})
    *_, heading, first = (row.strip() for row in whole(state) if row)
    assert heading == f"Unsafe parameters: {state.title(known.name)}"
    assert first.split(maxsplit=4) == ["FS_GCS_ENABLE", "0,", "not", "1", UNSAFE.why]
    found = dataclasses.replace(state, page=Page(search="FS_GCS"))
    assert [row for row in whole(found) if row] == [f" {heading}", f" {first}"]
    safe = piloted(rover())
    assert "Unsafe" not in "".join(whole(dataclasses.replace(state, robots={safe.name: safe})))


def test_at_110_columns_the_help_stands_in_two_blocks():
    rows = page(HELPED, 110, 20)
    assert "Look" in rows[2 + rows[2:].index(next(r for r in rows[2:] if "Look" in r))]
    assert len([row for row in rows if row.count("  ") >= 2]) > 5


@for_each("size", [(1, 1), (8, 2), (20, 4), (80, 24), (200, 60)])
def test_every_line_can_be_reached_at_every_size(size: tuple[int, int]):
    columns, rows = size
    layer = PageLayer(SEARCH)
    state = dataclasses.replace(HELPED, page=Page(top=10**6))
    end = layer.within(state.page, columns, rows, state)
    assert layer.within(end, columns, rows, state) == end
    layer.refresh(columns, 0, rows, 1, dataclasses.replace(HELPED, page=end))
    shown = text_of(layer.layers[0].canvas)
    if columns >= 80:
        assert any("Back to the shell" in row or "Quit" in row for row in shown)


def test_no_column_ends_with_a_heading():
    headings = {section.value for section in Section}
    for rows in range(8, 60):
        for columns in (80, 120):
            last = page(HELPED, columns, rows)[rows - 2]
            halves = (last,) if columns < 110 else (last[: columns // 2], last[columns // 2 :])
            assert headings.isdisjoint(half.strip() for half in halves), (columns, rows)


def test_a_search_leaves_what_has_it_with_its_headings():
    found = dataclasses.replace(HELPED, page=Page(search="VICTIM", typing=True))
    assert [row for row in page(found)[2:] if row] == [
        " Mark",
        " left click in camera       Mark a victim there",
    ]
    assert "search: VICTIM_" in page(found)[1]
    assert "nothing" in page(dataclasses.replace(HELPED, page=Page(search="xyzzy")))[0]


def said(count: int) -> ConsoleState:
    notices = tuple(
        Notice(text=f"event {number}", when=float(number), clock=f"12:00:{number:02d}")
        for number in range(count)
    )
    return ConsoleState(now=0.0, log=True, notices=notices)


def test_the_page_of_messages_has_all_of_them_the_newest_first():
    rows = page(said(60))
    assert rows[0].split() == ["MESSAGES", "1-21", "of", "60"]
    assert rows[2].split() == ["12:00:59", "event", "59"]
    end = dataclasses.replace(said(60), page=Page(top=39))
    assert page(end)[-2].split() == ["12:00:00", "event", "0"]
    found = dataclasses.replace(said(60), page=Page(search="event 17"))
    assert [row.split() for row in page(found)[2:] if row] == [["12:00:17", "event", "17"]]


def test_a_long_message_is_told_whole():
    path = "/home/jane/" + "documents/" * 12 + "run.mcap"
    told = Notice(text=f"recorded in {path}", when=0.0, clock="12:00:00", alarm=True)
    rows = page(dataclasses.replace(said(0), notices=(told,)), 40)
    assert "".join(row[9:].strip() for row in rows[2:]).replace("recordedin", "").endswith("mcap")
    assert rows[2].startswith(" 12:00:00 !")


def test_a_page_is_drawn_when_its_look_changes_and_goes():
    layer = PageLayer(SEARCH)
    assert not layer.refresh(80, 0, 24, 1, ConsoleState(now=0.0))
    assert layer.refresh(80, 0, 24, 1, HELPED)
    assert not layer.refresh(80, 0, 24, 1, HELPED)
    assert layer.refresh(80, 1, 23, 1, HELPED)
    assert layer.refresh(80, 1, 23, 1, dataclasses.replace(HELPED, theme=LIGHT))
    assert layer.refresh(80, 1, 23, 1, ConsoleState(now=0.0))
    assert layer.layers == ()


def apply(state: ConsoleState, effects: tuple[Effect, ...]) -> ConsoleState:
    for effect in effects:
        if isinstance(effect, StateEffect):
            state = changed(state, effect)
    return state


def press(state: ConsoleState, *keys: str, layout=SEARCH) -> ConsoleState:
    dispatch = Dispatch(layout)
    for key in keys:
        state = apply(state, dispatch.handle(down(key), state))
    return state


def test_f1_and_the_question_mark_open_and_close_the_help_and_ctrl_e_the_messages():
    start = ConsoleState(now=0.0)
    for key in ("f1", "?"):
        assert press(start, key).help
        assert not press(start, key, key).paged
        assert not press(start, key, "escape").paged
    assert press(start, "ctrl+e").log
    both = press(start, "ctrl+e", "f1")
    assert (both.help, both.log) == (True, False)


def test_while_a_search_is_typed_letters_are_letters_and_the_stop_still_stops():
    searched = press(HELPED, "/", "q", "?", "w", "e")
    assert searched.help
    assert searched.page == Page(search="q?we", typing=True)
    effects = Dispatch(SEARCH).handle(down("space"), searched)
    assert stops(effects) == ["robot"]
    assert apply(searched, effects).page == searched.page
    assert not press(searched, "escape", "escape").paged


def test_keys_and_the_wheel_scroll():
    assert press(HELPED, "pagedown", "down", "up").page.top == 12
    wheel = dataclasses.replace(down("mouse wheel"), value=-1.0)
    (effect,) = Dispatch(SEARCH).handle(wheel, HELPED)
    assert apply(HELPED, (effect,)).page.top == 3


def test_under_a_page_of_the_view_what_is_vital_and_the_pictures_go_on():
    view = View(SEARCH)
    view.resize(80, 24)
    state = dataclasses.replace(STATE, robots={"robot": robot("robot")})
    usual = view.picture_needs(state)
    helped = dataclasses.replace(state, help=True)
    cells = view.render(helped)
    assert cells is not None
    text = words(cells)
    assert "MOVING" in text.splitlines()[-1]
    assert "Stop and drive" in text
    assert view.picture_needs(helped) == usual != {}
    scrolled = view.within_page(dataclasses.replace(helped, page=Page(top=10**6)))
    assert 0 < scrolled.page.top < 100


def at_size(columns: int, rows: int, **changes) -> tuple[list[str], ConsoleState]:
    view = View(open_layout(LAYOUTS / "minimal.xml"))
    view.resize(columns, rows)
    state = dataclasses.replace(STATE, robots={"robot": robot("robot")}, **changes)
    cells = view.render(state)
    assert cells is not None
    return words(cells).splitlines(), state


@pytest.mark.parametrize("size", [(60, 12), (80, 24), (120, 40)])
def test_what_happens_meanwhile_covers_no_hint_of_a_page(size: tuple[int, int]):
    told = (Notice(text="victim 3 is marked", when=STATE.now - 1.0),)
    rows, _ = at_size(*size, help=True, notices=told)
    assert "escape: close" in rows[1]
    plain, _ = at_size(*size, help=True)
    changes = [pair for pair in zip(rows, plain, strict=True) if pair[0] != pair[1]]
    ((row, before),) = changes
    assert "victim 3 is marked" in row
    assert not before.strip(), "a row of its own"
    rows, _ = at_size(*size, log=True, notices=told)
    assert sum("victim 3 is marked" in row for row in rows) == 1


def test_the_question_about_the_end_stands_on_a_plate_over_the_whole_width():
    rows, _ = at_size(80, 24, leaving=("the recording ends",))
    assert "QUIT? Then the recording ends." in "".join(rows[:4])
    assert not any(row.strip() for row in rows[:4] if "QUIT" not in row and "stay" not in row)
