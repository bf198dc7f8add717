"""Peeking at the running console: from the keys of a terminal to the title of the picture."""

from __future__ import annotations

import asyncio
import shutil
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest
from textual.pilot import Pilot

from rune_tui.app import Console
from rune_tui.layout.watching import LayoutSource
from rune_tui.link.robot_links import RobotLinks
from rune_tui.startup.opening import open_layout
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.ui.driver_reports import KeyMoved, ReleasesReported
from tests.console.app_desk import TIMEOUT, TRAITS
from tests.console.situations import ROOT


async def until(pilot: Pilot[Any], condition: Callable[[], object]) -> None:
    end = time.monotonic() + TIMEOUT
    while not condition():
        assert time.monotonic() < end
        await pilot.pause(0.02)


def test_a_held_key_shows_another_robot_and_its_release_the_chosen_one(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("LOGNAME", "jane")
    shutil.copytree(ROOT / "layouts" / "parts", tmp_path / "parts")
    path = tmp_path / "team.xml"
    text = (ROOT / "layouts" / "land-sea-air.xml").read_text()
    path.write_text(text.replace("tcp://127.0.0.1:", f"ipc://{tmp_path}/"))  # nobody is there
    layout = open_layout(path)
    source = LayoutSource([str(path)], lambda _: layout, layout, watched=False)

    async def run() -> None:
        links = RobotLinks(layout)
        console = Console(source, links, TRAITS)
        with ExitStack() as stack:
            stack.enter_context(closing(console.inputs.joysticks))
            for link in links.values():
                link.start()
                stack.enter_context(closing(link))
            await script(console)

    async def script(console: Console) -> None:
        async with console.run_test(size=(120, 40)) as pilot:
            console.post_message(ReleasesReported(reported=True))
            await until(pilot, lambda: console.state.releases_reported)
            for ends in ("release", "blur", "choose"):
                chosen = console.state.chosen
                console.post_message(KeyMoved("apostrophe", "'", KeyMove.PRESS))
                await until(pilot, lambda: console.state.peeked)
                assert console.state.chosen == chosen != console.state.peeked
                if ends == "blur":
                    console.on_app_blur()
                elif ends == "choose":
                    console.post_message(KeyMoved("3", "3", KeyMove.PRESS))
                if ends != "blur":  # the release goes to the other window
                    console.post_message(KeyMoved("apostrophe", "'", KeyMove.RELEASE))
                await until(pilot, lambda: not console.state.peeked)
                wanted = "submarine" if ends == "choose" else "rover"
                await until(pilot, lambda wanted=wanted: console.state.chosen == wanted)

    interval = sys.getswitchinterval()
    try:
        asyncio.run(run())
    finally:
        sys.setswitchinterval(interval)
