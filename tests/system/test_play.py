"""`rune-hub play`: a recording on a bus of its own, which answers, and obeys nothing."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hub.command_line import ExitCode
from hub.errors import QueryError
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import CONTROL_REFUSAL, CONTROL_REQUEST, CONTROL_STATE, ControlRequest
from hub.gcm.diagnostics import DIAGNOSTICS, Severity
from hub.gcm.geometry import TwistStamped
from hub.gcm.mapping import MAP, MAP_REQUEST, Map, MapRequest
from hub.gcm.navigation import (
    DRIVE_COMMAND,
    GROUND_TRUTH,
    STOP,
    VELOCITY_COMMAND,
    GroundTruth,
    Stop,
)
from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityReports
from hub.gcm.vision import IMAGE, IMAGE_REQUEST, CameraState, Image, ImageCoding, ImageRequest
from hub.ipc.definition import MessageDefinition
from hub.recording.anchor import TimeAnchor
from hub.recording.live.bus_tap import described
from hub.recording.topics import RecordedTopic, topic_of
from hub.recording.writer import RecordingWriter, WriterLimits
from hub.robots.registry import body_of
from hub.robots.robot_file import find_robot_file, read_description
from hub.values import dataclass
from tests.support.command_line import rune_hub
from tests.support.recorded_drive import damage_chunks
from tests.support.waiting import exit_code
from tests.system.harness import ConsoleProcess, Observer

SECONDS = 20
ANCHOR = TimeAnchor(1_700_000_000_000_000_000, 100.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Smell:
    """A message of a module that Rune does not know."""

    strength: float = 0.0
    of: str = ""


SMELL = MessageDefinition(name="OWN_Smell", type=Smell, rate_hz=10.0)


def truth(second: float) -> GroundTruth:
    return GroundTruth(
        time=second, x=second, y=0.0, theta=0.0, linear=1.0, angular=0.0,
        commanded_linear=1.0, commanded_angular=0.0, contacts=0, touching=0,
    )  # fmt: skip


def picture(shade: int) -> Image:
    camera = CameraState(
        stamp=0.0, pan=0.0, tilt=0.0, zoom=0.0, horizontal_fov=1.0, vertical_fov=0.8,
        mount_forward=0.0, mount_height=0.3, pan_limit=0.0, tilt_limit=0.0, slewing=0,
        name="camera",
    )  # fmt: skip
    data = np.full(12, shade, np.uint8)
    return Image(
        camera=camera, coding=ImageCoding.RAW, width_px=4, height_px=3, channels=1, data=data
    )


def put(writer: RecordingWriter, definition: MessageDefinition[Any], value: Any, at: float) -> None:
    topic = topic_of("rover", definition)
    topic = RecordedTopic(
        topic.name, topic.schema_name, schema=topic.schema, metadata=described(definition)
    )
    moment = ANCHOR.monotonic + at
    writer.add(topic, b"".join(definition.encode(value)), moment, moment - 0.01, 1)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of 20 s: a robot that drives 1 m/s, with pictures, a map, and commands."""
    path = tmp_path_factory.mktemp("play") / "a.mcap"
    writer = RecordingWriter(path, ANCHOR, {}, WriterLimits(least_free=0))
    described_robot, _ = read_description(find_robot_file("magellan"))
    put(writer, ROBOT_DESCRIPTION, body_of(described_robot), 0.0)
    put(writer, CAPABILITY_REPORTS, CapabilityReports(robot="rover", capabilities=()), 0.0)
    for tenth in range(SECONDS * 10 + 1):
        second = tenth / 10
        put(writer, GROUND_TRUTH, truth(second), second)
        put(writer, SMELL, Smell(strength=second, of="smoke"), second)
        put(writer, DRIVE_COMMAND, TwistStamped(), second)
        put(writer, VELOCITY_COMMAND, TwistStamped(), second)
        if tenth % 10 == 0:
            put(writer, IMAGE, picture(tenth // 10), second)
    cells = Map(
        stamp=0.0, resolution=0.1, width_cells=2, height_cells=2, origin_x=0.0, origin_y=0.0,
        data=np.zeros(4, np.uint8),
    )  # fmt: skip
    put(writer, MAP, cells, 1.0)
    writer.close()
    return path


class PlayProcess:
    """`rune-hub play`, from start to end."""

    def __init__(self, file: Path, *options: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "hub", "play", str(file), "--json", *options],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert self.process.stdout is not None
        said = self.process.stdout.readline()
        assert said, self.process.communicate()[1]
        self.ready: dict[str, Any] = json.loads(said)
        self.endpoint = self.ready["hub"]

    def close(self) -> None:
        self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=10.0)


Play = Callable[..., tuple[PlayProcess, Observer]]


@pytest.fixture
def play(file: Path) -> Iterator[Play]:
    with ExitStack() as stack:

        def start(*options: str, seen: Any = (GROUND_TRUTH,)) -> tuple[PlayProcess, Observer]:
            player = stack.enter_context(closing(PlayProcess(file, *options)))
            return player, stack.enter_context(closing(Observer(player.endpoint, *seen)))

        yield start


def test_messages_come_in_their_time_and_commands_stay_in_the_recording(play: Play) -> None:
    player, observer = play("--loop", seen=(GROUND_TRUTH, SMELL, CONTROL_STATE, DIAGNOSTICS))
    assert player.ready["robot"] == "rover"
    assert set(player.ready["left_out"]) == {
        "/rover/GCM_Drive_Command", "/rover/GCM_Velocity_Command",
    }  # fmt: skip
    observer.wait(lambda: len(observer.history) > 15, 20.0)
    (at, first), (later, last) = observer.history[0], observer.history[-1]
    assert later - at == pytest.approx(last.x - first.x, abs=0.2)
    smell = observer.seen[SMELL.name][-1][1]
    assert smell.of == "smoke"
    state = observer.seen[CONTROL_STATE.name][-1][1]
    assert (state.operator, state.owner > 0) == ("RECORDING", True)
    problem = observer.seen[DIAGNOSTICS.name][-1][1].status[0]
    assert problem.level == Severity.ERROR
    assert problem.message.startswith("RECORDING of 2023-11-1")


def test_commands_are_refused(play: Play) -> None:
    _, observer = play("--loop", seen=(GROUND_TRUTH, CONTROL_STATE))
    refusals: list[Any] = []
    observer.client.subscribe(CONTROL_REFUSAL, lambda refusal, _: refusals.append(refusal))
    observer.client.wait_subscribed(5.0)
    result = observer.client.query_response(
        CONTROL_REQUEST, ControlRequest(operator="Ada"), COMMON_RESULT, timeout=5.0
    )
    assert (result.done, "recording" in result.text) == (0, True)
    twist = TwistStamped.planar(0.5, 0.0)
    observer.client.publish(VELOCITY_COMMAND, twist)
    observer.client.publish(STOP, Stop(reason="test"))
    observer.wait(lambda: refusals, 10.0)
    assert refusals[0].operator == "RECORDING"
    assert refusals[0].message == VELOCITY_COMMAND.name


def test_questions_are_answered_from_the_moment_of_the_recording(play: Play) -> None:
    _, observer = play("--start", "10 s", "--paused", seen=(CONTROL_STATE,))
    image = observer.client.query_response(IMAGE_REQUEST, ImageRequest(), IMAGE, timeout=5.0)
    assert image.data.tolist() == [10] * 12
    cells = observer.client.query_response(MAP_REQUEST, MapRequest(), MAP, timeout=5.0)
    assert cells.resolution == 0.1
    assert observer.client.last_value(GROUND_TRUTH, timeout=5.0).x == pytest.approx(10.0)


def test_before_its_first_picture_there_is_none(play: Play) -> None:
    _, observer = play("--start", "0.5 s", "--paused", seen=(CONTROL_STATE,))
    with pytest.raises(QueryError, match="no map before this moment"):
        observer.client.query_response(MAP_REQUEST, MapRequest(), MAP, timeout=5.0)


def test_ten_times_as_fast_takes_a_tenth_of_the_time_and_it_ends_by_itself(file: Path) -> None:
    with closing(PlayProcess(file, "--rate", "10", "--start", "5 s")) as player:
        begun = time.monotonic()
        assert exit_code(player.process, 20.0) == 0
        assert time.monotonic() - begun >= 1.3


def test_a_long_hole_is_skipped_and_said_and_is_no_fault(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "a.mcap", ANCHOR, {}, WriterLimits(least_free=0))
    for second in (0.0, 1.0, 180_000.0, 180_001.0):
        put(writer, GROUND_TRUTH, truth(second), second)
    writer.close()
    with closing(PlayProcess(tmp_path / "a.mcap", "--rate", "20")) as player:
        assert exit_code(player.process, 20.0) == ExitCode.OK
        assert player.process.stderr is not None
        assert "no message from 2023-11-1" in player.process.stderr.read()


def test_what_cannot_be_played_is_said(file: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.mcap").write_bytes(b"no recording at all")
    for arguments, text in (
        ((str(tmp_path / "bad.mcap"),), "bad.mcap"),
        ((str(tmp_path / "none.mcap"),), "does not exist"),
        ((str(file), "--robot", "blimp"), "it has rover"),
        ((str(file), "--rate", "0"), "no rate from 0.1 to 100"),
    ):
        done = rune_hub("play", *arguments)
        assert (done.returncode, text in done.stderr) == (2, True), done.stderr


def test_a_console_says_that_it_is_a_recording(file: Path) -> None:
    with (
        closing(PlayProcess(file, "--loop")) as player,
        closing(ConsoleProcess(["run", "auto", "--hub", player.endpoint])) as console,
    ):
        console.wait(lambda: "RECORDING of 2023" in console.text, 30.0, lambda: console.text)
        console.wait(lambda: "RECORDING has control" in console.text, 30.0, lambda: console.text)
        console.type("www")
        assert console.quit() == 0


def test_a_damaged_file_and_a_choice_of_nothing_are_faults(file: Path, tmp_path: Path) -> None:
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(damage_chunks(file.read_bytes()))
    done = rune_hub("play", str(damaged))
    assert done.returncode == ExitCode.FAULT
    assert "a part of it is damaged" in done.stderr
    assert "no message of the chosen topics of rover can be read" in done.stderr
    done = rune_hub("play", str(file), "-e", "nomatch")
    assert done.returncode == ExitCode.FAULT
    assert "no topic of rover is chosen" in done.stderr
