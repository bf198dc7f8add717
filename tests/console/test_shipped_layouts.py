"""Shipped layouts keep what the design language says, at every size that it names."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from itertools import combinations
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.controls.events import ControlEvent
from rune_tui.dispatch import Dispatch
from rune_tui.layout.placing import Placed, arrangement_for, placed
from rune_tui.layout.spec import CHOSEN, LayoutSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import AskEffect, StateEffect
from rune_tui.model.state_changes import changed
from rune_tui.model.theme import LEAST_CONTRAST, THEMES, Theme
from rune_tui.startup.opening import BUILT_IN
from rune_tui.view import View
from tests.console.situations import NOW, ROOT, SITUATIONS, scene, shipped
from tests.console.test_contrast import least_contrast
from tests.support.cases import for_each
from tests.support.repetitions import repetitions

LAYOUTS = sorted((ROOT / "layouts").glob("*.xml"))
SIZES = [(80, 24), (120, 40), (160, 48), (200, 60)]
LINES = {"visualizeStatus", "visualizeLabel"}
"""Lines with a ground of their own, which part what is above them from what is below."""

each_layout = for_each("path", LAYOUTS)


def drawn_of(layout: LayoutSpec, name: str) -> str:
    (viewport,) = (each for each in layout.view.viewports if each.name == name)
    return viewport.visualizer.function if viewport.visualizer else ""


def panes(layout: LayoutSpec, size: tuple[int, int]) -> list[Placed]:
    arrangement = arrangement_for(layout.view.arrangements, *size)
    kinds: Mapping[str, Any] = BUILT_IN.visualizers
    free = {
        each.name
        for each in layout.view.viewports
        if each.visualizer and not kinds[each.visualizer.function].whole_cells
    }
    there = placed(arrangement, *size, free=free)
    return [each for each in there if each.spec.visible and drawn_of(layout, each.spec.viewport)]


def pairs(layout: LayoutSpec) -> Iterator[tuple[tuple[int, int], Placed, Placed]]:
    """Every two panes at each size."""
    for size in SIZES:
        for one, other in combinations(panes(layout, size), 2):
            yield size, one, other


@each_layout
def test_no_pane_touches_another(path: Path) -> None:
    layout = shipped(path.stem)
    titled = {each.name for each in layout.view.viewports if each.title}
    for size, one, other in pairs(layout):
        if one.spec.zpos != other.spec.zpos or one.area.meets(other.area):
            continue
        if not one.area.touches(other.area):
            continue
        upper, lower = sorted((one, other), key=lambda each: each.area.y)
        stacked = upper.area.y + upper.area.height <= lower.area.y
        parted = stacked and lower.spec.viewport in titled
        drawn = {drawn_of(layout, each.spec.viewport) for each in (one, other)}
        gauges = drawn <= {"visualizeSpeed", "visualizeBattery"} and stacked
        pair = f"{one.spec.viewport} and {other.spec.viewport} of {path.stem} at {size}"
        assert parted or gauges or drawn & LINES, pair


@each_layout
def test_lines_of_two_robots_do_not_run_into_each_other(path: Path) -> None:
    layout = shipped(path.stem)
    robots = {each.name: each.robot for each in layout.view.viewports}
    for size, one, other in pairs(layout):
        if robots[one.spec.viewport] == robots[other.spec.viewport]:
            continue
        if drawn_of(layout, one.spec.viewport) == drawn_of(layout, other.spec.viewport):
            assert not one.area.touches(other.area), size


@each_layout
def test_forty_columns_by_twelve_rows_show_video_control_and_stop(path: Path) -> None:
    layout = shipped(path.stem)
    there = panes(layout, (40, 12))
    cameras = [
        each for each in there if drawn_of(layout, each.spec.viewport) == "visualizeCameraImage"
    ]
    if path.stem != "xroboview":  # it watches without a camera
        seen = sum(each.area.width * each.area.height for each in cameras)
        assert seen >= 0.3 * 40 * 24
    cells = scene(layout, SITUATIONS["asked-for-control"], (40, 12))
    text = "\n".join("".join(chr(p or 32) for p in row) for row in cells.glyphs.tolist())
    assert "bob ASKS FOR CONTROL" in text
    stops = [w for w in all_widgets(layout) if w.handler == "widgetStop"]
    if stops and any(drawn_of(layout, each.spec.viewport) == "visualizeLabel" for each in there):
        calm = scene(layout, SITUATIONS["driving"], (40, 12))
        text = "\n".join("".join(chr(p or 32) for p in row) for row in calm.glyphs.tolist())
        assert "STOP" in text


def all_widgets(layout: LayoutSpec) -> list:
    return [w for each in layout.view.viewports for w in each.widgets] + [*layout.view.widgets]


@pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)
@each_layout
def test_every_text_stands_out(path: Path, theme: Theme) -> None:
    layout = shipped(path.stem)
    for size in SIZES[:: repetitions(3, 1)]:
        cells = scene(layout, SITUATIONS["low-battery"], size, theme)
        for depth in ColourDepth:
            assert least_contrast(at_depth(cells, depth)) >= LEAST_CONTRAST - 0.01, (size, depth)


@each_layout
def test_what_is_behind_everything_is_the_themes(path: Path) -> None:
    layout = shipped(path.stem)
    assert layout.view.background is None
    light = scene(layout, SITUATIONS["lost-link"], (160, 48), THEMES["light"])
    dark = scene(layout, SITUATIONS["lost-link"], (160, 48))
    assert np.mean(light.pixels[..., :3]) > np.mean(dark.pixels[..., :3])


COMMON = {
    "widgetReleaseControl": "c",
    "widgetGrantControl": "p",
    "widgetDenyControl": "b",
    "widgetMission": "m",
    "widgetUndoMark": "u",
    "widgetExportMarks": "x",
    "widgetToggleNightMode": "n",
    "widgetQuit": "q",
}
"""The console's own keys for help, messages and the palette are in every layout anyway."""
SLOWS = {"]", "[", "1", "2", "3", "4"}
TEAM = {"land-sea-air"}
"""Layouts with keys for the chosen robot: there digits choose robots, and n is the next alarm."""


@each_layout
def test_the_keys_that_an_operator_expects_are_in_every_layout(path: Path) -> None:
    layout = shipped(path.stem)
    of_team = path.stem in TEAM
    bound = {(w.handler, event.name) for w in all_widgets(layout) for event in w.events}
    assert (COMMON | ({"widgetToggleNightMode": "z"} if of_team else {})).items() <= bound
    assert not any(name in {"ctrl+e", "ctrl+p"} for _, name in bound)
    slows = SLOWS - set("1234") if of_team else SLOWS
    for robot in layout.robots:
        own = {
            (widget.handler, event.name)
            for viewport in layout.view.viewports
            if viewport.robot == (CHOSEN if of_team else robot.name)
            for widget in viewport.widgets
            for event in widget.events
        }
        assert ("widgetStop", "space") in own
        assert {key for handler, key in own if handler == "widgetSpeedLimit"} >= slows
        assert any(handler == "widgetSetSpeed" for handler, _ in own)
    assert any(handler == "widgetTakeControl" for handler, _ in bound)


@each_layout
def test_a_team_has_a_key_that_chooses_and_one_that_stops_each_robot(path: Path) -> None:
    layout = shipped(path.stem)
    if path.stem not in TEAM:
        return
    digits = iter("12345678")
    for robot in layout.robots:
        own = [
            (widget, event.name)
            for viewport in layout.view.viewports
            if viewport.robot == robot.name
            for widget in viewport.widgets
            for event in widget.events
        ]
        chosen = {
            key: widget.options.word("robot")
            for widget, key in own
            if widget.handler == "widgetChooseRobot"
        }
        assert chosen[next(digits)] == robot.name
        stops = {key for widget, key in own if widget.handler == "widgetStop"}
        assert "0" in stops
        assert len(stops) > 1


@pytest.mark.parametrize("name", ["two-robots", "land-sea-air"])
@pytest.mark.parametrize("size", [(40, 12), *SIZES], ids=lambda size: f"{size[0]}")
def test_the_title_of_the_chosen_robot_is_marked(name: str, size: tuple[int, int]) -> None:
    layout = shipped(name)
    view, dispatch = View(layout), Dispatch(layout)
    view.resize(*size)
    state = ConsoleState.at_start(layout, NOW, "ada")
    robots = {each.name: SITUATIONS["driving"].robot(each.name) for each in layout.robots}
    state = dataclasses.replace(state, robots=robots)
    for role in [*robots, next(iter(robots))]:
        cells = view.render(state)
        assert cells is not None
        shown = "".join(chr(point or 32) for point in cells.glyphs.flat)
        assert f"▶ {role}" in shown
        assert not any(f"▶ {other}" in shown for other in robots if other != role)
        (question,) = [
            effect
            for effect in dispatch.handle(ControlEvent(name="m", pressed=True), state)
            if isinstance(effect, AskEffect)
        ]
        assert question.robot == role
        for effect in dispatch.handle(ControlEvent(name="tab", pressed=True), state):
            state = changed(state, cast("StateEffect", effect))


@pytest.mark.parametrize("name", ["demo", "search", "land-sea-air"])
def test_f12_writes_the_screen_into_files(name: str) -> None:
    keys = {
        event.name: widget.handler
        for widget in shipped(name).view.widgets
        for event in widget.events
    }
    assert keys["f12"] == "widgetScreenshot"
