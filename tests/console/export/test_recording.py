"""A recording holds what came and went, as others read it."""

from __future__ import annotations

import contextlib
import errno
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import make_reader
from mcap.records import Message, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory

from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import ROBOT_STATE, VELOCITY_COMMAND
from hub.gcm.ranges import RANGES
from hub.gcm.vision import IMAGE, Image, ImageCoding
from rune_tui.export.recording import Recording
from tests.console.states import range_readings
from tests.support.full_disk import files_no_longer_than
from tests.support.messages import camera_state, robot_state


def _channels(path: Path) -> list[tuple[Schema, str]]:
    """Each channel's schema and topic."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return [(summary.schemas[each.schema_id], each.topic) for each in summary.channels.values()]


def test_messages_are_read_back_by_tools_of_ros(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    recording = Recording(path, {"layout": "x.xml", "run": "7", "operator": "ada"})
    now = time.monotonic()
    for number in range(5):
        recording.add("left", ROBOT_STATE, robot_state(x=float(number)), now - 0.5)
    recording.add("right", VELOCITY_COMMAND, TwistStamped.planar(0.25, -0.5), now)
    pixels = np.arange(12, dtype=np.uint8)
    image = Image(
        camera=camera_state(),
        coding=ImageCoding.RAW,
        width_px=2,
        height_px=2,
        channels=3,
        data=pixels,
    )
    recording.add("left", IMAGE, image, now)
    recording.close()
    assert (recording.count, recording.dropped, recording.fault) == (7, 0, "")
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        found = [
            (channel.topic, message, decoded)
            for _, channel, message, decoded in reader.iter_decoded_messages()
        ]
    states = [each for each in found if each[0] == "/left/GCM_RobotState"]
    assert [decoded.x for _, _, decoded in states] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert all(4e8 < message.log_time - message.publish_time < 6e10 for _, message, _ in states)
    (command,) = [each[2] for each in found if each[0] == "/right/GCM_Velocity_Command"]
    assert command.twist.linear.x == 0.25
    (picture,) = [each[2] for each in found if each[0] == "/left/GCM_Common_Image"]
    assert bytes(picture.data) == pixels.tobytes()
    schemas = {topic: schema.name for schema, topic in _channels(path)}
    assert schemas == {
        "/left/GCM_RobotState": "rune_msgs/msg/GCMRobotState",
        "/right/GCM_Velocity_Command": "geometry_msgs/msg/TwistStamped",
        "/left/GCM_Common_Image": "rune_msgs/msg/GCMCommonImage",
    }
    with path.open("rb") as file:
        (about,) = [data for data in make_reader(file).iter_metadata() if data.name == "rune"]
    assert about.metadata == {"layout": "x.xml", "run": "7", "operator": "ada"}


def test_a_recording_of_the_last_protocol_is_read_by_its_own_schemas() -> None:
    """It has messages that are another type now, or none: ranges in the state, an attitude."""
    path = Path(__file__).parents[2] / "data" / "recordings" / "protocol-4.mcap"
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        found = [
            (channel.topic.rpartition("/")[2], decoded)
            for _, channel, _, decoded in reader.iter_decoded_messages()
        ]
    names = {topic for topic, _ in found}
    assert names == {"GCM_RobotState", "GCM_Velocity_Command", "GCM_Attitude"}
    states = [decoded for topic, decoded in found if topic == "GCM_RobotState"]
    assert [state.x for state in states] == [0.0, 1.0, 2.0]
    assert len(states[0].sonar) == 16
    (command,) = (decoded for topic, decoded in found if topic == "GCM_Velocity_Command")
    assert (command.linear.x, command.angular.z) == (0.25, -0.5)
    (tilt,) = (decoded for topic, decoded in found if topic == "GCM_Attitude")
    assert (tilt.roll, tilt.pitch) == (0.1, -0.2)


def test_a_value_that_does_not_fit_is_left_out(tmp_path: Path) -> None:
    recording = Recording(tmp_path / "a.mcap", {})
    recording.add("left", ROBOT_STATE, object(), 0.0)
    recording.add("left", ROBOT_STATE, robot_state(), 0.0)
    recording.close()
    assert recording.count == 1


def test_a_full_disk_ends_the_recording_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = Recording(tmp_path / "a.mcap", {})

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Writer, "add_message", full)
    for _ in range(3):
        recording.add("left", ROBOT_STATE, robot_state(), 0.0)
    recording.close()
    assert (recording.count, recording.fault) == (0, "No space left on device")


def readable(path: Path) -> int:
    """Messages that can be read of a file without an end."""
    found = 0
    with path.open("rb") as file, contextlib.suppress(EndOfFile):
        for record in StreamReader(file).records:
            found += isinstance(record, Message)
    return found


_WRITER = """
import sys, time
from pathlib import Path
from rune_tui.export.recording import Recording
from hub.gcm.navigation import ROBOT_STATE
from tests.support.messages import robot_state
recording = Recording(Path(sys.argv[1]), {})
while True:
    recording.add("left", ROBOT_STATE, robot_state(), time.monotonic())
    print(recording.count, flush=True)
    time.sleep(0.002)
"""


def test_what_was_counted_can_be_read_after_a_kill(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with subprocess.Popen(
        [sys.executable, "-c", _WRITER, str(path)], stdout=subprocess.PIPE, text=True
    ) as writer:
        assert writer.stdout is not None
        counted = 0
        while counted < 20:
            counted = int(writer.stdout.readline())
        writer.kill()
        for line in writer.stdout:
            counted = int(line) if line.endswith("\n") else counted
    assert readable(path) >= counted >= 20


def test_on_a_full_disk_the_count_is_what_can_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rune_tui.export.recording.FLUSH_S", 0.0)
    path = tmp_path / "a.mcap"
    with files_no_longer_than(30_000):
        recording = Recording(path, {})
        noise = np.random.default_rng(1)
        for number in range(400):
            readings = range_readings(
                noise.random(16).astype(np.float32), noise.random(16).astype(np.float32)
            )
            recording.add("left", RANGES, readings, float(number))
        recording.close()
    assert recording.fault == "File too large"
    assert 0 < recording.count == readable(path) < 400
    assert path.stat().st_size <= 30_000


def test_a_file_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_text("mine")
    with pytest.raises(FileExistsError):
        Recording(tmp_path / "a.mcap", {})
