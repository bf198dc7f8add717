"""Parts and variables: layouts that share what they have in common and differ in what they say."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from rune_tui.cli import main
from rune_tui.errors import LayoutError
from rune_tui.layout.loader import LARGEST_FILE
from rune_tui.layout.parts import DEEPEST, MOST
from rune_tui.layout.spec import LayoutSpec
from rune_tui.startup.opening import open_layout

PAGE = Path(__file__).parents[3] / "docs" / "layout-reference.md"
ROBOT = '<robot name="magellan"><capability name="NAV_STATE"/><capability name="NAV_MOVE"/></robot>'
VIEW = '<view xsize="80" ysize="48"><include file="status.xml"/></view>'
STATUS = """<part>
  <viewport name="status" xpos="0" ypos="0" xsize="80" ysize="2">
    <visualizer function="visualizeStatus"/>
  </viewport>
</part>"""


def put(folder: Path, **files: str) -> Path:
    """Write files of these names into a folder; the path of the one called layout."""
    for name, text in files.items():
        (folder / f"{name}.xml").write_text(text)
    return folder / "layout.xml"


def refused(path: Path, **variables: str) -> list[str]:
    """What is wrong, each with its place, without the folder's name."""
    with pytest.raises(LayoutError) as caught:
        open_layout(path, variables)
    return [str(problem).replace(f"{path.parent}/", "") for problem in caught.value.problems]


def label(layout: LayoutSpec) -> str:
    (viewport,) = layout.view.viewports
    assert viewport.visualizer is not None
    return viewport.visualizer.text


def test_the_example_of_the_page_differs_in_one_attribute(tmp_path: Path) -> None:
    part, subject = [text.split("```")[0] for text in PAGE.read_text().split("\n```xml\n")[2:4]]
    (tmp_path / "experiment.xml").write_text(part)
    (tmp_path / "one.xml").write_text('<rune><include file="experiment.xml"/></rune>')
    (tmp_path / "three.xml").write_text(subject)
    one, three = open_layout(tmp_path / "one.xml"), open_layout(tmp_path / "three.xml")
    assert (one.run_number, three.run_number) == (0, 3)
    assert one.robots == three.robots
    assert [place.transparency for place in one.view.arrangements[0].places] == [0, 96]
    assert [place.transparency for place in three.view.arrangements[0].places] == [0, 200]
    assert three.files == (tmp_path / "three.xml", tmp_path / "experiment.xml")


def test_a_part_may_stand_in_every_element_that_holds_others(tmp_path: Path) -> None:
    path = put(
        tmp_path,
        layout="""<rune><include file="outer.xml"/>
          <view xsize="80" ysize="48"><include file="viewport.xml"/></view></rune>""",
        outer='<part><include file="robot.xml"/></part>',
        robot='<part><robot name="m"><include file="wanted.xml"/></robot></part>',
        wanted='<part><capability name="NAV_MOVE"/><capability name="NAV_STATE"/></part>',
        viewport="""<part><viewport name="v" xpos="0" ypos="0" xsize="80" ysize="48">
          <include file="shown.xml"/><include file="drive.xml"/></viewport></part>""",
        shown="""<part><visualizer function="visualizeRangeData"/></part>""",
        drive='<part><widget handler="widgetSetSpeed"><include file="keys.xml"/></widget></part>',
        keys="""<part><option name="linear" value="0.2"/>
          <event key="w" control="translate"/></part>""",
    )
    layout = open_layout(path)
    assert [one.name for one in layout.robots[0].capabilities] == ["NAV_MOVE", "NAV_STATE"]
    (viewport,) = layout.view.viewports
    assert viewport.visualizer is not None
    assert viewport.widgets[0].options.number("linear") == 0.2
    assert [event.name for event in viewport.widgets[0].events] == ["w"]
    assert len(layout.files) == 8


LABEL = """<part><variable name="word" value="part"/>
  <viewport name="${name}" xpos="0" ypos="0" xsize="80" ysize="48">
    <visualizer function="visualizeLabel" text="say ${word}, ${word}"/>
  </viewport></part>"""


@pytest.mark.parametrize(
    ("own", "given", "said"),
    [
        ("", {}, "say part, part"),
        ('<variable name="word" value="layout"/>', {}, "say layout, layout"),
        ('<variable name="word" value="layout"/>', {"word": "set"}, "say set, set"),
        ("", {"word": "set"}, "say set, set"),
        ("", {"word": "a < & >"}, "say a < & >, a < & >"),
    ],
)
def test_the_outer_value_of_a_variable_wins(
    tmp_path: Path, own: str, given: dict[str, str], said: str
) -> None:
    view = """<view xsize="80" ysize="48"><include file="label.xml">
      <variable name="name" value="v"/></include></view>"""
    path = put(tmp_path, layout=f"<rune>{own}{ROBOT}{view}</rune>", label=LABEL)
    assert label(open_layout(path, given)) == said


def test_a_part_included_twice_has_values_of_its_own_each_time(tmp_path: Path) -> None:
    def include(name: str, word: str) -> str:
        return f"""<include file="label.xml"><variable name="name" value="{name}"/>
          <variable name="word" value="{word}"/></include>"""

    view = f'<view xsize="80" ysize="48">{include("a", "one")}{include("b", "two")}</view>'
    path = put(tmp_path, layout=f"<rune>{ROBOT}{view}</rune>", label=LABEL)
    texts = {
        viewport.name: viewport.visualizer.text
        for viewport in open_layout(path).view.viewports
        if viewport.visualizer
    }
    assert texts == {"a": "say one, one", "b": "say two, two"}


def test_the_name_of_a_part_may_be_a_variable(tmp_path: Path) -> None:
    text = f"""<rune>{ROBOT}<variable name="what" value="status"/>
      <view xsize="80" ysize="48"><include file="${{what}}.xml"/></view></rune>"""
    path = put(tmp_path, layout=text, status=STATUS, other="<part/>")
    assert len(open_layout(path).view.viewports) == 1
    assert open_layout(path, {"what": "other"}).view.viewports == ()


def test_mistakes_of_all_files_come_at_once_each_with_its_own_place(tmp_path: Path) -> None:
    path = put(
        tmp_path,
        layout=f'<rune rum="1">\n  {ROBOT}\n  {VIEW}\n</rune>',
        status=STATUS.replace("visualizeStatus", "visualizeStaus").replace("<part>", "<part a='b'>")
        .replace('"80"', '"wide"'),
    )  # fmt: skip
    assert [line.partition(": ")[0] for line in refused(path)] == [
        "layout.xml:1:7",
        "status.xml:1:7",
        "status.xml:2:45",
        "status.xml:3:17",
    ]


def test_what_is_there_twice_names_the_other_file(tmp_path: Path) -> None:
    own = """<viewport name="status" xpos="0" ypos="0" xsize="9" ysize="9"/>"""
    view = VIEW.replace("</view>", f"\n{own}</view>")
    path = put(tmp_path, layout=f"<rune>{ROBOT}{view}</rune>", status=STATUS)
    (problem,) = refused(path)
    assert "is already in line 2 of " in problem
    assert "status.xml; give each viewport a name" in problem


@pytest.mark.parametrize(
    ("variables", "text", "expected"),
    [
        ("", "${word}", ["layout.xml:2:57: unknown variable 'word'"]),
        (
            '<variable name="word" value="a"/>',
            "${word} ${wrod}",
            ["layout.xml:2:57: unknown variable 'wrod'; did you mean 'word'? (allowed: word)"],
        ),
        (
            '<variable name="word" value="a"/>',
            "word",
            ["layout.xml:1:17: the variable 'word' is used nowhere; remove it"],
        ),
        (
            '<variable name="word" value="a"/><variable name="word" value="b"/>',
            "${word}",
            ["layout.xml:1:50: the variable 'word' is already in line 1"],
        ),
        (
            '<variable name="word" value="${word}"/>',
            "${word}",
            ["layout.xml:1:29: the value of variable 'word' may not use variables itself"],
        ),
        (
            '<variable name="1" value="a"/>',
            "",
            ["layout.xml:1:17: name of <variable> is '1', it must be a letter, and up to 39"],
        ),
        ("", "${", ["layout.xml:2:57: '${' begins the name of a variable, such as ${name}"]),
        ("", "${a b}", ["layout.xml:2:57: '${' begins the name of a variable"]),
    ],
)
def test_a_variable_that_is_wrong_is_refused(
    tmp_path: Path, variables: str, text: str, expected: list[str]
) -> None:
    view = f"""<view xsize="80" ysize="48"><viewport xpos="0" ypos="0" name="a{text}" xsize="9"
      ysize="9"/></view>"""
    path = put(tmp_path, layout=f"<rune>{variables}\n{view}{ROBOT}</rune>")
    for problem, begin in zip(refused(path), expected, strict=True):
        assert problem.startswith(begin)


def test_setting_what_is_no_variable_is_refused(tmp_path: Path) -> None:
    text = f'<rune run="${{run}}"><variable name="run" value="1"/>{ROBOT}{VIEW}</rune>'
    path = put(tmp_path, layout=text, status=STATUS)
    assert open_layout(path, {"run": "7"}).run_number == 7
    assert refused(path, rum="7") == [
        "layout.xml: the layout has no variable 'rum' to be set; did you mean 'run'? (allowed: run)"
    ]
    assert refused(path, run="${run}")[0] == (
        "layout.xml: the value of variable 'run' may not use variables itself"
    )
    assert refused(path, run="x") == [
        "layout.xml:1:7: run of <rune> is 'x', it must be a whole number from 0 to 999999; "
        "that is from --set run=x"
    ]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("/etc/passwd", "is not in the layout's folder or below it"),
        ("../status.xml", "is not in the layout's folder or below it"),
        ("below/../status.xml", "is not in the layout's folder or below it"),
        ("..\\status.xml", "is not in the layout's folder or below it"),
        ("outside.xml", "is not in the layout's folder or below it"),
        ("gone.xml", "there is no such file"),
        ("x" * 200, "there is no such file"),
        ("\N{ROBOT FACE}" * 200, "the file cannot be read"),
        ("below", "this is a directory"),
        ("pipe.xml", "this is not a regular file"),
        ("layout.xml", "includes itself"),
        ("loop.xml", "is not in the layout's folder or below it"),
        ("whole.xml", "the outermost element of a part is <part>, not <rune>"),
        ("torn.xml", "this is not well-formed XML"),
        ("typed.xml", "a document type"),
    ],
)
def test_a_file_that_is_no_part_is_refused(tmp_path: Path, name: str, said: str) -> None:
    folder = tmp_path / "folder"
    (folder / "below").mkdir(parents=True)
    (tmp_path / "status.xml").write_text(STATUS)
    (folder / "outside.xml").symlink_to(tmp_path / "status.xml")
    (folder / "loop.xml").symlink_to(folder / "loop.xml")
    os.mkfifo(folder / "pipe.xml")
    path = put(
        folder,
        layout=f'<rune>{ROBOT}<view xsize="80" ysize="48"><include file="{name}"/></view></rune>',
        whole="<rune/>",
        torn="<part>",
        typed="<!DOCTYPE part [<!ENTITY a 'b'>]><part/>",
    )
    (problem,) = refused(path)
    assert said in problem


def test_parts_that_include_each_other_are_refused(tmp_path: Path) -> None:
    path = put(
        tmp_path,
        layout=f'<rune>{ROBOT}<view xsize="8" ysize="8"/><include file="a.xml"/></rune>',
        a='<part><include file="b.xml"/></part>',
        b='<part><include file="a.xml"/></part>',
    )
    assert refused(path) == ["b.xml:1:16: the part 'a.xml' includes itself"]


def test_parts_are_taken_in_only_so_deep(tmp_path: Path) -> None:
    chain = {f"p{n}": f'<part><include file="p{n + 1}.xml"/></part>' for n in range(DEEPEST + 3)}
    chain[f"p{DEEPEST - 1}"] = "<part/>"
    text = f'<rune>{ROBOT}<view xsize="8" ysize="8"/><include file="p0.xml"/></rune>'
    path = put(tmp_path, layout=text, **chain)
    assert len(open_layout(path).files) == DEEPEST + 1
    put(tmp_path, **{f"p{DEEPEST - 1}": f'<part><include file="p{DEEPEST}.xml"/></part>'})
    assert refused(path) == [
        f"p{DEEPEST - 1}.xml:1:16: parts are included more than {DEEPEST} deep"
    ]


def test_parts_that_multiply_end_at_a_number(tmp_path: Path) -> None:
    nine = "<part>" + '<include file="p{}.xml"/>' * 9 + "</part>"
    levels = {f"p{n}": nine.replace("{}", str(n + 1)) for n in range(7)}
    text = f'<rune>{ROBOT}<view xsize="8" ysize="8"/><include file="p0.xml"/></rune>'
    path = put(tmp_path, layout=text, **levels, p7="<part/>")
    problems = refused(path)
    assert len(problems) == 1
    assert f"more than {MOST} parts are included" in problems[0]


@pytest.mark.parametrize(
    ("variable", "part"),
    [
        ("", f"<part>{' ' * (LARGEST_FILE // 3)}</part>"),
        ("v" * 1000, "<part>" + f"<event key='{'${v}' * 8}'/>" * 100 + "</part>"),
    ],
    ids=["files", "variables"],
)
def test_all_files_and_values_together_are_no_larger_than_one(
    tmp_path: Path, variable: str, part: str
) -> None:
    own = f'<variable name="v" value="{variable}"/>' if variable else ""
    view = '<view xsize="8" ysize="8">' + "<include file='a.xml'/>" * 9 + "</view>"
    path = put(tmp_path, layout=f"<rune>{own}{ROBOT}{view}</rune>", a=part)
    problems = [one for one in refused(path) if "with its parts and variables is larger" in one]
    assert len(problems) == 1


def test_a_part_cannot_be_opened(tmp_path: Path) -> None:
    assert refused(put(tmp_path, layout=STATUS)) == [
        "layout.xml:1:1: this is a part of layouts; open one that includes it, not <part>"
    ]


def test_variables_are_set_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = f'<rune run="${{run}}"><variable name="run" value="1"/>{ROBOT}{VIEW}</rune>'
    path = str(put(tmp_path, layout=text, status=STATUS))
    assert main(["check", path, "--set", "run=12"]) is ExitCode.OK
    assert main(["check", path, "--set", "run=twelve"]) is ExitCode.USAGE
    said = capsys.readouterr().err
    assert "run of <rune> is 'twelve'" in said
    assert said.endswith("; that is from --set run=twelve\n")
    assert said.count("--set") == 1
    with pytest.raises(SystemExit):
        main(["check", path, "--set", "run"])
    assert "'run' is no NAME=VALUE" in capsys.readouterr().err
