"""What the inputs of a layout do, in words."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rune_tui.layout.actions import Action, actions_of
from rune_tui.layout.spec import LayoutSpec
from rune_tui.startup.opening import BUILT_IN, open_layout
from tests.support.cases import for_each

LAYOUT = """\
<rune>
  <robot name="magellan">
    <capability name="VIS_VID"/><capability name="VIS_PTZ"/><capability name="VIS_NIGHT"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/><capability name="NAV_GOAL"/>
    <capability name="PRO_MAP"/><capability name="PRO_POINTS"/><capability name="AUT_PILOT"/>
  </robot>
  <robot name="blimp" hub="tcp://127.0.0.1:1391">
    <capability name="VIS_VID"/><capability name="VIS_PTZ"/><capability name="VIS_NIGHT"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/><capability name="NAV_GOAL"/>
    <capability name="PRO_MAP"/><capability name="PRO_POINTS"/><capability name="AUT_PILOT"/>
  </robot>
  <view xsize="160" ysize="96">
    <viewport name="camera" robot="*" xpos="0" ypos="0" xsize="80" ysize="96">
      <visualizer function="visualizeCameraImage"/>
      <widget handler="widgetSetSpeed">
        <option name="linear" value="0.3"/>
        <event key="w" control="translate"/>
        <event key="up" control="translate"/>
        <event key="s" control="translate" value="-0.5"/>
      </widget>
      <widget handler="widgetAdjustZoom"><event mouse="wheel"/></widget>
      <widget handler="widgetSetVictim"><event mouse="left" when="released"/></widget>
    </viewport>
    <viewport name="map" robot="blimp" xpos="80" ypos="0" xsize="80" ysize="96">
      <widget handler="widgetHomePTZ"><event key="h"/></widget>
      <widget handler="widgetFullScreen">
        <option name="viewport" value="camera"/>
        <event key="f"/>
      </widget>
    </viewport>
    <widget handler="widgetQuit"><event key="q"/></widget>
  </view>
</rune>
"""


@pytest.fixture
def layout(tmp_path: Path) -> LayoutSpec:
    path = tmp_path / "layout.xml"
    path.write_text(LAYOUT)
    return open_layout(path)


@pytest.fixture
def actions(layout: LayoutSpec) -> dict[tuple[str, ...], Action]:
    return {action.inputs: action for action in actions_of(layout)}


def test_inputs_that_do_the_same_are_one_action_with_its_direction_and_options(
    actions: dict[tuple[str, ...], Action],
):
    said = actions["W", "up"].words
    assert said == "Drive forward"
    assert actions[("S",)].words == "Drive backward, 50 %"
    assert actions[("mouse wheel in camera",)].words == "Zoom closer or wider"
    assert actions[("F",)].words == "Full screen: camera"


def test_whom_an_action_concerns_is_its_robot_or_the_console(
    actions: dict[tuple[str, ...], Action],
):
    concerned = {inputs: action.robot for inputs, action in actions.items()}
    assert concerned["W", "up"] == "*"
    assert concerned[("H",)] == "blimp"
    assert concerned[("F",)] == concerned[("Q",)] == ""


def test_what_is_held_pointed_or_turned_cannot_be_chosen_from_a_list(
    actions: dict[tuple[str, ...], Action],
):
    listed = {inputs for inputs, action in actions.items() if action.at_once}
    assert listed == {("H",), ("F",), ("Q",)}


@for_each("handler", sorted(BUILT_IN.widgets))
def test_every_handler_says_in_a_few_plain_words_what_its_inputs_do(handler: str):
    rule = BUILT_IN.widgets[handler].rule
    assert rule.section is not None
    assert set(rule.says) <= {"", *rule.controls}
    for control in rule.controls or ("",):
        template = rule.says.get(control, rule.says.get("", ""))
        assert 0 < len(template) <= 48, control
        named = set(re.findall(r"\{(\w+)\}", template))
        assert named <= {"direction", *rule.options}
