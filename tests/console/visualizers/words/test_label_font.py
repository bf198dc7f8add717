"""Labels in letters of a font of the layout."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rune_tui.compositor.cells import Cells
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState
from rune_tui.raster.canvas import Canvas
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from rune_tui.visualizers.words.label import Label
from tests.console.states import rendered, robot_of

LAYOUT = """<rune>
  <font name="large" size="{size}"/>
  <robot name="magellan"/>
  <view xsize="120" ysize="80">
    <viewport name="words" xpos="0" ypos="0" xsize="120" ysize="80">
      <visualizer function="visualizeLabel" text="{text}"{font}/>
    </viewport>
  </view>
</rune>
"""


def drawn(folder: Path, *, size: int = 16, text: str = "Rune", font: str = "large") -> Cells:
    path = folder / "layout.xml"
    named = f' font="{font}"' if font else ""
    path.write_text(LAYOUT.format(size=size, text=text, font=named))
    view = View(open_layout(path))
    view.resize(120, 40)
    cells = rendered(
        view,
        {
            "magellan": robot_of(
                name="magellan", link=LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
            )
        },
        ConsoleState(now=1.0),
    )
    assert cells is not None
    return cells


def lit(cells: Cells) -> np.ndarray:
    """Rows of pixels in which something is drawn."""
    return np.flatnonzero(cells.pixels[..., :3].any(axis=(1, 2)))


def test_a_label_with_a_font_is_pixels_and_one_without_is_characters(tmp_path: Path) -> None:
    large = drawn(tmp_path)
    assert not large.glyphs.any()
    assert len(lit(large)) > 5
    assert drawn(tmp_path, font="").glyphs.any()


def test_a_larger_size_is_larger(tmp_path: Path) -> None:
    small, large = lit(drawn(tmp_path, size=12)), lit(drawn(tmp_path, size=36))
    assert np.ptp(large) > 2 * np.ptp(small)


def test_long_words_go_on_in_the_next_line(tmp_path: Path) -> None:
    one, two = lit(drawn(tmp_path, text="Rune")), lit(drawn(tmp_path, text="Rune " * 5))
    assert np.ptp(two) > 1.5 * np.ptp(one)


def test_a_layout_chooses_the_colour_of_a_text_by_its_meaning(tmp_path: Path) -> None:
    path = tmp_path / "colour.xml"
    label = LAYOUT.format(size=16, text="Rune", font="").replace("/>\n    </viewport>", "{}")
    link = LinkState(phase=LinkPhase.CONNECTED, since=0.0, endpoint="")
    robot = robot_of(name="magellan", link=link)
    inks = []
    for colour in ("usual", "alarm", "good"):
        option = f'><option name="colour" value="{colour}"/></visualizer>\n    </viewport>'
        path.write_text(label.format(option))
        (viewport,) = open_layout(path).view.viewports
        drawing = Label.from_spec(viewport.visualizer)
        canvas = Canvas.blank(40, 4)
        drawing.draw(canvas, robot, ConsoleState(now=1.0))
        inks.append(tuple(canvas.ink[0, 0][:3]))
    theme = ConsoleState(now=1.0).theme
    assert inks == [theme.soft[:3], theme.alarm_ink[:3], theme.good[:3]]
