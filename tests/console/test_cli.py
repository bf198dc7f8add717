"""`rune` as a person types it, where it needs no terminal."""

from __future__ import annotations

import json
import logging
import sys
from contextlib import closing
from importlib.metadata import version
from pathlib import Path

import pytest
from PIL import Image

from hub.command_line import ExitCode
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.ipc.broker.central import Central
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from hub.plain_text import is_plain
from rune_tui.cli import main
from rune_tui.commands.log_file import log_to_file
from rune_tui.compositor.glyph_set import GlyphSet

LAYOUTS = Path(__file__).parents[2] / "layouts"
MINIMAL = """<rune>
  <robot name="robot"><capability name="VIS_VID"/><capability name="NAV_MOVE"/></robot>
  <view xsize="160" ysize="96">
    <widget handler="widgetQuit"><event key="q"/></widget>
    <viewport name="camera" xpos="0" ypos="0" xsize="160" ysize="96">
      <visualizer function="visualizeCameraImage"/>
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate" value="1"/>
        <event key="s" control="translate" value="-1"/>
      </widget>
    </viewport>
  </view>
</rune>
"""


def test_it_tells_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"rune {version('robot-user-nexus')}\n"


@pytest.mark.parametrize("name", ["demo", "minimal"])
def test_a_shipped_layout_is_checked_by_its_name_from_anywhere(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["check", name]) is ExitCode.OK
    assert capsys.readouterr().out == f"{name}: ok\n"


def test_a_layout_that_is_not_there_is_no_reason_to_look_for_a_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(tmp_path / "demo.xml")]) is ExitCode.USAGE
    said = capsys.readouterr().err
    assert "there is no such file" in said
    assert "such as demo" in said


def test_keys_that_not_every_terminal_tells_are_noted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    layout = tmp_path / "rare.xml"
    layout.write_text(
        MINIMAL.replace('key="w"', 'key="kp_8"').replace('key="s"', 'key="left_shift"')
    )
    assert main(["check", str(layout)]) is ExitCode.OK
    only = "only terminals with the kitty keyboard protocol tell it"
    assert capsys.readouterr().out == (
        f"{layout}: ok\n"
        f'  note: key kp_8: {only}, others report it as 8: bind "8" as well\n'
        f"  note: key left_shift: {only}, others report nothing: bind another key as well\n"
    )


@pytest.mark.parametrize("path", ["a" * 300, "a" * 5000, "nowhere/demo", "a\0b", "demo.xm"])
def test_what_is_no_path_of_a_file_is_said_to_be_none(
    path: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", path]) is ExitCode.USAGE
    assert capsys.readouterr().err.endswith("\n")


WITHOUT_PICTURES = """<rune>
  <robot name="magellan"><capability name="NAV_STATE"/><capability name="NAV_MOVE"/></robot>
  <view xsize="120" ysize="80">
    <viewport name="status" robot="magellan" xpos="0" ypos="0" xsize="120" ysize="2">
      <visualizer function="visualizeStatus"/>
      <widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget>
    </viewport>
  </view>
</rune>
"""
"""A picture that no robot sends would be waited for."""


def test_a_picture_is_drawn_of_a_robot_behind_a_gateway(tmp_path: Path) -> None:
    keyring = Keyring(tmp_path / "keys")
    gateway = curve_gateway("tcp://127.0.0.1:0", keyring)
    central = Central([f"ipc://{tmp_path}/c"], gateways=[gateway])
    with closing(central):
        picture, layout = tmp_path / "shot.txt", tmp_path / "layout.xml"
        layout.write_text(WITHOUT_PICTURES)
        where = ["--hub", central.endpoints[1], "--keys", str(keyring.make("one", Role.OBSERVE))]
        assert main(["shot", str(layout), *where, "--seconds", "1.5", "-o", str(picture)]) == 0
        assert "OBSERVER: this key may watch" in picture.read_text("utf-8")


@pytest.mark.parametrize("glyphs", [glyphs.value for glyphs in GlyphSet])
def test_a_picture_is_drawn_of_the_glyphs_asked_for(tmp_path: Path, glyphs: str) -> None:
    path = tmp_path / "shot.png"
    where = ["--hub", f"ipc://{tmp_path}/nobody", "--seconds", "0", "-o", str(path), "--offline"]
    assert main(["shot", "demo", *where, "--glyphs", glyphs]) == ExitCode.OK
    assert path.stat().st_size


@pytest.mark.parametrize("colors", ["truecolor", "256", "16", "mono"])
def test_a_picture_is_drawn_in_the_colours_asked_for(tmp_path: Path, colors: str) -> None:
    path = tmp_path / "shot.png"
    where = ["--hub", f"ipc://{tmp_path}/nobody", "--seconds", "0", "-o", str(path), "--offline"]
    assert main(["shot", "demo", *where, "--colors", colors]) == ExitCode.OK
    with Image.open(path) as picture:
        corner = picture.getpixel((1, 100))
    assert corner == {"truecolor": (24, 28, 34), "256": (28, 28, 28)}.get(colors, (0, 0, 0))


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [(["dmeo"], "did you mean 'demo'?"), (["shot", "demo", "--glyphs", "halv"], "mean 'half'?")],
)
def test_a_misspelt_word_is_answered_with_the_nearest_one(
    capsys: pytest.CaptureFixture[str], arguments: list[str], hint: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == ExitCode.USAGE
    said = capsys.readouterr().err
    assert hint in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["demo", "auto", "red"], "'red' is one argument too many; --arena chooses"),
        (["demo", "--robot", "trackd"], "did you mean 'tracked'?"),
    ],
)
def test_a_demo_says_how_to_choose_its_arena_and_robot(
    capsys: pytest.CaptureFixture[str], arguments: list[str], hint: str
) -> None:
    with pytest.raises(SystemExit):
        main(arguments)
    assert hint in capsys.readouterr().err


def test_a_picture_chooses_robot_and_arena_only_for_a_demo(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "shot.png"
    assert main(["shot", "auto", "--robot", "rov", "-o", str(path)]) == ExitCode.USAGE
    assert "add --demo" in capsys.readouterr().err
    assert not path.exists()


@pytest.mark.parametrize("words", [("demo",), ("run", "search"), ("drive", "mavlink:udp://:14550")])
def test_a_recording_that_cannot_be_made_is_refused_before_anything_starts(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    monkeypatch.setitem(sys.modules, "lz4", None)
    with pytest.raises(SystemExit) as ended:
        main([*words, "--record", "folder"])
    assert ended.value.code == ExitCode.USAGE
    said = capsys.readouterr().err
    assert "recording needs lz4" in said
    assert "pip install 'robot-user-nexus[record]'" in said


def test_without_a_command_the_commands_are_shown(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([])
    assert ended.value.code == ExitCode.USAGE
    said = capsys.readouterr().err
    assert "open the console with a layout" in said
    assert "required" not in said


def test_a_misspelt_layout_is_answered_with_the_nearest_one(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["check", "serach"]) == ExitCode.USAGE
    assert "did you mean 'search'?" in capsys.readouterr().err


def test_the_shipped_layouts_are_listed_with_what_they_are_for(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["layouts"]) == ExitCode.OK
    rows = capsys.readouterr().out.splitlines()
    assert [row.split()[0] for row in rows] == sorted(path.stem for path in LAYOUTS.glob("*.xml"))
    assert all(len(row.split()) > 3 for row in rows)
    assert main(["layouts", "--json"]) == ExitCode.OK
    listed = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {"name": "demo", "meaning": rows[0].split(maxsplit=1)[1]} in listed


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completion_knows_every_command(capsys: pytest.CaptureFixture[str], shell: str) -> None:
    assert main(["completion", shell]) == ExitCode.OK
    script = capsys.readouterr().out
    assert all(word in script for word in ("demo", "layouts", "joytest"))


def test_a_key_that_drives_and_does_something_else_is_noted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    layout = tmp_path / "both.xml"
    stop = '<widget handler="widgetStop"><event key="w"/></widget></viewport>'
    layout.write_text(MINIMAL.replace("</viewport>", stop), "utf-8")
    assert main(["check", str(layout)]) == ExitCode.OK
    assert "w wakes widgetSetSpeed and widgetStop" in capsys.readouterr().out


def test_no_name_of_a_file_commands_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = tmp_path / "p\x1b]0;PWNED\x07\u202e.xml"
    part.write_text("<part><nothing/></part>")
    included = f'<include file="{part.name.encode("ascii", "xmlcharrefreplace").decode()}"/></view>'
    for number, name in enumerate((part, tmp_path / "lay\x1b[31m\x9b.xml")):
        name.write_text(MINIMAL if number else "<part><nothing/></part>")
        main(["check", str(name)])
    layout = tmp_path / "whole.xml"
    layout.write_text(MINIMAL.replace("</view>", included))
    main(["check", str(layout)])
    main(["check", "no\x1b[2Jlayout"])
    said = capsys.readouterr()
    assert said.out
    assert said.err
    assert is_plain(said.out + said.err, lines=True)


def test_a_log_that_cannot_be_written_is_told_and_keeps_nobody_from_driving(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    nowhere = tmp_path / "a file"
    nowhere.touch()
    monkeypatch.setenv("XDG_STATE_HOME", str(nowhere))
    monkeypatch.setattr(logging, "raiseExceptions", True)
    log = log_to_file()
    assert log.trouble.startswith("no log is kept: ")
    with log.path.open("ab"):
        pass
    assert capsys.readouterr().err == f"rune: {log.trouble}\n"
