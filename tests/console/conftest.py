"""Consoles under Textual's pilot for tests."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from rune_tui.app import Console
from rune_tui.layout.loader import load_layout
from rune_tui.layout.rules import Vocabulary
from rune_tui.layout.spec import LayoutSpec
from rune_tui.layout.watching import LayoutSource
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.robot_state import LinkPhase
from rune_tui.startup.opening import BUILT_IN, open_layout
from tests.console.app_desk import LAYOUT, TRAITS, Desk, Floor, Robot, Script
from tests.console.dispatching import TWO_ROBOTS


@pytest.fixture
def play(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Script], None]]:
    """Runs a script at a console that is linked to a robot."""
    monkeypatch.setenv("LOGNAME", "jane")
    with ExitStack() as stack:
        central = stack.enter_context(closing(Central([f"ipc://{tmp_path}/central"])))
        robot = Robot(stack.enter_context(closing(Client("robot", central.endpoints[0]))))
        path = tmp_path / "layout.xml"
        path.write_text(LAYOUT.format(hub=central.endpoints[0]))
        visualizers = {**BUILT_IN.visualizers, "visualizeFloor": Floor}
        vocabulary = Vocabulary(visualizers=visualizers, widgets=BUILT_IN.widgets)
        layout = load_layout(path, vocabulary)
        source = LayoutSource(
            [str(path)], lambda name: load_layout(name, vocabulary), layout, watched=False
        )
        links = RobotLinks(layout)
        link = links["magellan"]
        link.start()
        stack.enter_context(closing(link))

        async def run(script: Script) -> None:
            console = Console(source, links, TRAITS)
            async with console.run_test(size=(60, 20)) as pilot:
                desk = Desk(console, link, robot, pilot)
                await desk.until(lambda: link.state.link.phase is LinkPhase.CONNECTED)
                await desk.until(lambda: robot.speeds)
                await script(desk)

        stack.callback(sys.setswitchinterval, sys.getswitchinterval())  # a console shortens it
        yield lambda script: asyncio.run(run(script))


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets consoles end without the last resort, which ends the process that runs the test."""
    monkeypatch.setattr("rune_tui.app.force_end_later", lambda: None)


@pytest.fixture(scope="module")
def two_robots(tmp_path_factory: pytest.TempPathFactory) -> LayoutSpec:
    path = tmp_path_factory.mktemp("layouts") / "two.xml"
    path.write_text(TWO_ROBOTS)
    return open_layout(path)
