"""Every text of every visualizer can be read, in every theme and with every number of colours."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from rune_tui.compositor.cells import Cells
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.contrast import contrast, luminance, make_legible
from rune_tui.compositor.depth import ColourDepth
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Picture, RobotState
from rune_tui.model.theme import LEAST_CONTRAST, THEMES, Theme
from rune_tui.view import View
from rune_tui.visualizers.registry import VISUALIZERS
from tests.console.situations import NOW, SITUATIONS
from tests.console.states import layout_of
from tests.console.view_scenes import view, viewport

COLUMNS, ROWS = 60, 18
NOISE = np.random.default_rng(7).integers(0, 256, (2 * ROWS, COLUMNS, 3)).astype(np.uint8)


def least_contrast(cells: Cells) -> float:
    """Of all that is written, with the mean of the two pixels behind it."""
    shades = (cells.glyphs >= 0x2591) & (cells.glyphs <= 0x2593)
    row, column = np.nonzero((cells.glyphs > 32) & ~shades)
    if not len(row):
        return 21.0
    upper, lower = (cells.pixels[2 * row + half, column].astype(int) for half in (0, 1))
    ground = ((upper + lower) // 2).astype(np.uint8)
    return float(contrast(luminance(ground), luminance(cells.ink[row, column])).min())


def robots() -> list[RobotState]:
    """Some in whose state there is something to say, before a camera that sees noise."""
    names = ("near-wall", "lost-link", "asked-for-control", "low-battery")
    met = [SITUATIONS[name].robot("magellan") for name in names]
    return [
        each.with_(
            picture=dataclasses.replace(
                each.picture, value=Picture(pixels=NOISE, camera=each.picture.value.camera)
            )
        )
        for each in met
        if each.picture is not None
    ]


@pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)
def test_every_text_stands_out_before_any_picture(theme: Theme) -> None:
    seen = robots()
    for function in VISUALIZERS:
        spec = view(
            viewport("visualizeCameraImage", (0, 0, COLUMNS, 2 * ROWS)),
            viewport(
                function,
                (0, 0, COLUMNS, 2 * ROWS),
                text="some words",
                zpos=1,
                transparency=96,
                name="front",
            ),
            xsize=COLUMNS,
            ysize=2 * ROWS,
        )
        screen = View(layout_of(spec))
        screen.resize(COLUMNS, ROWS)
        for robot in seen:
            state = ConsoleState(now=NOW, theme=theme, robots={"magellan": robot})
            cells = screen.render(state)
            assert cells is not None
            for depth in ColourDepth:
                case = f"{function} at {depth.name}"
                assert least_contrast(at_depth(cells, depth)) >= LEAST_CONTRAST - 0.01, case


@pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)
def test_the_colours_of_a_theme_stand_out_by_themselves(theme: Theme) -> None:
    inks = ("ink", "soft", "faint", "good", "warning", "alarm_ink")
    pairs = [(ink, ground) for ink in inks for ground in ("panel", "ground", "bar")]
    for ink, ground in (*pairs, ("on_alarm", "alarm")):
        colours = np.array([getattr(theme, ink), getattr(theme, ground)], np.uint8)
        first, second = luminance(colours, theme.tint)
        assert contrast(first, second) >= LEAST_CONTRAST, (ink, ground)


@pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)
def test_what_a_map_shows_can_be_told_apart(theme: Theme) -> None:
    def apart(first: str, second: str) -> float:
        pair = np.array([getattr(theme, first), getattr(theme, second)], np.uint8)
        return float(contrast(*luminance(pair, theme.tint)))

    assert apart("wall", "floor") >= 3.0
    assert apart("wall", "unknown") >= 3.0
    assert apart("floor", "unknown") >= 1.5
    assert apart("robot", "floor") >= 3.0


def test_text_that_stands_out_is_left_as_it_is() -> None:
    cells = letters([(10, 10, 10)], [(200, 180, 40)])
    before = cells.ink.copy()
    make_legible(cells)
    assert (cells.ink == before).all()


@pytest.mark.parametrize("tint", [(255, 255, 255), (255, 76, 52)])
def test_any_ink_on_any_ground_becomes_legible(tint: tuple[int, int, int]) -> None:
    cells = letters(*np.random.default_rng(1).integers(0, 256, (2, 500, 3)))
    make_legible(cells, tint)
    tinted = dataclasses.replace(
        cells,
        pixels=(cells.pixels * np.array((*tint, 255)) / 255).round().astype(np.uint8),
        ink=(cells.ink * np.array((*tint, 255)) / 255).round().astype(np.uint8),
    )
    assert least_contrast(tinted) >= LEAST_CONTRAST - 0.1


def letters(grounds: Any, inks: Any) -> Cells:
    """A row of letters, each of its ink on its ground, shapes (n, 3)."""
    count = len(grounds)
    cells = Cells(
        pixels=np.zeros((2, count, 4), np.uint8),
        glyphs=np.full((1, count), ord("A"), np.uint32),
        ink=np.zeros((1, count, 4), np.uint8),
    )
    cells.pixels[..., :3], cells.ink[..., :3] = grounds, inks
    return cells
