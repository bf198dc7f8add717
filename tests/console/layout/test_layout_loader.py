"""Reading layouts: what good files mean, and that anything else is refused in words."""

from __future__ import annotations

import os
import random
import re
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rune_tui.errors import LayoutError, LayoutProblem
from rune_tui.layout import loader
from rune_tui.layout.loader import LARGEST_FILE, load_layout
from rune_tui.layout.spec import CapabilitySpec, EventSpec, LayoutSpec
from rune_tui.startup.opening import BUILT_IN, open_layout
from tests.support.layouts import relax_ng
from tests.support.repetitions import repetitions

LAYOUTS = Path(__file__).parents[3] / "layouts"
GOOD = sorted(LAYOUTS.glob("*.xml"))

FULL = """\
<rune run="7">
  <robot name="magellan" hub="ipc:///run/rune/central">
    <capability name="VIS_VID" interval_ms="100"/>
  </robot>
  <robot name="blimp" hub="tcp://[::1]:1391"
    ><capability name="NAV_STATE"/><capability name="NAV_MOVE"/></robot>
  <view xsize="160" ysize="96" background="#20C040">
    <viewport name="camera" robot="blimp" visible="false" transparency="255" xpos="-10" ypos="90"
              zpos="-3" xsize="40" ysize="20" fit="fixed">
      <widget handler="widgetSetSpeed">
        <event key="plus" control="rotate" value="-0.5"/>
        <option name="linear" value="0.25"/>
      </widget>
      <visualizer function="visualizeRangeData" message="GCM_RobotState" option="2.5"/>
    </viewport>
    <widget handler="widgetQuit"><event key="ctrl+q"/></widget>
  </view>
</rune>
"""
SHORT = """\
<rune>
  <robot name="magellan">
    <capability name="VIS_VID"/><capability name="NAV_MOVE"/>
  </robot>
  <view xsize="80" ysize="48">
    <viewport name="camera" xpos="0" ypos="0" xsize="80" ysize="48">
      <visualizer function="visualizeCameraImage"/>
      <widget handler="widgetStop"><event key="space"/></widget>
    </viewport>
  </view>
</rune>
"""
STICK = """\
<rune>
  <robot name="magellan"><capability name="VIS_PTZ"/><capability name="NAV_MOVE"/></robot>
  <joystick name="pad" vid="046d" pid="c215" serial="7" device="Logi*">
    <control name="one" type="axis" usage="y" calibrate="true" min="0" max="9" deadzone="0.1"/>
    <control name="two" type="axis" role="twist" invert="true" expo="0.3"/>
    <control name="pov" type="hat switch" index="0">
      <hatSwitchBindings up="0" right="2" down="4" left="6"/>
    </control>
    <control name="wheel" type="ball" usage="wheel"/>
  </joystick>
  <view xsize="80" ysize="48">
    <viewport name="camera" xpos="0" ypos="0" xsize="80" ysize="48">
      <widget handler="widgetSetSpeed">
        <event joystick="pad" axis="one" control="translate"/>
        <event joystick="pad" axis="two" control="rotate" value="-1"/>
        <event joystick="pad" button="leftshoulder" control="enable"/>
      </widget>
      <widget handler="widgetAdjustPanTilt"><event joystick="pad" hat="pov"/></widget>
      <widget handler="widgetAdjustZoom"><event joystick="pad" ball="wheel"/></widget>
    </viewport>
  </view>
</rune>
"""
PARTED = """\
<rune run="${run}">
  <variable name="run" value="3"/>
  <variable name="wide" value="80"/>
  <font name="large" size="${run}0"/>
  <robot name="magellan"><include file="part.xml"/></robot>
  <view xsize="${wide}" ysize="48">
    <viewport name="a" xpos="0" ypos="0" xsize="${wide}" ysize="48">
      <visualizer function="visualizeLabel" text="run ${run}" font="large"/>
    </viewport>
  </view>
</rune>
"""
PART = """\
<part>
  <variable name="much" value="10"/>
  <capability name="VIS_VID" interval_ms="${much}"/>
  <capability name="NAV_MOVE"/>
</part>
"""


def load(tmp_path: Path, content: str | bytes) -> LayoutSpec:
    path = tmp_path / "layout.xml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return load_layout(path, BUILT_IN)


def problems_of(path: Path) -> tuple[LayoutProblem, ...]:
    with pytest.raises(LayoutError) as caught:
        open_layout(path)
    return caught.value.problems


def problems(tmp_path: Path, content: str | bytes) -> tuple[LayoutProblem, ...]:
    with pytest.raises(LayoutError) as caught:
        load(tmp_path, content)
    return caught.value.problems


def load_or_problems(tmp_path: Path, content: bytes) -> LayoutSpec | tuple[LayoutProblem, ...]:
    try:
        return load(tmp_path, content)
    except LayoutError as error:
        return error.problems


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_the_layouts_that_come_with_rune_load(path: Path):
    assert open_layout(path).path == str(path)
    assert open_layout(str(path)) == open_layout(path)


def test_every_value_of_a_file_arrives(tmp_path: Path):
    layout = load(tmp_path, FULL)
    assert layout.run_number == 7
    assert [robot.hub for robot in layout.robots] == ["ipc:///run/rune/central", "tcp://[::1]:1391"]
    assert layout.robot("magellan").capabilities == (
        CapabilitySpec(name="VIS_VID", interval_s=0.1),
    )
    assert layout.view.background == (0x20, 0xC0, 0x40)
    (viewport,) = layout.view.viewports
    (arrangement,) = layout.view.arrangements
    (place,) = arrangement.places
    assert (viewport.robot, place.visible, place.transparency) == ("blimp", False, 255)
    assert (place.xpos, place.ypos, place.zpos) == (-10, 90, -3)
    assert (place.xsize, place.ysize, place.scaled) == (40, 20, False)
    assert viewport.visualizer is not None
    assert viewport.visualizer.option == 2.5
    (widget,) = viewport.widgets
    given = {"linear": 0.25, "angular": 1.0, "turbo_factor": 2.0}
    usual = {
        "strafe": 0.0,
        "climb": 0.3,
        "tilt": 0.5,
        "step": 0.05,
        "turn_step_deg": 5.0,
        "fine": 0.2,
    }
    assert widget.options.values == given | usual
    assert widget.events == (EventSpec(name="+", control="rotate", value=-0.5, line=11),)
    assert [widget.handler for widget in layout.view.widgets] == ["widgetQuit"]


def test_a_joystick_with_all_that_one_may_have_is_a_layout(tmp_path: Path):
    (joystick,) = load(tmp_path, STICK).joysticks
    names = ["one", "two", "pov", "wheel", "leftshoulder"]
    assert [control.name for control in joystick.controls] == names


def test_what_a_file_leaves_out_has_its_default(tmp_path: Path):
    layout = load(tmp_path, SHORT)
    assert layout.run_number == 0
    (robot,) = layout.robots
    assert robot.hub == f"hub://?{robot.name}"
    assert [capability.interval_s for capability in robot.capabilities] == [0.01, 0.0]
    assert layout.view.background is None
    (viewport,) = layout.view.viewports
    (arrangement,) = layout.view.arrangements
    (place,) = arrangement.places
    assert (viewport.robot, place.visible, place.transparency) == ("magellan", True, 0)
    assert (place.zpos, place.scaled) == (0, True)
    assert viewport.visualizer is not None
    assert (viewport.visualizer.message, viewport.visualizer.option) == ("GCM_Common_Image", 0.0)
    assert viewport.visualizer.text == ""
    assert viewport.widgets[0].events == (EventSpec(name="space", control="", value=1.0, line=8),)


def test_the_demo_drives_with_letters_arrows_and_a_stick_and_says_its_keys():
    layout = open_layout(LAYOUTS / "demo.xml")
    camera = layout.view.viewports[0]
    bound = {
        handler: [event.name for widget in found for event in widget.events]
        for handler in ("widgetSetSpeed", "widgetStop")
        if (found := [widget for widget in camera.widgets if widget.handler == handler])
    }
    keys = ["w", "s", "a", "d", "up", "down", "left", "right"]
    assert bound["widgetSetSpeed"] == [*keys, "joystick pad lefty", "joystick pad leftx"]
    assert bound["widgetStop"] == ["space", "joystick pad b"]
    (arrangement,) = layout.view.arrangements
    status = next(one for one in arrangement.places if one.viewport == "status")
    assert (status.xpos, status.ypos, status.xsize, status.ysize) == (0, 94, 160, 2)
    label = next(one for one in layout.view.viewports if one.name == "help").visualizer
    assert label is not None
    for word in ("WASD", "IJKL", "+ -", "H ahead", "Space STOP", "Q quit"):
        assert word in label.text


def test_a_byte_order_mark_is_no_mistake(tmp_path: Path):
    assert load(tmp_path, b"\xef\xbb\xbf" + SHORT.encode()).run_number == 0


def test_comments_and_instructions_change_nothing(tmp_path: Path):
    noted = SHORT.replace('<view xsize="80"', '<!-- x --><?note y?><view xsize="80"')
    assert load(tmp_path, noted).view == load(tmp_path, SHORT).view


def test_all_problems_come_in_the_order_of_lines(tmp_path: Path):
    broken = SHORT.replace("widgetStop", "widgetStopp").replace("VIS_VID", "VIS_VIDEO")
    found = problems(tmp_path, broken.replace('xsize="80" ysize="48">\n    <v', 'ysize="48"><v'))
    assert [problem.line for problem in found] == sorted(problem.line for problem in found)
    assert len(found) == 3


@pytest.mark.parametrize(
    ("make", "part"),
    [
        (lambda _: None, "there is no such file"),
        (lambda path: path.mkdir(), "this is a directory"),
        (os.mkfifo, "this is not a regular file"),
        (lambda path: path.symlink_to(path), "the file cannot be read"),
        (lambda path: path.write_bytes(b""), "the file is empty"),
        (lambda path: path.write_bytes(b" \n"), "the file is empty"),
        (lambda path: path.write_bytes(b"<" * (LARGEST_FILE + 1)), "larger than 1048576 bytes"),
    ],
    ids=["missing", "directory", "pipe", "loop", "empty", "blank", "large"],
)
def test_a_file_that_is_none_is_refused_as_a_whole(tmp_path: Path, make, part: str):
    path = tmp_path / "layout.xml"
    make(path)
    with pytest.raises(LayoutError) as caught:
        open_layout(path)
    (problem,) = caught.value.problems
    assert part in problem.message
    assert (problem.path, problem.line) == (str(path), 0)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_is_refused(tmp_path: Path):
    path = tmp_path / "layout.xml"
    path.write_text(SHORT)
    path.chmod(0)
    with pytest.raises(LayoutError, match="may not be read; check its permissions"):
        open_layout(path)


@pytest.mark.parametrize("path", ["a\0b", "\ud800", "x" * 5000])
def test_what_is_no_path_is_refused(path: str):
    with pytest.raises(LayoutError):
        open_layout(path)


def test_a_file_of_the_largest_size_is_read(tmp_path: Path):
    padded = SHORT + " " * (LARGEST_FILE - len(SHORT))
    assert load(tmp_path, padded).view == load(tmp_path, SHORT).view


@pytest.mark.parametrize(
    "prolog",
    [
        "<!DOCTYPE rune>",
        "\ufeff<!DOCTYPE rune>",
        '<!DOCTYPE rune SYSTEM "file:///etc/passwd">',
        '<?xml version="1.0"?>\n<!-- a -->\n<!DOCTYPE rune [<!ENTITY a "b">]>',
        '<!DOCTYPE rune [<!ENTITY a SYSTEM "/etc/passwd">]>',
    ],
)
def test_document_types_never_reach_the_parser(tmp_path: Path, prolog: str, monkeypatch):
    def parse(*_args: object) -> None:
        pytest.fail("parsed")

    monkeypatch.setattr("rune_tui.layout.loader.etree.fromstring", parse)
    (problem,) = problems(tmp_path, prolog + SHORT)
    assert "document type" in problem.message
    assert problem.line == prolog.count("\n") + 1


def test_a_document_type_in_a_comment_is_a_comment(tmp_path: Path):
    assert load(tmp_path, "<!-- <!DOCTYPE rune> -->" + SHORT).run_number == 0


@pytest.mark.parametrize(
    "content",
    [
        "<!---->" * 140_000 + "x",
        "<?a ?>" * 170_000,
        "<rune>" * 170_000,
        "<rune>" + "<view>" * 200 + "</view>" * 200 + "</rune>",
        "<rune " + " ".join(f"a{number}='1'" for number in range(30_000)) + "/>",
        f"<rune run='{'0' * 900_000}'/>",
        f"<rune><robot name='{'a ' * 500_000}'/></rune>",
    ],
    ids=["comments", "instructions", "unclosed", "deep", "attributes", "zeros", "name"],
)
@pytest.mark.timeout(60)
def test_a_hostile_file_is_refused_soon(tmp_path: Path, content: str):
    assert problems(tmp_path, content)


MUTATIONS = [
    *("<", ">", "/", "&", "&amp;", "&#0;", "&#27;", '"', "<!--", "-->", "<?x ?>", "<![CDATA[x]]>"),
    *("xmlns='u:x'", " xmlns:a='b'", " a:x='1'", " xml:lang='x'", "<robot/>", "<view/>", "&a;"),
    *("<event key='w'/>", "<!DOCTYPE r [<!ENTITY a 'b'>]>", "\n", "\r\n", "\t", "\x9b", "\ufeff"),
]
VALUES = [
    *("true", "TRUE", " 1 ", "+1", "1e3", "NaN", "INF", "-0", "0" * 30 + "1", ".", "1.", "9" * 40),
    *("", " ", "w", "up", "plus", "rotate", "widgetStop", "VIS_VID", "magellan", "ipc://x", "é"),
    *("tcp://h:1", "#00ff00", "fixed", "visualizeLabel", "GCM_CameraState", "x" * 300, "\u202e"),
    *("${x}", "a ${x} b ${y}", "${", "${}", "$x"),
]


def mutated(text: str, chance: random.Random) -> bytes:
    """A layout with a few changes: values, elements, characters and bytes."""
    for _ in range(chance.choice([1, 1, 1, 2, 3, 6])):
        place = chance.randrange(len(text))
        values = list(re.finditer(r'"[^"]*"', text)) or [re.match("", text)]
        tags = list(re.finditer(r"<[^<>]*>", text)) or [re.match("", text)]
        value, element, other = chance.choice(values), chance.choice(tags), chance.choice(tags)
        match chance.randrange(7):
            case 0:
                text = text[:place] + chance.choice(MUTATIONS) + text[place:]
            case 1:
                text = text[:place] + text[place + chance.choice([1, 5, 40]) :]
            case 2 | 3 | 4:
                new = chance.choice(VALUES)
                text = f'{text[: value.start()]}"{new}"{text[value.end() :]}'
            case 5:
                swap = chance.choice(["", other.group(), element.group() * 2])
                text = text[: element.start()] + swap + text[element.end() :]
            case 6:
                text = text[:place] + chr(chance.randrange(0x250)) + text[place + 1 :]
        text = text or "<"
    data = text.encode()
    if chance.random() < 0.1:
        place = chance.randrange(len(data))
        data = data[:place] + bytes([chance.randrange(256)]) + data[place + 1 :]
    return data


def test_a_changed_layout_is_a_layout_or_a_layout_error_with_printable_problems(tmp_path: Path):
    chance, count = random.Random(0), repetitions(200, 8000)
    texts = [path.read_text() for path in GOOD] + [FULL, SHORT, STICK, PARTED]
    read, refused = 0, 0
    for _ in range(count):
        part = mutated(PART, chance) if chance.random() < 0.5 else PART.encode()
        (tmp_path / "part.xml").write_bytes(part)
        found = load_or_problems(tmp_path, mutated(chance.choice(texts), chance))
        if isinstance(found, LayoutSpec):
            read += 1
        else:
            refused += 1
            assert found
            assert [one.message for one in found if not one.message.isprintable()] == []
    assert min(read, refused) >= count // 200


@given(data=st.binary(max_size=300) | st.text(max_size=300).map(lambda text: text.encode()))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_are_refused_with_a_layout_error(tmp_path: Path, data: bytes):
    assert problems(tmp_path, data)


def test_the_rules_read_from_the_schema_refuse_what_the_schema_refuses():
    chance = random.Random("agreement")
    texts = [path.read_text() for path in GOOD] + [FULL, SHORT]
    rules, validator = loader.schema_rules(), relax_ng()
    verdicts = []
    count = repetitions(150, 5000)
    for _ in range(count):
        try:
            text = loader.decode(mutated(chance.choice(texts), chance), "layout.xml")
            document = loader.parse(text, "layout.xml")
        except LayoutError:
            continue
        if document.tag != "rune":
            continue
        followed = not list(rules.mistakes(loader.to_node(document, text, "layout.xml")))
        assert followed == validator.validate(document), text
        verdicts.append(followed)
    assert count // 20 < sum(verdicts) < len(verdicts) - count // 20


def traced(work: Callable[[], object]) -> int:
    """The most memory that something takes at once, of what Python hands out [bytes]."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_a_file_of_50_mb_is_refused_before_it_is_read(tmp_path: Path):
    path = tmp_path / "layout.xml"
    with path.open("wb") as file:
        file.write(SHORT.encode())
        file.truncate(50_000_000)
    include = tmp_path / "include.xml"
    include.write_text(SHORT.replace("<view", '<include file="layout.xml"/><view'))
    problems_of(include)  # what is kept for all layouts is made by the first
    for name in ("layout.xml", "include.xml"):
        found: list[LayoutProblem] = []
        taken = traced(lambda name=name, found=found: found.extend(problems_of(tmp_path / name)))
        assert "larger than 1048576 bytes" in found[0].message
        assert taken < 4 * LARGEST_FILE


@pytest.mark.parametrize(
    "content",
    [
        "<rune>" + "<a/>" * 30_000 + "</rune>",
        "<rune>" + "<a/>" * 800 + "</rune>",
        "<rune " + " ".join(f"a{number}='1'" for number in range(4_000)) + "/>",
        "<rune>" + "<!---->" * 40_000 + "</rune>",
    ],
    ids=["too many elements", "elements", "attributes", "comments"],
)
def test_the_memory_that_a_file_takes_is_bounded_by_its_size(tmp_path: Path, content: str):
    assert traced(lambda: problems(tmp_path, content)) < 300 * LARGEST_FILE


def test_a_file_of_very_many_elements_is_refused_as_a_whole(tmp_path: Path):
    (problem,) = problems(tmp_path, "<rune>" + "<a/>" * 20_000 + "</rune>")
    assert "more than 20000 elements" in problem.message


def test_an_older_spelling_works_and_is_noted(tmp_path: Path):
    widget = """<widget handler="widgetTheme"><option name="theme" value="night"/>
      <event key="n"/></widget>"""
    layout = load(
        tmp_path, SHORT.replace("<view ", "<view ", 1).replace("</view>", f"{widget}</view>")
    )
    assert layout.view.widgets[-1].options.word("theme") == "red"
    (note,) = layout.notes
    assert 'the theme night is now called red; write value="red"' in note
