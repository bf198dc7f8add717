"""The view places viewports, redraws what changed, and works on any terminal."""

from __future__ import annotations

import dataclasses
import itertools
import random
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.compositor.ansi import encoded_rows
from rune_tui.layout.placing import area_of
from rune_tui.layout.spec import CHOSEN
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, RobotState
from rune_tui.model.theme import THEMES, Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.urgency import Urgency
from rune_tui.view import MIN_COLUMNS, MIN_ROWS, View
from tests.console.states import layout_of, rendered, visualizer_spec
from tests.console.view_scenes import (
    CAMERA,
    EVERYTHING,
    NAVIGATION,
    STATE,
    known,
    robot,
    shown,
    two_panes,
    view,
    viewport,
    words,
)
from tests.support.repetitions import repetitions

DESIGN = (160, 96)


def test_every_terminal_size_shows_something_of_that_size() -> None:
    sizes = list(itertools.product(range(1, 61), range(1, 21)))
    for columns, rows in random.Random(1).sample(sizes, repetitions(90, len(sizes))):
        cells = shown(EVERYTHING, columns, rows)
        assert cells.pixels.shape == (2 * rows, columns, 4)
        assert cells.glyphs.shape == (rows, columns)
        assert cells.ink.shape == (rows, columns, 4)
        assert cells.glyphs.any()


def test_twenty_columns_by_five_rows_show_video_and_state() -> None:
    cells = shown(EVERYTHING, 20, 5)
    assert "MOVING" in words(cells).splitlines()[-1]
    assert (cells.pixels[:8, :, 0] == 200).mean() > 0.2


@pytest.mark.parametrize(("columns", "rows"), [(MIN_COLUMNS - 1, 20), (60, MIN_ROWS - 1), (9, 1)])
def test_below_a_usable_size_the_words_too_small_stand_alone(columns: int, rows: int) -> None:
    assert words(shown(EVERYTHING, columns, rows)).strip() == "too small"


def test_nothing_is_drawn_before_the_size_is_known() -> None:
    assert rendered(View(layout_of(EVERYTHING)), {"magellan": robot()}, STATE) is None


def test_nothing_new_gives_no_frame() -> None:
    for size in ((80, 24), (5, 2)):
        screen = View(layout_of(EVERYTHING))
        screen.resize(*size)
        robots = {"magellan": robot()}
        assert rendered(screen, robots, STATE) is not None
        assert rendered(screen, robots, STATE) is None
        later = ConsoleState(now=STATE.now + 0.05)
        assert rendered(screen, {"magellan": robot()}, later) is None
        screen.resize(*size)
        assert rendered(screen, robots, STATE) is not None


class _Counted:
    """Counts how often each visualizer draws, by the class that does."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.drawn: list[str] = []
        from rune_tui.visualizers.registry import VISUALIZERS

        for kind in VISUALIZERS.values():
            monkeypatch.setattr(kind, "draw", self._counting(kind))

    def _counting(self, kind: type[Any]) -> Any:
        original = kind.draw

        def draw(itself: Any, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
            self.drawn.append(kind.__name__)
            original(itself, canvas, robot, state)

        return draw


def test_only_the_viewport_whose_data_changed_is_drawn_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    counted = _Counted(monkeypatch)
    screen = View(layout_of(EVERYTHING))
    screen.resize(80, 24)
    before = rendered(screen, {"magellan": robot()}, STATE)
    assert len(counted.drawn) == 6
    counted.drawn.clear()
    after = rendered(screen, {"magellan": robot(shade=90, number=2)}, STATE)
    assert counted.drawn == ["CameraImage"]
    assert before is not None
    assert after is not None
    assert (after.pixels != before.pixels).any()
    assert (after.glyphs == before.glyphs).all()


def test_hidden_viewports_are_neither_drawn_nor_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    counted = _Counted(monkeypatch)
    hidden = view(
        viewport("visualizeCameraImage", (0, 0, 160, 96), visible=False),
        viewport("visualizeCameraImage", (0, 0, 160, 96), transparency=255, name="unseen"),
        viewport("visualizeStatus", (0, 0, 160, 2), visualizer=None),
    )
    screen = View(layout_of(hidden))
    screen.resize(80, 24)
    cells = rendered(screen, {"magellan": robot()}, STATE)
    assert counted.drawn == []
    assert cells is not None
    assert (cells.pixels[..., :3] == (1, 2, 3)).all()
    assert screen.picture_needs(dataclasses.replace(STATE, robots={"magellan": robot()})) == {}


def test_ageing_alone_gives_a_new_frame_at_each_step() -> None:
    screen = View(layout_of(view(viewport("visualizeCameraImage", (0, 0, 160, 96)))))
    screen.resize(80, 24)
    robots = {"magellan": robot()}
    frames = [rendered(screen, robots, ConsoleState(now=100.0 + 0.25 * i)) for i in range(12)]
    # Fresh, then dimmed after one second, then (3.0 s old, measured 0.1 s before) hatched.
    # From half a second on (0.35 s and 0.1 s) the banner counts its age.
    drawn = [i for i, frame in enumerate(frames) if frame is not None]
    assert drawn == [0, *range(2, 12)]
    assert rendered(screen, robots, ConsoleState(now=103.0)) is not None


def test_for_quadrants_the_camera_shows_more_and_all_else_stays() -> None:
    spec = view(
        viewport("visualizeCameraImage", (0, 0, 160, 96)),
        viewport("visualizePanData", (40, 10, 80, 8), zpos=1),
        viewport("visualizeStatus", (0, 88, 160, 8), zpos=1),
    )
    stripes = np.zeros((192, 256, 3), np.uint8)
    stripes[:, 1::4] = stripes[:, 2::4] = 250  # halves of cells, beside each other
    robots = {"magellan": robot(picture=known(Picture(pixels=stripes, camera=CAMERA)))}
    quadrants, halves = View(layout_of(spec), pixels_per_cell=(2, 2)), View(layout_of(spec))
    for screen in (quadrants, halves):
        screen.resize(160, 48)
    more, usual = rendered(quadrants, robots, STATE), rendered(halves, robots, STATE)
    assert more is not None
    assert usual is not None
    assert not halves.pictures
    ((picture, seen),) = ((each.picture, each.seen) for each in quadrants.pictures)
    assert (more.glyphs == usual.glyphs).all()
    assert (picture.pixels[:, 0::2] != picture.pixels[:, 1::2]).any(axis=2).all()
    video = (quadrants.urgencies == Urgency.VIDEO) & (more.glyphs == 0)
    assert seen.mean() > 0.5
    assert not seen[~video].any()
    assert (more.pixels == usual.pixels)[~video.repeat(2, axis=0)].all()
    state = dataclasses.replace(STATE, robots=robots)
    assert halves.picture_needs(state) == {"magellan": {"": PictureNeed(size=(128, 96))}}
    assert quadrants.picture_needs(state) == {"magellan": {"": PictureNeed(size=(256, 192))}}


@pytest.mark.parametrize("theme", THEMES.values(), ids=str)
def test_every_theme_shows_all_of_the_cameras_picture_in_quadrants(theme: Theme) -> None:
    spec = view(viewport("visualizeCameraImage", (0, 0, 160, 96)))
    pixels = np.random.default_rng(1).integers(0, 256, (192, 256, 3), np.uint8)
    robots = {"magellan": robot(picture=known(Picture(pixels=pixels, camera=CAMERA)))}
    screen = View(layout_of(spec), pixels_per_cell=(2, 2))
    screen.resize(160, 48)
    assert rendered(screen, robots, dataclasses.replace(STATE, theme=theme)) is not None
    ((picture, seen),) = ((each.picture, each.seen) for each in screen.pictures)
    assert 2 * seen.sum() == picture.means.shape[0] * picture.means.shape[1]


def test_a_view_that_cannot_be_made_shows_no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = view(viewport("visualizeCameraImage", (0, 0, 160, 96)))
    pixels = np.full((192, 256, 3), 99, np.uint8)
    robots = {"magellan": robot(picture=known(Picture(pixels=pixels, camera=CAMERA)))}
    screen = View(layout_of(spec), pixels_per_cell=(2, 2))
    screen.resize(160, 48)
    assert rendered(screen, robots, STATE) is not None
    assert screen.pictures
    monkeypatch.setattr("rune_tui.drawn_layers.make_legible", lambda *_: 1 / 0)
    screen.resize(160, 48)
    assert rendered(screen, robots, STATE) is not None
    assert not screen.pictures


def test_a_resize_between_drawing_and_composing_makes_the_next_picture_complete() -> None:
    screen = View(layout_of(view(viewport("visualizeStatus", (0, 0, 160, 96)))))
    screen.resize(160, 48)
    state = dataclasses.replace(STATE, robots={"magellan": robot()})
    drawn = screen.draw(state)
    assert drawn is not None
    screen.resize(80, 24)
    before, after = screen.compose(drawn), screen.render(state)
    assert before is not None
    assert after is not None
    assert (before.columns, after.columns) == (160, 80)


def test_a_plot_keeps_its_history_when_the_terminal_changes_its_size() -> None:
    screen = View(layout_of(view(viewport("visualizePlot", (0, 0, 160, 96)))))
    lengths = []
    for number, columns in ((1, 80), (2, 60)):
        screen.resize(columns, 24)
        measured = known(NAVIGATION, number, age=0.9 / number**3)
        cells = rendered(screen, {"magellan": robot(navigation=measured)}, STATE)
        assert cells is not None
        line = (cells.pixels[..., :3] == STATE.theme.accent[:3]).all(axis=2)
        lengths.append(int(line.sum()))
    assert lengths[1] > lengths[0]


def test_the_nearer_viewport_covers_the_farther() -> None:
    front = viewport("visualizeLabel", (0, 0, 160, 2), text="front", zpos=2, name="front")
    back = viewport("visualizeLabel", (0, 0, 160, 2), text="behind", zpos=1, name="back")
    assert words(shown(view(front, back), 80, 24)).startswith("frontd")


def test_viewports_of_several_robots_show_each_its_own() -> None:
    spec = view(
        viewport("visualizeStatus", (0, 0, 160, 2)),
        viewport("visualizeStatus", (0, 2, 160, 2), robot="blimp", name="other"),
    )
    screen = View(layout_of(spec))
    screen.resize(160, 48)
    cells = rendered(screen, {"magellan": robot(), "blimp": robot("blimp")}, STATE)
    assert cells is not None
    lines = words(cells).splitlines()
    assert "magellan" in lines[0]
    assert "blimp" in lines[1]


def test_places_scale_and_touching_viewports_keep_touching() -> None:
    left = viewport("visualizePanData", (0, 0, 53, 96))
    right = viewport("visualizePanData", (53, 0, 107, 96))
    for columns in range(1, 200, 7):
        one = area_of(left.place, DESIGN, columns, 30, whole_cells=False)
        two = area_of(right.place, DESIGN, columns, 30, whole_cells=False)
        assert one.x == 0
        assert one.x + one.width in {two.x, two.x + 1}  # one pixel is the least there is
        assert two.x + two.width == columns
        assert (one.y, one.height) == (0, 60)
    assert area_of(left.place, DESIGN, 320, 96, whole_cells=False).width == 106


def test_unscaled_viewports_keep_their_size_and_scale_their_corner() -> None:
    spec = viewport("visualizePanData", (40, 24, 30, 10), scaled=False)
    place = area_of(spec.place, DESIGN, 80, 24, whole_cells=False)
    assert (place.x, place.y, place.width, place.height) == (20, 12, 30, 10)


def test_an_unscaled_viewport_inside_the_design_stays_inside_the_terminal() -> None:
    spec = viewport("visualizePanData", (120, 56, 40, 40), scaled=False)
    place = area_of(spec.place, DESIGN, 80, 24, whole_cells=False)
    assert (place.x, place.y, place.width, place.height) == (40, 8, 40, 40)


def test_a_viewport_partly_outside_the_design_stays_partly_outside() -> None:
    spec = viewport("visualizePanData", (-20, -12, 40, 24))
    place = area_of(spec.place, DESIGN, 80, 24, whole_cells=False)
    assert (place.x, place.y, place.width, place.height) == (-10, -6, 20, 12)
    cells = shown(view(viewport("visualizeCameraImage", (80, 0, 400, 96))), 80, 24)
    assert (cells.pixels[:, :40, 0] == 1).all()


@given(
    corner=st.tuples(st.integers(-50, 150), st.integers(-50, 90)),
    size=st.tuples(st.integers(1, 100), st.integers(1, 80)),
    terminal=st.tuples(st.integers(1, 300), st.integers(1, 100)),
    scaled=st.booleans(),
)
def test_text_viewports_are_made_of_whole_cells(
    corner: tuple[int, int], size: tuple[int, int], terminal: tuple[int, int], *, scaled: bool
) -> None:
    columns, rows = terminal
    spec = viewport("visualizeStatus", (*corner, *size), scaled=scaled)
    place = area_of(spec.place, DESIGN, columns, rows, whole_cells=True)
    assert place.width >= 1
    assert place.height >= 2
    assert place.y % 2 == place.height % 2 == 0
    if corner[1] >= 0 and corner[1] + size[1] <= 96 and place.height <= 2 * rows:
        assert 0 <= place.y <= 2 * rows - place.height


def test_the_picture_size_is_the_largest_shown_of_each_robot() -> None:
    spec = view(
        viewport("visualizeCameraImage", (0, 0, 80, 60)),
        viewport("visualizeCameraImage", (80, 0, 40, 30), name="small"),
        viewport("visualizeCameraImage", (0, 60, 8, 6), robot="blimp", name="blimp"),
    )
    screen = View(layout_of(spec))
    screen.resize(160, 48)
    state = dataclasses.replace(STATE, robots={"magellan": robot(), "blimp": robot("blimp")})
    assert screen.picture_needs(state) == {
        "magellan": {"": PictureNeed(size=(80, 60))},
        "blimp": {"": PictureNeed(size=(16, 12))},
    }
    screen.resize(80, 24)
    assert screen.picture_needs(state)["magellan"] == {"": PictureNeed(size=(40, 30))}


@pytest.mark.parametrize(
    ("chosen", "needs"),
    [
        ("magellan", {"magellan": ((80, 60), 0.0), "blimp": ((32, 24), 0.333)}),
        ("blimp", {"magellan": ((32, 24), 0.333), "blimp": ((80, 60), 0.0)}),
    ],
)
def test_the_picture_of_the_chosen_robot_is_large_and_frequent_the_others_small_and_slow(
    chosen: str, needs: dict[str, tuple[tuple[int, int], float]]
) -> None:
    small = visualizer_spec("visualizeCameraImage", interval_ms=333.0)
    spec = view(
        viewport("visualizeCameraImage", (0, 0, 80, 60), robot=CHOSEN),
        viewport("visualizeCameraImage", (80, 0, 32, 24), name="1", visualizer=small),
        viewport(
            "visualizeCameraImage", (80, 24, 32, 24), name="2", visualizer=small, robot="blimp"
        ),
    )
    screen = View(layout_of(spec))
    screen.resize(160, 48)
    robots = {"magellan": robot(), "blimp": robot("blimp")}
    state = dataclasses.replace(STATE, robots=robots, chosen=chosen)
    assert screen.picture_needs(state) == {
        name: {"": PictureNeed(size=size, interval_s=interval)}
        for name, (size, interval) in needs.items()
    }


@given(st.text(), st.text(), st.lists(st.text(), max_size=3), st.integers(1, 60))
def test_no_text_from_outside_puts_a_control_byte_on_the_terminal(
    name: str, detail: str, held: list[str], columns: int
) -> None:
    spec = view(
        viewport("visualizeCameraImage", (0, 0, 160, 60)),
        viewport("visualizeLabel", (0, 60, 160, 20), text=detail),
        viewport("visualizeStatus", (0, 80, 160, 8)),
        viewport("visualizeRangeData", (0, 88, 160, 8)),
    )
    link = LinkState(phase=LinkPhase.LOST, since=90.0, endpoint=name, detail=detail)
    screen = View(layout_of(spec))
    screen.resize(columns, 12)
    robots = {"magellan": robot(name, link=link, picture=None, navigation=None)}
    cells = rendered(screen, robots, ConsoleState(now=100.0, held=tuple(held)))
    assert cells is not None
    for row in encoded_rows(cells):
        text = re.sub(r"\x1b\[[\d;]+m", "", row)
        assert not re.search(r"[\x00-\x1f\x7f-\x9f]", text)
        assert len(text) == columns


def test_a_fault_in_one_viewport_takes_no_other_from_the_operator(
    caplog: pytest.LogCaptureFixture,
) -> None:
    broken = known(Picture(pixels=np.zeros(5, np.uint8), camera=CAMERA))
    pane = View(layout_of(EVERYTHING))
    pane.resize(120, 40)
    cells = rendered(pane, {"magellan": robot(picture=broken)}, STATE)
    assert cells is not None
    assert "visualizeCameraImage failed" in words(cells)
    assert "MOVING" in words(cells)
    rendered(pane, {"magellan": robot(picture=broken)}, STATE)
    assert len(caplog.records) == 1
    mended = rendered(pane, {"magellan": robot()}, STATE)
    assert mended is not None
    assert "failed" not in words(mended)


def test_a_viewport_that_fills_the_view_gets_larger_pictures_and_leaves_room_for_safety() -> None:
    shown = two_panes()
    shown.resize(100, 20)
    robots = {"magellan": robot(), "blimp": robot("blimp")}
    usual = dataclasses.replace(STATE, robots=robots)
    full = dataclasses.replace(usual, full="visualizeCameraImage")
    before = shown.render(usual)
    assert before is not None
    assert shown.picture_needs(usual) == {"magellan": {"": PictureNeed(size=(50, 38))}}
    assert shown.picture_needs(full) == {"magellan": {"": PictureNeed(size=(48, 36))}}
    cells = shown.render(full)
    assert cells is not None
    assert not cells.glyphs[:18].any()
    assert "blimp" in words(cells).splitlines()[18]
    assert (cells.pixels[:36, 30:70, 0] == 200).all()
    assert [hit.viewport for hit in shown.hits(99, 0, full)] == ["visualizeCameraImage"]
    again = shown.render(usual)
    assert again is not None
    assert np.array_equal(again.pixels, before.pixels)
    assert shown.render(dataclasses.replace(usual, full="nothing")) is None


def test_a_hit_knows_its_robot_and_where_in_the_picture_it_is() -> None:
    shown = two_panes()
    shown.resize(100, 20)
    state = dataclasses.replace(STATE, robots={"magellan": robot(), "blimp": robot("blimp")})
    shown.render(state)
    # The picture is 50 x 38 pixels in a room of 50 x 40.
    (hit,) = shown.hits(10, 20, state)
    assert (hit.viewport, hit.robot) == ("visualizeCameraImage", "magellan")
    assert hit.in_picture == pytest.approx((10.5 / 50, 19.5 / 38))
    (beside,) = shown.hits(10, 39, state)
    assert beside.in_picture is None
    (other,) = shown.hits(60, 20, state)
    assert (other.robot, other.in_picture) == ("blimp", None)


def test_the_view_knows_where_a_camera_is_seen() -> None:
    seen = View(
        layout_of(
            view(
                viewport("visualizeCameraImage", (0, 0, 160, 80)),
                viewport("visualizeStatus", (0, 76, 160, 20), zpos=1),
                viewport("visualizeRangeData", (120, 40, 36, 36), zpos=2),
            )
        )
    )
    seen.resize(160, 48)
    cells = rendered(seen, {"magellan": robot()}, STATE)
    assert cells is not None
    written = cells.glyphs[:38] != 0
    assert (seen.urgencies[:38][~written] == Urgency.VIDEO).all()
    assert (seen.urgencies[38:] == Urgency.ALARM).all()
    assert not (seen.urgencies[:38][written] == Urgency.ALARM).any()


def test_a_camera_behind_the_help_is_not_seen() -> None:
    seen = two_panes()
    seen.resize(160, 48)
    assert rendered(seen, {"magellan": robot()}, STATE) is not None
    assert (seen.urgencies == Urgency.VIDEO).any()
    helped = dataclasses.replace(STATE, help=True)
    assert rendered(seen, {"magellan": robot()}, helped) is not None
    assert not (seen.urgencies == Urgency.VIDEO).any()


def test_a_title_takes_the_first_row_of_a_pane_that_has_room_for_it() -> None:
    for rows, titled in ((10, True), (3, True), (2, False)):
        spec = view(
            viewport("visualizeStatus", (0, 0, 40, 2 * rows), title="what it does"),
            xsize=40,
            ysize=2 * rows + 10,
        )
        screen = View(layout_of(spec))
        screen.resize(40, rows + 5)
        cells = rendered(screen, {"magellan": robot()}, STATE)
        assert cells is not None
        first, second = words(cells).splitlines()[:2]
        assert first.startswith("─ what it does ──") == titled
        assert ("MOVING" in second) == titled
    hit = screen.hits(5, 1, STATE)
    assert [each.viewport for each in hit] == ["visualizeStatus"]
