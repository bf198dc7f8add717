"""Visualizers and widgets from outside: files beside a layout, and installed packages."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rune_tui.controls.events import ControlEvent
from rune_tui.dispatch import Dispatch
from rune_tui.errors import LayoutError
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import SendEffect
from rune_tui.startup.opening import open_layout

DOCS = Path(__file__).parents[3] / "docs"
LAYOUT = """<rune>
  {extension}<robot name="robot"><capability name="NAV_GOAL"/></robot>
  <view xsize="80" ysize="48">
    <viewport name="v" xpos="0" ypos="0" xsize="80" ysize="48">
      <visualizer function="{function}"/>
      <widget handler="{handler}"><event key="x"/></widget>
    </viewport>
  </view>
</rune>
"""
PROGRAM = '''
from __future__ import annotations
from dataclasses import dataclass
from typing import ClassVar
from rune_tui.layout.rules import HandlerRule, VisualizerRule
from rune_tui.widgets.widget import PressWidget

@dataclass(frozen=True, slots=True)
class Shown:
    text: str
    rule: ClassVar = VisualizerRule(meaning="nothing")
    whole_cells: ClassVar[bool] = True

    @classmethod
    def from_spec(cls, spec):
        return cls(spec.text)

    def draw(self, canvas, robot, state):
        """Nothing."""

    def source(self, robot, state):
        return None

class Pressed(PressWidget):
    rule: ClassVar = HandlerRule(meaning="nothing")

    def press(self, event, event_spec, state):
        return ()
'''
TABLES = '\nVISUALIZERS = {"visualizeOwn": Shown}\nWIDGETS = {"widgetOwn": Pressed}\n'


def written(
    folder: Path, extension: str = "", function: str = "visualizeOwn", handler: str = "widgetOwn"
) -> Path:
    path = folder / "layout.xml"
    named = f'<extension file="{extension}"/>' if extension else ""
    path.write_text(LAYOUT.format(extension=named, function=function, handler=handler))
    return path


def blocks(page: str) -> tuple[str, str, str]:
    """The program, the layout and the entry point that a page shows."""
    text = (DOCS / page).read_text()
    found = re.findall(r"^```(python|xml|toml)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert [kind for kind, _ in found] == ["python", "xml", "toml"]
    return found[0][1], found[1][1], found[2][1]


def test_the_widget_of_the_page_turns_the_robot(tmp_path: Path) -> None:
    program, layout, _ = blocks("writing-a-widget.md")
    (tmp_path / "turning.py").write_text(program)
    (tmp_path / "turning.xml").write_text(layout)
    dispatch, state = Dispatch(open_layout(tmp_path / "turning.xml")), ConsoleState(now=1.0)
    (left,) = dispatch.handle(ControlEvent(name="a", pressed=True), state)
    (right,) = dispatch.handle(ControlEvent(name="d", pressed=True), state)
    assert isinstance(left, SendEffect)
    assert isinstance(right, SendEffect)
    assert left.definition.name == "GCM_Turn_Command"
    assert (left.robot, left.value.angle) == ("robot", -right.value.angle)
    assert left.value.angle == pytest.approx(0.7853981633974483)
    assert not dispatch.handle(ControlEvent(name="a", pressed=True, repeat=True), state)


def test_a_file_beside_the_layout_or_below_it_brings_both_kinds(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "own.py").write_text(PROGRAM + TABLES)
    layout = open_layout(written(tmp_path, "below/own.py"))
    assert layout.files == (tmp_path / "layout.xml", tmp_path / "below" / "own.py")
    assert layout.vocabulary.visualizers["visualizeOwn"].__name__ == "Shown"
    assert "visualizeOwn" not in open_layout("minimal").vocabulary.visualizers


def test_an_extension_of_a_part_is_looked_for_beside_the_part(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "own.py").write_text(PROGRAM + TABLES)
    (tmp_path / "below" / "part.xml").write_text('<part><extension file="own.py"/></part>')
    path = written(tmp_path)
    path.write_text(path.read_text().replace("<robot", '<include file="below/part.xml"/><robot', 1))
    assert "widgetOwn" in open_layout(path).vocabulary.widgets


def test_two_files_of_one_name_do_not_disturb_each_other(tmp_path: Path) -> None:
    for folder, table in (("a", "VISUALIZERS"), ("b", "WIDGETS")):
        (tmp_path / folder).mkdir()
        lines = [line for line in TABLES.splitlines() if line.startswith(table)]
        (tmp_path / folder / "own.py").write_text(PROGRAM + "\n".join(lines))
    path = written(tmp_path, "a/own.py")
    text = path.read_text().replace("<robot", '<extension file="b/own.py"/><robot', 1)
    path.write_text(text)
    vocabulary = open_layout(path).vocabulary
    modules = {vocabulary.visualizers["visualizeOwn"].__module__,
               vocabulary.widgets["widgetOwn"].__module__}  # fmt: skip
    assert len(modules) == 2


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str], None]:
    """Install a distribution with a module and entry points into a folder that Python looks in."""
    site = tmp_path / "site"
    monkeypatch.syspath_prepend(str(site))

    def put(program: str, points: str) -> None:
        info = site / "rune_dummy-1.0.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: rune-dummy\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(points)
        (site / "rune_dummy.py").write_text(program)
        monkeypatch.delitem(sys.modules, "rune_dummy", raising=False)

    return put


POINTS = """[rune.visualizers]
visualizeOwn = rune_dummy:Shown
[rune.widgets]
widgetOwn = rune_dummy:Pressed
"""


def test_an_installed_package_brings_both_kinds(
    tmp_path: Path, install: Callable[[str, str], None]
) -> None:
    install(PROGRAM, POINTS)
    layout = open_layout(written(tmp_path))
    assert layout.vocabulary.visualizers["visualizeOwn"].__module__ == "rune_dummy"
    assert layout.files == (tmp_path / "layout.xml",)


def test_the_entry_points_of_the_pages_are_those_that_are_looked_for(
    tmp_path: Path, install: Callable[[str, str], None]
) -> None:
    points = ""
    for page in ("writing-a-visualizer.md", "writing-a-widget.md"):
        heading, line = blocks(page)[2].strip().splitlines()
        group = re.fullmatch(r'\[project\.entry-points\."(.*)"\]', heading)
        assert group
        points += f"[{group[1]}]\n{line.replace(chr(34), '').replace('compass:', 'rune_dummy:')}\n"
    points = points.replace("turning:", "rune_dummy:")
    install(
        "\n".join(blocks(page)[0] for page in ("writing-a-visualizer.md", "writing-a-widget.md")),
        points,
    )
    open_layout(written(tmp_path, function="visualizeLabel", handler="widgetTurn"))


@pytest.mark.parametrize(
    ("program", "points", "said"),
    [
        ("raise RuntimeError('no luck')", POINTS, "cannot be loaded: RuntimeError: no luck"),
        ("raise SystemExit", POINTS, "cannot be loaded: SystemExit"),
        ("Shown = Pressed = 1", POINTS, "is no class"),
        ("class Shown: pass\nclass Pressed: pass", POINTS, "has no attribute rule that is a"),
        ("", POINTS, "cannot be loaded: AttributeError"),
        (PROGRAM, POINTS.replace("rune_dummy", "nowhere"), "cannot be loaded: ModuleNotFoundError"),
    ],
)
def test_what_an_installed_package_offers_wrongly_is_said_where_a_layout_names_it(
    tmp_path: Path, install: Callable[[str, str], None], program: str, points: str, said: str
) -> None:
    install(program, points)
    with pytest.raises(LayoutError) as caught:
        open_layout(written(tmp_path))
    assert [problem.line for problem in caught.value.problems] == [5, 6]
    assert all(said in problem.message for problem in caught.value.problems)
    open_layout("minimal")  # and nobody else is disturbed


def test_names_of_rune_stay_runes(tmp_path: Path, install: Callable[[str, str], None]) -> None:
    install(PROGRAM, "[rune.visualizers]\nvisualizeLabel = rune_dummy:Shown\n")
    layout = open_layout(written(tmp_path, function="visualizeLabel", handler="widgetStop"))
    assert layout.vocabulary.visualizers["visualizeLabel"].__name__ == "Label"
