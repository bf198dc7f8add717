"""A layout for several sizes of the terminal: which size takes what, and what is doubtful in it."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.layout.arrangement_notes import arrangement_notes
from rune_tui.layout.placing import Placed, arrangement_for, filled, placed
from rune_tui.layout.spec import ArrangementSpec, LayoutSpec, PlaceSpec
from rune_tui.startup.opening import open_layout

TEXT = """\
<rune>
  <robot name="magellan">
    <capability name="VIS_VID"/><capability name="NAV_STATE"/><capability name="NAV_MOVE"/>
  </robot>
  <view background="#102030">
    <viewport name="camera"><visualizer function="visualizeCameraImage"/>
      <widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget></viewport>
    <viewport name="range" transparency="96" zpos="2" fit="fixed">
      <visualizer function="visualizeRangeData"/></viewport>
    <viewport name="status"><visualizer function="visualizeStatus"/></viewport>
    <arrangement name="small" xsize="80" ysize="48">
      <place viewport="camera" xpos="0" ypos="0" xsize="80" ysize="46"/>
      <place viewport="range" xpos="50" ypos="2" xsize="30" ysize="30" visible="false" zpos="3"/>
      <place viewport="status" xpos="0" ypos="46" xsize="80" ysize="2"/>
    </arrangement>
    <include file="wide.xml"/>
  </view>
</rune>
"""
WIDE = """\
<part>
  <arrangement name="wide" min-columns="120" min-rows="30" xsize="160" ysize="96">
    <place viewport="status" xpos="0" ypos="94" xsize="160" ysize="2"/>
    <include file="picture.xml"/>
    <place viewport="range" xpos="112" ypos="0" xsize="48" ysize="48" transparency="0" fit="scale"/>
  </arrangement>
</part>
"""
PICTURE = '<part><place viewport="camera" xpos="0" ypos="0" xsize="112" ysize="94"/></part>'


@pytest.fixture
def layout(tmp_path: Path) -> LayoutSpec:
    return written(tmp_path, TEXT)


def written(folder: Path, text: str) -> LayoutSpec:
    (folder / "layout.xml").write_text(text)
    (folder / "wide.xml").write_text(WIDE)
    (folder / "picture.xml").write_text(PICTURE)
    return open_layout(folder / "layout.xml")


def named(places: tuple[Placed, ...]) -> dict[str, Placed]:
    return {each.spec.viewport: each for each in places}


def test_a_viewport_is_written_once_and_each_arrangement_places_it(layout: LayoutSpec) -> None:
    small, wide = layout.view.arrangements
    assert [each.name for each in layout.view.viewports] == ["camera", "range", "status"]
    assert (small.name, small.min_columns, small.min_rows) == ("small", 1, 1)
    assert (wide.name, wide.min_columns, wide.min_rows) == ("wide", 120, 30)
    assert [place.viewport for place in wide.places] == ["status", "camera", "range"]


def test_how_a_viewport_is_shown_is_its_own_unless_a_place_says_otherwise(
    layout: LayoutSpec,
) -> None:
    small, wide = layout.view.arrangements
    here, there = small.places[1], wide.places[2]
    assert (here.visible, here.transparency, here.zpos, here.scaled) == (False, 96, 3, False)
    assert (there.visible, there.transparency, there.zpos, there.scaled) == (True, 0, 2, True)


@pytest.mark.parametrize(
    ("size", "taken"),
    [
        ((160, 48), "wide"),
        ((120, 30), "wide"),
        ((119, 90), "small"),
        ((200, 29), "small"),
        ((20, 5), "small"),
    ],
)
def test_a_terminal_takes_the_largest_arrangement_that_fits(
    layout: LayoutSpec, size: tuple[int, int], taken: str
) -> None:
    assert arrangement_for(layout.view.arrangements, *size).name == taken


@given(
    least=st.lists(st.tuples(st.integers(1, 99), st.integers(1, 99)), min_size=1, unique=True),
    size=st.tuples(st.integers(1, 120), st.integers(1, 120)),
)
def test_every_size_takes_one_and_a_larger_one_never_a_smaller(
    least: list[tuple[int, int]], size: tuple[int, int]
) -> None:
    made = [
        ArrangementSpec(
            name=str(each), min_columns=each[0], min_rows=each[1], xsize=9, ysize=9, places=()
        )
        for each in least
    ]
    taken = arrangement_for(made, *size)
    fitting = [(w, h) for w, h in least if w <= size[0] and h <= size[1]]
    assert (taken.min_columns, taken.min_rows) == (max(fitting) if fitting else min(least))


def test_check_tells_which_size_takes_which_arrangement(layout: LayoutSpec) -> None:
    assert list(arrangement_notes(layout)) == [
        "arrangement small: from 1 columns and 1 rows, 3 viewports",
        "arrangement wide: from 120 columns and 30 rows, 3 viewports",
    ]


@pytest.mark.parametrize(
    ("old", "new", "note"),
    [
        (
            'ypos="46" xsize="80" ysize="2"/>',
            'ypos="40" xsize="80" ysize="8"/>',
            "small: 'camera' and 'status' overlap at 80 x 24 and have the same zpos",
        ),
        (
            '<place viewport="status" xpos="0" ypos="46" xsize="80" ysize="2"/>',
            "",
            "small: no visualizeStatus of robot 'magellan', which the layout has elsewhere; it is "
            "needed at every size",
        ),
        (
            "<arrangement",
            '<viewport name="spare"><visualizer function="visualizeCompass"/></viewport>'
            "<arrangement",
            "viewport 'spare' is placed nowhere, so it is never drawn",
        ),
    ],
)
def test_check_notes_what_is_doubtful(tmp_path: Path, old: str, new: str, note: str) -> None:
    doubtful = written(tmp_path, TEXT.replace(old, new, 1))
    assert [each for each in arrangement_notes(doubtful) if each.startswith("note")] == [
        f"note: {note}"
    ]


def test_check_notes_fixed_viewports_that_meet_on_the_smallest_terminal_only(
    tmp_path: Path,
) -> None:
    """They keep their size while what is around them shrinks."""
    fixed = '<place viewport="status" xpos="0" ypos="46" xsize="80" ysize="2" fit="fixed"/>'
    text = TEXT.replace('ysize="46"/>', 'ysize="40" fit="fixed"/>', 1)
    text = text.replace('<place viewport="status" xpos="0" ypos="46" xsize="80" ysize="2"/>', fixed)
    text = text.replace('<arrangement name="small"', '<arrangement name="small" min-rows="10"')
    (note,) = [each for each in arrangement_notes(written(tmp_path, text)) if "overlap" in each]
    assert note == "note: small: 'camera' and 'status' overlap at 80 x 10 and have the same zpos"


def test_check_notes_pictures_of_two_robots_that_touch(tmp_path: Path) -> None:
    path = tmp_path / "two.xml"
    robots = "".join(
        f'<robot name="{name}"><capability name="VIS_VID"/></robot>' for name in ("left", "right")
    )
    panes = "".join(
        f'<viewport name="{name}" robot="{name}" xpos="{x}" ypos="0" xsize="{{width}}" ysize="9">'
        '<visualizer function="visualizeCameraImage"/></viewport>'
        for name, x in (("left", 0), ("right", 40))
    )
    text = f'<rune>{robots}<view xsize="80" ysize="9">{panes}</view></rune>'
    path.write_text(text.format(width=40))
    (note,) = arrangement_notes(open_layout(path))
    assert note == "note: 'left' and 'right' show different robots and touch; leave a gap"
    path.write_text(text.format(width=38))
    assert list(arrangement_notes(open_layout(path))) == []


def test_a_title_parts_the_pictures_of_two_robots(tmp_path: Path) -> None:
    path = tmp_path / "two.xml"
    robots = "".join(
        f'<robot name="{name}"><capability name="VIS_VID"/></robot>' for name in ("left", "right")
    )
    panes = "".join(
        f'<viewport name="{name}" robot="{name}" {title} xpos="0" ypos="{y}" xsize="80" ysize="9">'
        '<visualizer function="visualizeCameraImage"/></viewport>'
        for name, title, y in (("left", "", 0), ("right", "{title}", 9))
    )
    text = f'<rune>{robots}<view xsize="80" ysize="18">{panes}</view></rune>'
    path.write_text(text.replace("{title}", ""))
    assert len(list(arrangement_notes(open_layout(path)))) == 1
    path.write_text(text.replace("{title}", 'title="right"'))
    assert list(arrangement_notes(open_layout(path))) == []


def place(name: str, x: int, y: int, width: int, height: int, zpos: int = 0) -> PlaceSpec:
    return PlaceSpec(viewport=name, xpos=x, ypos=y, xsize=width, ysize=height, zpos=zpos)


SEARCH = ArrangementSpec(
    xsize=160,
    ysize=96,
    places=(
        place("camera", 0, 0, 112, 84),
        place("range", 78, 54, 30, 30, 2),
        place("map", 112, 0, 48, 46),
        place("alarms", 112, 48, 48, 8),
        place("control", 112, 56, 48, 6),
        place("status", 0, 94, 160, 2, 5),
    ),
)
VITAL = ("alarms", "control", "status")


def test_full_screen_keeps_what_lies_over_the_picture_and_all_that_is_vital() -> None:
    found = named(filled(SEARCH, "camera", VITAL, 120, 40))
    assert list(found) == ["camera", "range", "status", "alarms", "control"]
    camera, pie = found["camera"].area, found["range"].area
    assert (camera.x, camera.y, camera.width, camera.height) == (0, 0, 120, 2 * 37)
    assert pie.x == pytest.approx(78 / 112 * 120, abs=1)
    assert pie.y == pytest.approx(54 / 84 * 74, abs=1)
    status, alarms, control = (found[name].area for name in ("status", "alarms", "control"))
    assert (status.x, status.y, status.width, status.height) == (0, 78, 120, 2)
    assert (alarms.x, alarms.y, alarms.width, alarms.height) == (0, 74, 60, 4)
    assert (control.x, control.y, control.width, control.height) == (60, 74, 60, 4)


@given(columns=st.integers(16, 300), rows=st.integers(4, 100))
def test_in_full_screen_nothing_vital_is_covered_by_the_picture(columns: int, rows: int) -> None:
    found = named(filled(SEARCH, "camera", VITAL, columns, rows))
    camera = found["camera"].area
    assert "status" in found
    assert camera.height >= rows  # at least half of the terminal
    for name in set(VITAL) & set(found):
        area = found[name].area
        assert not area.meets(camera)
        assert area.y % 2 == 0
        assert area.height >= 2
        assert 0 <= area.x <= area.x + area.width <= columns
        assert area.y + area.height <= 2 * rows


def test_a_viewport_without_a_place_fills_the_view_as_well() -> None:
    found = named(filled(SEARCH, "spare", VITAL, 80, 24))
    assert list(found) == ["spare", "status", "alarms", "control"]


def test_what_is_vital_and_lies_over_the_picture_stays_there() -> None:
    over = dataclasses.replace(
        SEARCH, places=(place("camera", 0, 0, 160, 96), place("status", 0, 94, 160, 2, 1))
    )
    camera, status = filled(over, "camera", VITAL, 80, 24)
    assert camera.area.height == 48
    assert (status.area.y, status.area.height) == (46, 2)


def test_places_of_an_arrangement_fill_the_terminal_as_the_design_says() -> None:
    assert [each.area.y for each in placed(SEARCH, 160, 48)] == [0, 54, 0, 48, 56, 94]
