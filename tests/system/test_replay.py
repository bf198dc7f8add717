"""What a console drew on a simulated robot is drawn again from its recording, bit for bit."""

from __future__ import annotations

import time
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import pytest

from rune_tui.replay.console_log import ConsoleLog
from rune_tui.replay.drawing import FrameDrawer
from tests.system.harness import ConsoleProcess, HubProcess, in_soak

MODULES = ("driver", "navigation", "vision", "mapping", "autonomy")


def session(folder: Path, seconds: float, layout: str) -> Path:
    """Drive and look around for a time; the recording of the console."""
    folder.mkdir(exist_ok=True)
    records = folder / "records"
    with closing(HubProcess(folder, arena="yellow", modules=MODULES)) as hub:
        arguments = ["run", layout, "--hub", hub.endpoint, "--record", str(records)]
        with closing(ConsoleProcess(arguments, columns=160, rows=48)) as console:
            console.wait_for_picture()
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                for key in "wdaj":
                    console.hold(key, min(1.0, seconds / 5))
                console.type("?")
                console.pump(0.3)
                console.type("?")
                console.pump(0.3)
    (path,) = records.glob("*.mcap")
    return path


class Compared(NamedTuple):
    """Frames of a recording, those that changed the screen, and those that came out the same."""

    frames: int
    drawn: int
    same: int


def compared(path: Path) -> Compared:
    """Draw all frames again."""
    frames = drawn = same = 0
    with closing(ConsoleLog(path)) as log:
        drawer, shown = FrameDrawer(), None
        for frame in log.frames(log.start - 1, log.end):
            drawer.draw(frame)
            frames += 1
            drawn += frame.checksum is not None
            shown = frame.checksum if frame.checksum is not None else shown
            same += drawer.cells is not None and drawer.cells.checksum == shown
        assert log.faults == []
    return Compared(frames, drawn, same)


@pytest.mark.parametrize("seconds", [4.0, *in_soak(60.0)])
def test_each_frame_is_drawn_again_bit_for_bit(tmp_path: Path, seconds: float) -> None:
    path = session(tmp_path, seconds, "search")
    found = compared(path)
    assert found.drawn > 1  # it did draw, however busy the machine was
    assert found.same == found.frames
