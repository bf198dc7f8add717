"""Logs of ground stations: pymavlink reads those that Rune makes, and Rune those of others."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink import mavutil

from hub.gcm.autopilot import MAVLINK_FRAMES, MavlinkFrames
from hub.recording.new_recording import NewRecording
from hub.recording.recording_set import RecordingSet
from hub.recording.topics import topic_of
from hub.robots.mavlink.tlog import TlogEntry, TlogReader
from hub.robots.mavlink.wire.frames import FramePacker
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from tests.support.command_line import rune_hub

START_US = 1_790_000_000_000_000


def drive(count: int = 200) -> list[TlogEntry]:
    """Frames of a vehicle, each fourth one of a station; the last ones are signed."""
    vehicle, station = FramePacker(1, 1), FramePacker(255, 190)
    signed = FramePacker(1, 1, Signer(bytes(32), SigningClock()))
    made = []
    for number in range(count):
        packer = station if number % 4 == 0 else signed if number > count - 20 else vehicle
        frame = packer.pack("ATTITUDE", time_boot_ms=number, yaw=number / 100)
        made.append(TlogEntry(START_US + 20_000 * number, frame))
    return made


def write_tlog(path: Path, entries: list[TlogEntry]) -> None:
    path.write_bytes(b"".join(struct.pack(">Q", each.stamp) + each.frame for each in entries))


def read_back(data: bytes) -> tuple[list[TlogEntry], int]:
    reader = TlogReader(io.BytesIO(data))
    return list(reader), reader.skipped


def test_what_pymavlink_reads_is_what_was_recorded(tmp_path: Path) -> None:
    entries = drive()
    recording, log = tmp_path / "a.mcap", tmp_path / "a.tlog"
    pieces = b""
    with NewRecording(recording) as new:
        for number, (stamp, frame) in enumerate(entries, 1):
            sent = frame[5] == 255
            pieces += b"" if sent else frame
            # A stream is cut anywhere; what is sent is whole.
            data, pieces = (frame, pieces) if sent else (pieces[:-5], pieces[-5:])
            value = MavlinkFrames(
                stamp=stamp / 1e6, sent=int(sent), data=np.frombuffer(data, np.uint8)
            )
            payload = b"".join(MAVLINK_FRAMES.encode(value))
            new.add(topic_of("rover", MAVLINK_FRAMES), 1000 * stamp, 0, number, payload)
    done = rune_hub("log", "convert", str(recording), "-o", str(log), "--json")
    facts = json.loads(done.stdout)
    assert facts["messages"] == len(entries) - 1
    assert facts["unreadable_bytes"] == len(entries[-1].frame) - 5
    oracle = mavutil.mavlink_connection(str(log))
    read = []
    while (message := oracle.recv_msg()) is not None:
        read.append((message.get_srcSystem(), message.time_boot_ms, message.yaw))
    own = [(each.frame[5], number) for number, each in enumerate(entries[:-1])]
    assert sorted((system, boot) for system, boot, _ in read) == sorted(own)
    assert all(yaw == pytest.approx(boot / 100) for _, boot, yaw in read)


def test_a_log_becomes_a_recording_and_the_same_log_again(tmp_path: Path) -> None:
    entries = drive()
    log, recording, again = (tmp_path / name for name in ("a.tlog", "a.mcap", "b.tlog"))
    write_tlog(log, entries)
    done = rune_hub("log", "convert", str(log), "-o", str(recording), "--robot", "rover")
    assert (done.returncode, done.stderr) == (0, "")
    with RecordingSet.open([recording]) as opened:
        (topic,) = opened.channels.values()
        values = [MAVLINK_FRAMES.decode(each.payload) for each in opened.messages()]
    assert topic.name == "/rover/GCM_Mavlink_Frames"
    assert sum(value.sent for value in values) == len(entries) / 4
    done = rune_hub("log", "convert", str(recording), "-o", str(again))
    assert (done.returncode, done.stderr) == (0, "")
    assert again.read_bytes() == log.read_bytes()


def test_damage_costs_only_what_it_hits(tmp_path: Path) -> None:
    entries = drive()
    log = tmp_path / "a.tlog"
    write_tlog(log, entries)
    data = bytearray(log.read_bytes())
    del data[1000:1007]
    found, skipped = read_back(bytes(data))
    assert len(entries) - 3 <= len(found) < len(entries)
    assert skipped > 0
    assert set(found[-100:]) == set(entries[-100:])


@given(st.binary(max_size=3000))
def test_any_bytes_are_read_to_their_end(data: bytes) -> None:
    entries, skipped = read_back(data)
    assert sum(8 + len(each.frame) for each in entries) + skipped == len(data)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.tlog", "-o", "x.mcap"], "none.tlog cannot be read: No such file"),
        (["text.tlog", "-o", "x.mcap"], "text.tlog has no frames of MAVLink"),
        (["text.tlog", "-o", "x.mcap", "--from", "+1s"], "is converted as a whole"),
        (["text.tlog", "-o", "x.mcap", "--robot", "a/b"], "is no name of 1 to 32"),
        (["other.mcap", "-o", "x.tlog"], "other.mcap has MAVLink frames of no robot"),
        (["two.mcap", "-o", "x.tlog"], "frames of rover, sub; choose one with --robot"),
        (["two.mcap", "-o", "text.tlog", "--robot", "sub"], "text.tlog exists"),
    ],
)
def test_what_cannot_be_converted_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("text.tlog").write_text("no log")
    value = b"".join(MAVLINK_FRAMES.encode(MavlinkFrames(stamp=1e9)))
    for name, topics in (("two", ("rover/x", "sub/x")), ("other", ("a/b",))):
        with NewRecording(Path(f"{name}.mcap")) as new:
            for number, topic in enumerate(topics, 1):
                robot = topic.partition("/")[0]
                recorded = topic_of(robot, MAVLINK_FRAMES)
                if name == "other":
                    recorded = type(recorded)("/a/b")
                new.add(recorded, 10**18, 0, number, value)
    done = rune_hub("log", "convert", *arguments)
    assert done.returncode == 2
    assert words in done.stderr
    assert not Path("x.mcap").exists()
    assert Path("text.tlog").read_text() == "no log"
