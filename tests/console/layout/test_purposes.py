"""What a rule promises of a class: purposes and flags that need further methods."""

from __future__ import annotations

from pathlib import Path

import pytest

from rune_tui.errors import LayoutError
from rune_tui.layout.loader import load_layout
from rune_tui.layout.rules import Purpose
from rune_tui.startup.opening import BUILT_IN
from tests.support.cases import for_each

LAYOUT = """<rune>
  <extension file="own.py"/>
  <robot name="magellan"/>
  <view xsize="40" ysize="20">
    <viewport name="a" xpos="0" ypos="0" xsize="40" ysize="20">
      <visualizer function="visualizeLink"/>
    </viewport>
  </view>
</rune>
"""
WIDGET = """
from rune_tui.layout.rules import HandlerRule, Purpose
from rune_tui.widgets.widget import PressWidget

class Own(PressWidget):
    rule = HandlerRule(meaning="own", purpose=Purpose.{purpose})

    def press(self, event, event_spec, state):
        return ()

WIDGETS = {{"widgetOwn": Own}}
"""
VISUALIZER = """
from rune_tui.layout.rules import VisualizerRule

class Own:
    rule = VisualizerRule(meaning="own"{flags})
    from_spec = draw = source = {methods} print

VISUALIZERS = {{"visualizeOwn": Own}}
"""


@pytest.mark.parametrize(
    ("code", "method"),
    [
        (WIDGET.format(purpose="DRIVE"), "accepts"),
        (WIDGET.format(purpose="TAKE_CONTROL"), "takes_by_driving"),
        (VISUALIZER.format(flags=", pictures=True", methods=""), "picture_size"),
        (VISUALIZER.format(flags=", locates=True", methods=""), "locate"),
        (VISUALIZER.format(flags=", draws_over=True", methods=""), "draw_over"),
    ],
)
def test_a_class_without_the_methods_of_its_rule_is_refused(
    tmp_path: Path, code: str, method: str
) -> None:
    (tmp_path / "own.py").write_text(code)
    path = tmp_path / "layout.xml"
    path.write_text(LAYOUT)
    with pytest.raises(LayoutError, match=f"has no method {method}"):
        load_layout(path, BUILT_IN)


def test_a_widget_with_the_purpose_stop_needs_no_more(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(WIDGET.format(purpose="STOP"))
    path = tmp_path / "layout.xml"
    path.write_text(LAYOUT)
    assert load_layout(path, BUILT_IN).vocabulary.widgets["widgetOwn"].rule.purpose


DERIVED = """
from rune_tui.layout.rules import HandlerRule
from rune_tui.widgets.speed import StopRobot

class Own(StopRobot):
    rule = HandlerRule(meaning="stops in its own way", sends=("GCM_Stop",))

WIDGETS = {"widgetOwn": Own}
"""


def test_a_class_derived_from_a_stop_is_a_stop(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(DERIVED)
    path = tmp_path / "layout.xml"
    path.write_text(LAYOUT)
    rule = load_layout(path, BUILT_IN).vocabulary.widgets["widgetOwn"].rule
    assert rule.purpose is Purpose.STOP
    assert rule.meaning == "stops in its own way"


@pytest.mark.parametrize(
    ("methods", "flags"),
    [
        ("", (False, False, False)),
        ("locate =", (True, False, False)),
        ("draw_over = in_picture =", (False, True, False)),
        ("picture_size = in_picture =", (False, False, True)),
    ],
)
def test_a_visualizer_has_the_flags_of_its_methods(
    tmp_path: Path, methods: str, flags: tuple[bool, ...]
) -> None:
    (tmp_path / "own.py").write_text(VISUALIZER.format(flags="", methods=methods))
    path = tmp_path / "layout.xml"
    path.write_text(LAYOUT)
    rule = load_layout(path, BUILT_IN).vocabulary.visualizers["visualizeOwn"].rule
    assert (rule.locates, rule.draws_over, rule.pictures) == flags


@for_each("name", BUILT_IN.visualizers)
def test_the_rules_of_rune_name_all_flags_of_their_classes(name: str) -> None:
    kind = BUILT_IN.visualizers[name]
    assert kind.rule.locates == hasattr(kind, "locate")
    assert kind.rule.draws_over == hasattr(kind, "draw_over")
    assert kind.rule.pictures == hasattr(kind, "picture_size") == hasattr(kind, "in_picture")
