"""`rune run --watch`: the picture follows the file, and a slip of the pen takes nothing away."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path

from tests.system.conftest import LAYOUT
from tests.system.harness import ConsoleProcess, HubProcess

LABEL = """<viewport name="words" fit="fixed" xpos="0" ypos="4" zpos="9" xsize="40" ysize="2">
      <visualizer function="visualizeLabel" text="{text}"/>
    </viewport>
  </view>"""

NEXT = """from rune_tui.layout.rules import HandlerRule
from rune_tui.model.effects import NextLayoutEffect
from rune_tui.widgets.widget import PressWidget


class Next(PressWidget):
    rule = HandlerRule(meaning="opens the next layout", needs_robot=False)

    def press(self, event, event_spec, state):
        return (NextLayoutEffect(),)


WIDGETS = {"widgetNext": Next}
"""


def test_a_layout_is_followed_while_it_is_saved_and_the_next_is_opened(
    lasting_hub: HubProcess, tmp_path: Path, stack: ExitStack
) -> None:
    path, other = tmp_path / "layout.xml", tmp_path / "other.xml"
    (tmp_path / "next.py").write_text(NEXT)

    def save(text: str, *, bad: bool = False) -> None:
        whole = LAYOUT.format(hub=lasting_hub.endpoint)
        whole = whole.replace("</view>", LABEL.format(text=text))
        whole = whole.replace("<robot name", '<extension file="next.py"/>\n  <robot name', 1)
        key = '<view xsize="100" ysize="60"><widget handler="widgetNext"><event key="n"/></widget>'
        whole = whole.replace('<view xsize="100" ysize="60">', key)
        other.write_text(whole.replace(text, "the other layout"))
        path.write_text(whole.replace("widgetStop", "widgetStp") if bad else whole)

    save("the first words")
    console = stack.enter_context(
        closing(ConsoleProcess(["run", "--watch", str(path), str(other)]))
    )
    console.wait_for_picture()
    console.wait(lambda: "the first words" in console.text and "STANDING" in console.text, 10.0)
    save("other words")
    console.wait(lambda: "other words" in console.text, 10.0)
    assert "STANDING" in console.text, "what was known of the robot is known no more"
    save("never seen", bad=True)
    console.wait(lambda: "'widgetStp'" in console.text, 10.0)
    assert "1 problem: layout.xml:" in console.text
    save("words at last")
    console.wait(lambda: "words at last" in console.text, 10.0)
    assert "widgetStp" not in console.text
    assert console.has_picture
    console.type("n")
    console.wait(lambda: "the other layout" in console.text, 10.0)
    assert "STANDING" in console.text
    console.type("n")
    console.wait(lambda: "words at last" in console.text, 10.0)
    assert console.quit() == 0
