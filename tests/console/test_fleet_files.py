"""Layouts of a fleet while robots come: who is new is said, a key shows it, and nothing moves."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.errors import CentralUnreachableError
from rune_tui.commands import fleet as fleet_command
from rune_tui.commands.fleet import FleetFiles
from rune_tui.layout.spec import LayoutSpec
from rune_tui.layout.watching import LayoutSource
from rune_tui.model.console_state import ConsoleState, carried_over
from rune_tui.startup.fleet_layout import MOST
from rune_tui.startup.opening import open_layout
from tests.support.command_line import rune
from tests.support.ports import free_port
from tests.support.waiting import until

OWN = """<rune run="1"><robot name="{robot}" fleet="{fleet}"/><view xsize="80" ysize="48">
  <widget handler="widgetNextLayout"><event key="f4"/></widget></view></rune>"""


class FakeMirror:
    """Robots that are there, without a network."""

    def __init__(self, *present: str) -> None:
        self.present: tuple[str, ...] = present

    def endpoint(self, robot: str) -> str:
        return f"ipc:///nowhere/{robot}"


@pytest.fixture(autouse=True)
def described(monkeypatch: pytest.MonkeyPatch) -> None:
    def auto_layout(_hub: str, *, robot: str, fleet: str) -> str:
        if robot == "dumb":
            raise CentralUnreachableError(robot)
        return OWN.format(robot=robot, fleet=fleet)

    monkeypatch.setattr(fleet_command, "auto_layout", auto_layout)


def source_of(files: FleetFiles) -> LayoutSource:
    names = files.names()
    return LayoutSource(names, open_layout, open_layout(names[0]), watched=False, arrivals=files)


def robots_of(layout: object) -> list[str]:
    assert isinstance(layout, LayoutSpec), layout
    return [robot.name for robot in layout.robots]


def digits_of(layout: LayoutSpec) -> dict[str, str]:
    """The robot that each digit chooses."""
    return {
        event.name: widget.options.word("robot")
        for viewport in layout.view.viewports
        for widget in viewport.widgets
        if widget.handler == "widgetChooseRobot"
        for event in widget.events
        if event.name.isdigit()
    }


def test_robot_that_joins_is_named_once_and_the_next_layout_shows_it(tmp_path: Path) -> None:
    mirror = FakeMirror("rover")
    files = FleetFiles(mirror, "rune", tmp_path, ["rover"])
    source = source_of(files)
    assert (robots_of(source.layout), source.several, source.news()) == (["rover"], False, "")
    mirror.present = ("boat", "rover")
    assert source.news() == "boat joined the fleet: F4 shows all 2 robots"
    assert source.several
    mirror.present = ("rover",)  # it went, and comes again: nothing is new
    assert source.news() == ""
    mirror.present = ("boat", "rover")
    assert source.news() == ""
    assert robots_of(source.next()) == ["rover", "boat"]
    until(lambda: len(files.names()) == 3, 10.0)
    assert [robots_of(source.next()) for _ in range(3)] == [["rover"], ["boat"], ["rover", "boat"]]


def test_what_the_operator_drives_and_the_digits_stay_when_a_robot_joins(tmp_path: Path) -> None:
    mirror = FakeMirror("m", "z")
    source = source_of(FleetFiles(mirror, "rune", tmp_path, ["m", "z"]))
    before = digits_of(source.layout)
    assert before == {"1": "m", "2": "z"}
    state = dataclasses.replace(ConsoleState.at_start(source.layout, 0.0, "ann"), chosen="z")
    mirror.present = ("a", "m", "z")
    assert source.news()
    joined = source.next()
    assert isinstance(joined, LayoutSpec)
    assert digits_of(joined) == before | {"3": "a"}
    assert carried_over(state, joined).chosen == "z"


def test_robots_beyond_the_most_and_without_a_description_are_said_and_do_no_harm(
    tmp_path: Path,
) -> None:
    robots = [f"r{number}" for number in range(MOST - 1)]
    mirror = FakeMirror(*robots)
    files = FleetFiles(mirror, "rune", tmp_path, robots)
    source = source_of(files)
    mirror.present = (*robots, "dumb")
    assert "dumb joined the fleet: F4 shows all 9" in source.news()
    mirror.present = (*robots, "dumb", "tenth")
    assert source.news() == (
        "tenth joined the fleet; at most 9 are shown, and --only chooses which"
    )
    assert robots_of(source.next()) == [*robots, "dumb"]
    assert len(files.names()) == MOST


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("127.0.0.1:7447", "write tcp/HOST:PORT or tls/HOST:PORT, such as tcp/127.0.0.1:7447"),
        ("rune", "write tcp/HOST:PORT or tls/HOST:PORT"),
        ("tls/fleet.example:7447", "give the folder with its files by --keys"),
    ],
)
def test_what_names_no_router_is_refused_before_anything_starts(place: str, said: str) -> None:
    done = rune("shot", "auto", "--fleet", place, "-o", "nowhere.png")
    assert done.returncode == ExitCode.USAGE
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_mirror_that_refuses_what_it_is_given_is_not_started_again(tmp_path: Path) -> None:
    words = ("--keys", str(tmp_path), "--as", "operate:ann", "-o", "nowhere.png")
    done = rune("shot", "auto", "--fleet", f"tls/127.0.0.1:{free_port()}", *words)
    assert done.returncode == ExitCode.USAGE
    assert f"key file {tmp_path / 'authority.pem'} cannot be used" in done.stderr
    assert "again" not in done.stderr
    assert len(done.stderr.splitlines()) == 1
