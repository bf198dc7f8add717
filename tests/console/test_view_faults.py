"""Visualizers of somebody else that fail or take long, and what is left of the view."""

from __future__ import annotations

import dataclasses
import inspect
import time
from collections.abc import Hashable
from typing import Any, ClassVar, Self

import pytest

from rune_tui.compositor.cells import Cells
from rune_tui.layout.rules import Options, VisualizerRule, Vocabulary
from rune_tui.layout.spec import LayoutSpec, VisualizerSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import RobotState
from rune_tui.model.world import WorldPoint
from rune_tui.raster.canvas import Canvas
from rune_tui.view import View
from rune_tui.visualizers.registry import VISUALIZERS
from tests.console.states import standing, view_of
from tests.console.visualizers.conftest import Made

SHOWN = ConsoleState(now=1.0, robots={"magellan": Made().robot()})


class Processor:
    """The processor's time, which goes on by what drawing takes."""

    spent = 0.0


class Foreign:
    """Counts its drawings, each of which takes a while, and fails to tell where anything is."""

    rule: ClassVar = VisualizerRule(meaning="a count", locates=True)
    whole_cells: ClassVar[bool] = True
    takes: ClassVar[float] = 0.0
    drawn: ClassVar[int] = 0

    @classmethod
    def from_spec(cls, spec: VisualizerSpec) -> Self:
        del spec
        return cls()

    def draw(self, canvas: Canvas, robot: RobotState, state: ConsoleState) -> None:
        del robot
        Foreign.drawn += 1
        Processor.spent += self.takes
        canvas.text(0, 1, f"drawing {self.drawn}", state.theme.ink)

    def source(self, robot: RobotState, state: ConsoleState) -> Hashable:
        del robot, state
        return object()

    def locate(self, *where: Any) -> Any:
        raise ZeroDivisionError(where)


@pytest.fixture
def view(monkeypatch: pytest.MonkeyPatch) -> View:
    monkeypatch.setattr(Processor, "spent", 0.0)
    monkeypatch.setattr(Foreign, "drawn", 0)
    spec = VisualizerSpec(
        function="visualizeForeign",
        message="",
        option=0.0,
        text="",
        options=Options.of({}, {}),
    )
    layout = LayoutSpec(
        path="",
        run_number=0,
        robots=(),
        view=view_of(standing("foreign", spec, (0, 0, 40, 20)), xsize=40, ysize=20),
        vocabulary=Vocabulary(visualizers={"visualizeForeign": Foreign}, widgets={}),
    )
    made = View(layout, spent=lambda: Processor.spent)
    made.resize(40, 10)
    return made


def words(cells: Cells | None) -> str:
    assert cells is not None
    return "\n".join("".join(chr(g or 32) for g in row) for row in cells.glyphs.tolist())


def test_a_viewport_whose_drawing_holds_up_the_console_rests_and_says_so(
    view: View, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Foreign, "takes", 0.5)
    assert "slow: drawn every 6 s" in words(view.render(SHOWN))
    assert view.render(dataclasses.replace(SHOWN, now=SHOWN.now + 4.9)) is None
    monkeypatch.setattr(Foreign, "takes", 0.01)
    later = dataclasses.replace(SHOWN, now=SHOWN.now + 5.1)
    again = words(view.render(later))
    assert "drawing 2" in again
    assert "slow" not in again
    assert "drawing 3" in words(view.render(later))


def test_what_is_vital_never_rests_however_long_its_drawing_takes(
    view: View, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Foreign, "takes", 0.5)
    monkeypatch.setattr(Foreign, "rule", dataclasses.replace(Foreign.rule, vital=True))
    for number in range(1, 4):
        shown = words(view.render(SHOWN))
        assert f"drawing {number}" in shown
        assert "slow" not in shown


def test_a_drawing_that_waits_for_a_busy_processor_does_not_make_its_viewport_rest() -> None:
    """What counts is what this thread computes, not how long it has to wait for its turn."""
    assert inspect.signature(View).parameters["spent"].default is time.thread_time


def test_status_alarms_and_control_are_vital() -> None:
    vital = {name for name, kind in VISUALIZERS.items() if kind.rule.vital}
    of_one = {"visualizeStatus", "visualizeAlarms", "visualizeControl"}
    assert vital == of_one | {"visualizeTeam", "visualizeAttention"}


def test_a_viewport_that_is_hidden_and_shown_again_is_not_kept_waiting_by_its_rest(
    view: View, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Foreign, "takes", 0.5)
    view.render(SHOWN)
    view.render(dataclasses.replace(SHOWN, shown={"foreign": False}))
    assert "drawing 2" in words(view.render(SHOWN))


def test_a_visualizer_that_fails_to_tell_what_was_clicked_leaves_a_click_without_a_place(
    view: View, caplog: pytest.LogCaptureFixture
) -> None:
    view.render(SHOWN)
    for _ in range(3):
        (hit,) = view.hits(3, 3, SHOWN)
    assert (hit.viewport, hit.robot, hit.place) == ("foreign", "magellan", None)
    assert [record.message for record in caplog.records] == [
        "viewport foreign cannot locate a click"
    ]


def test_a_picture_that_cannot_be_made_says_so_and_is_made_again_when_it_can(
    view: View, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    assert "drawing 1" in words(view.render(SHOWN))
    with monkeypatch.context() as patch:
        patch.setattr("rune_tui.view.banner_of", lambda *_: 1 / 0)
        assert "this cannot be drawn" in words(view.render(SHOWN))
        assert view.render(SHOWN) is None
    assert len(caplog.records) == 1
    assert "drawing 2" in words(view.render(SHOWN))


@pytest.mark.parametrize(
    "far", [{"x": 1.1e6}, {"y": -2e6}, {"uncertainty": 2e10}, {"distance": 1e11}]
)
def test_a_click_on_a_place_that_no_message_may_name_has_no_place(
    view: View, monkeypatch: pytest.MonkeyPatch, far: dict[str, float]
) -> None:
    words(view.render(SHOWN))
    values = {"x": 1.0, "y": 2.0, "uncertainty": 0.1} | far
    monkeypatch.setattr(Foreign, "locate", lambda *_: WorldPoint(**values))
    (hit,) = view.hits(3, 3, SHOWN)
    assert hit.place is None
    monkeypatch.setattr(Foreign, "locate", lambda *_: WorldPoint(x=1.0, y=2.0, uncertainty=0.1))
    (hit,) = view.hits(3, 3, SHOWN)
    assert hit.place is not None
