"""What a replay costs: opening an hour of log, a jump to a drawn frame, and playing fast.

The log is that of a console with the layout `search`: 30 frames, 20 states and 10 pictures a
second. Its frames are not drawn when it is made, which would take minutes.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import random
import sys
import tempfile
import time
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.figures import report, say
from benchmarks.stand_in_robot import coded
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.vision import IMAGE
from hub.sim.arena import load_arena
from hub.sim.spatial_pose import SpatialPose
from rune_tui.files.console_recording import ConsoleRecording
from rune_tui.files.frame_log import DrawnFrame, FrameLog
from rune_tui.files.recorder import record_layout
from rune_tui.link.pictures import picture_of
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.own_records import TerminalRecord
from rune_tui.model.robot_state import LinkPhase, LinkState, Received, RobotState
from rune_tui.replay.console_log import ConsoleLog
from rune_tui.replay.player import Knowledge, Player
from rune_tui.startup.opening import open_layout
from tests.support.magellan import magellan_body, magellan_camera
from tests.support.messages import robot_state

COLUMNS, ROWS = 160, 48
FRAMES, STATES, PICTURES = 30, 20, 10
SIZE = (112, 84)
JUMPS = 100
FILLS = 20
PLAYED_S = 60.0
_WAITING = 5000
"""Messages that may wait for the disk."""
SECOND = 1_000_000_000


def log_of(path: Path, seconds: int) -> None:
    """Write a log of a robot that drives in a circle and turns its camera."""
    arena = load_arena("yellow")
    camera = magellan_camera(arena)
    pictures = []
    for number in range(30):
        heading = arena.start.theta + number * 0.2
        camera.place(SpatialPose(x=arena.start.x, y=arena.start.y, yaw=heading))
        pixels = camera.take(*SIZE, 0.0).pixels
        pictures.append(coded(pixels, camera.camera_state(0.0), quality=60))
    shown = [picture_of(each) for each in pictures]
    layout, begin = open_layout("search"), 1000.0
    now, numbers = begin, itertools.count(1)
    recording = ConsoleRecording(path, {}, clock=lambda: now)
    log = FrameLog(recording, {"robot": "robot"}, TerminalRecord())
    record_layout(recording, layout, set())
    link = LinkState(phase=LinkPhase.CONNECTED, since=begin, endpoint="here")
    messages: dict[str, Received[Any]] = {}
    picture = None
    state = ConsoleState.at_start(layout, now, "jane")
    for frame in range(seconds * FRAMES):
        now = begin + frame / FRAMES
        if frame == 0:
            number = next(numbers)
            body = Received(value=magellan_body(), measured=now, number=number)
            messages = {ROBOT_DESCRIPTION.name: body}
            recording.add("robot", ROBOT_DESCRIPTION, body.value, now, number)
        if frame * STATES // FRAMES != (frame - 1) * STATES // FRAMES:
            number, turn = next(numbers), now / 5.0
            value = robot_state(x=math.cos(turn), y=math.sin(turn), linear=math.sin(turn))
            received = Received(value=value, measured=now, number=number)
            messages = {**messages, ROBOT_STATE.name: received}
            recording.add("robot", ROBOT_STATE, value, now, number)
        if frame % (FRAMES // PICTURES) == 0:
            number, place = next(numbers), frame // (FRAMES // PICTURES) % len(pictures)
            picture = Received(value=shown[place], measured=now, number=number)
            recording.add("robot", IMAGE, pictures[place], now, number)
        robot = RobotState(name="robot", link=link, picture=picture, messages=messages)
        state = dataclasses.replace(state, now=now, clock="12:00:00", robots={"robot": robot})
        drawn = DrawnFrame(columns=COLUMNS, rows=ROWS, arranged=1, cells=None, slow={})
        log.frame(state, drawn)
        while recording.state.messages < 2 * frame - _WAITING:  # a frame has two on average
            time.sleep(0.01)  # else the writer would lose some
    recording.close()


def percentile(times: list[float], share: float) -> float:
    """The time that this share of all is not above [ms]."""
    return sorted(times)[min(len(times) - 1, int(share * len(times)))] * 1e3


def jumps(player: Player, chance: random.Random) -> tuple[list[float], list[float]]:
    """Times of jumps to a drawn frame: on the wall, and of the processor [s]."""
    wall, spent = [], []
    for _ in range(JUMPS):
        stamp = chance.randrange(player.source.start, player.source.end)
        began, worked = time.perf_counter(), time.process_time()
        player.seek(stamp)
        wall.append(time.perf_counter() - began)
        spent.append(time.process_time() - worked)
    return wall, spent


def measure(path: Path, seconds: int) -> None:
    """Print all figures of a log."""
    opened = []
    for _ in range(9):
        began = time.perf_counter()
        with closing(ConsoleLog(path)):
            opened.append(time.perf_counter() - began)
    size = path.stat().st_size / 1e6
    note = f"{seconds} s of log, {size:.0f} MB; median of 9, in the file cache"
    report("replay.open", percentile(opened, 0.5), "ms", bar=100.0, note=note)
    chance = random.Random(1)
    with closing(Player(partial(ConsoleLog, path))) as player:
        wall, spent = jumps(player, chance)
        note = f"into parts not read yet; {percentile(spent, 0.95):.0f} ms of processor time"
        report("replay.seek_p95", percentile(wall, 0.95), "ms", bar=250.0, note=note)
        fill(player, chance)
        say("reading the whole log for exact jumps")
        began = time.process_time()
        while player.prepare(time.perf_counter, 1.0):
            pass
        took = time.process_time() - began
        frames = seconds * FRAMES
        report("replay.frames_read", frames / took, "frames/s", better="higher")
        wall, spent = jumps(player, chance)
        note = f"all frames before count; {percentile(spent, 0.95):.0f} ms of processor time"
        report("replay.seek_exact_p95", percentile(wall, 0.95), "ms", bar=250.0, note=note)
        play(player, 10.0, PLAYED_S)
        play(player, 100.0, min(seconds, 10.0 * PLAYED_S))


def fill(player: Player, chance: random.Random) -> None:
    """Jump into parts not read yet, and let trails and plots fill."""
    took = []
    for _ in range(FILLS):
        player.seek(chance.randrange(player.source.start, player.source.end))
        began = time.process_time()
        while player.knows is Knowledge.SECONDS and player.prepare(time.perf_counter, 0.02):
            pass
        took.append(time.process_time() - began)
    note = "processor time until trails and plots are there after such a jump"
    report("replay.fill_p95", percentile(took, 0.95), "ms", bar=3000.0, note=note)


def play(player: Player, rate: float, seconds: float) -> None:
    """Play some log [s] at a rate, 30 turns a second."""
    player.seek(player.source.start)
    player.rate, player.playing = rate, True
    end = player.source.start + round(seconds * SECOND) - SECOND
    began, worked = time.perf_counter(), time.process_time()
    turn = 0
    while player.position < end and player.playing:
        player.tick(time.perf_counter(), time.perf_counter, 0.025)
        turn += 1
        time.sleep(max(0.0, began + turn / FRAMES - time.perf_counter()))
    took, spent = time.perf_counter() - began, time.process_time() - worked
    note = f"{spent / took:.2f} of a core"
    report(
        f"replay.x{rate:.0f}",
        (seconds - 1.0) / took,
        "log time over time",
        note=note,
        bar=0.9 * rate,
        better="higher",
    )
    player.playing = False


def main() -> None:
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 3600
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hour.mcap"
        say(f"writing {seconds} s of log")
        log_of(path, seconds)
        measure(path, seconds)


if __name__ == "__main__":
    main()
