"""A view whose layout has an arrangement for small terminals and one for wide ones."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import FillView, ShowViewport
from rune_tui.model.state_changes import changed
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from tests.console.view_scenes import STATE, robot, words

TEXT = """\
<rune>
  <robot name="magellan">
    <capability name="VIS_VID"/><capability name="PRO_MAP"/><capability name="PRO_POINTS"/>
    <capability name="NAV_STATE"/>
  </robot>
  <view>
    <viewport name="camera"><visualizer function="visualizeCameraImage"/></viewport>
    <viewport name="map" zpos="1"><visualizer function="visualizeMapData"/></viewport>
    <viewport name="status"><visualizer function="visualizeStatus"/></viewport>
    <arrangement name="small" xsize="80" ysize="48">
      <place viewport="camera" xpos="0" ypos="0" xsize="80" ysize="46"/>
      <place viewport="map" xpos="40" ypos="0" xsize="40" ysize="24" visible="false"/>
      <place viewport="status" xpos="0" ypos="46" xsize="80" ysize="2"/>
    </arrangement>
    <arrangement name="wide" min-columns="120" xsize="160" ysize="96">
      <place viewport="map" xpos="80" ypos="0" xsize="80" ysize="94"/>
      <place viewport="camera" xpos="0" ypos="0" xsize="80" ysize="94"/>
      <place viewport="status" xpos="0" ypos="94" xsize="160" ysize="2"/>
    </arrangement>
  </view>
</rune>
"""


@pytest.fixture
def view(tmp_path: Path) -> View:
    path = tmp_path / "layout.xml"
    path.write_text(TEXT)
    return View(open_layout(path))


def state_of(view: View) -> ConsoleState:
    return dataclasses.replace(STATE, robots={"magellan": robot()}, places=view.places)


def nearest(view: View, x: int, y: int, state: ConsoleState) -> str:
    view.render(state)
    return view.hits(x, y, state)[0].viewport


def test_another_size_takes_another_arrangement_and_visualizers_keep_their_memory(
    view: View,
) -> None:
    view.resize(160, 48)
    assert nearest(view, 100, 10, state_of(view)) == "map"
    made = {pane.spec.name: pane.visualizer for pane in view.panes}
    assert not view.resize(150, 48)
    assert view.resize(80, 24)
    assert view.places == {"camera": True, "map": False, "status": True}
    assert nearest(view, 60, 10, state_of(view)) == "camera"
    assert {pane.spec.name: pane.visualizer for pane in view.panes} == made


def test_a_key_shows_what_an_arrangement_hides_and_that_holds_at_every_size(view: View) -> None:
    view.resize(80, 24)
    shown = changed(state_of(view), ShowViewport(viewport="map"))
    assert nearest(view, 60, 10, shown) == "map"
    hidden = changed(shown, ShowViewport(viewport="map"))
    assert nearest(view, 60, 10, hidden) == "camera"
    view.resize(160, 48)
    assert view.hits(100, 10, dataclasses.replace(hidden, places=view.places)) == ()


def test_what_has_no_place_at_a_size_is_said_to_have_none(view: View) -> None:
    view.resize(80, 24)
    told = changed(state_of(view), ShowViewport(viewport="elsewhere"))
    assert told.shown == {}
    assert told.notices[-1].text == "elsewhere has no place on a terminal of this size"


def test_full_screen_keeps_the_status_line_at_every_size(view: View) -> None:
    for columns, rows in ((160, 48), (80, 24), (20, 5)):
        view.resize(columns, rows)
        cells = view.render(changed(state_of(view), FillView(viewport="map")))
        assert cells is not None
        assert "MOVING" in words(cells).splitlines()[-1]
