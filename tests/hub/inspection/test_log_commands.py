"""`rune-hub log`: recordings are described, cut, merged, filtered, saved, converted, tabled."""

from __future__ import annotations

import csv
import dataclasses
import json
import math
import os
import shlex
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_typestore

from hub.recording.new_recording import NewRecording
from hub.recording.reader import Recording
from hub.recording.recording_set import RecordingSet
from hub.recording.records import MAGIC, RECORD
from hub.recording.ros_quality import QOS, TYPE_HASH
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter
from tests.support import ros_bags
from tests.support.command_line import rune_hub
from tests.support.recorded_drive import ANCHOR, LIMITS, chunks_of, write_drive

SECOND = 1_000_000_000


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def drive() -> Path:
    path = Path("drive.mcap")
    write_drive(path)
    return path


def log(line: str, code: int = 0) -> str:
    done = rune_hub("log", *shlex.split(line))
    assert done.returncode == code, done.stderr
    return done.stdout + done.stderr


def facts(line: str, code: int = 0) -> dict[str, Any]:
    return json.loads(log(f"{line} --json", code))


def seconds(path: str) -> dict[str, list[float]]:
    """Times of the messages after the anchor, by topic."""
    found: dict[str, list[float]] = {}
    with Recording.open(Path(path)) as recording:
        assert recording.finished
        assert recording.faults == []
        for each in recording.messages():
            name = recording.channels[each.channel].name
            found.setdefault(name, []).append((each.stamp - ANCHOR.wall_ns) / SECOND)
    return found


def test_info_says_what_is_in_a_recording(drive: Path) -> None:
    said = log(f"info {drive}")
    assert "260 messages" in said
    assert "mark 1 at" in said
    known = facts("info drive.mcap")
    topics = {each["name"]: each for each in known["topics"]}
    state = topics["/rover/GCM_DriveState"]
    assert (state["messages"], state["missing"], state["longest_gap_s"]) == (199, 1, 1.0)
    assert state["rate_hz"] == pytest.approx(2.0, abs=0.02)
    assert topics["/scout/GCM_Battery"]["messages"] == 60
    assert [each["text"] for each in known["marks"]] == ["a victim"]
    assert (known["duration_s"], known["finished"], known["faults"]) == (99.5, True, [])
    assert known["attachments"] == ["search.xml"]
    quick = facts("info drive.mcap --quick")
    assert (quick["messages"], quick["gaps"], quick["marks"]) == (260, None, None)
    assert "gaps, jumps, marks and damage are not known" in log("info drive.mcap --quick")


def test_info_fits_a_terminal_of_80_columns(drive: Path) -> None:
    master, terminal = os.openpty()
    with os.fdopen(master, "rb", buffering=0) as screen:
        command = [sys.executable, "-m", "hub", "log", "info", str(drive)]
        subprocess.run(command, stdout=terminal, env={**os.environ, "COLUMNS": "80"}, check=True)
        os.close(terminal)
        said = screen.read(65536).decode()
    head, *rows = said.split("\ntopic ")[1].splitlines()
    assert "messages" in head
    assert "longest gap" in head
    assert all(len(row) <= 80 for row in rows if row.startswith("/"))


def test_info_names_gaps_and_what_the_writer_lost() -> None:
    writer = RecordingWriter(Path("x.mcap"), ANCHOR, {}, LIMITS)
    for moment in (100.0, 100.5, 105.0, 105.5, 120.0):
        writer.add(RecordedTopic("/r/T"), b"x", moment, moment)
    writer.add(RecordedTopic("/r/T"), b"x", float("nan"), 1.0)
    writer.close()
    known = facts("info x.mcap")
    assert [each["duration_s"] for each in known["gaps"]] == [4.5, 14.5]
    assert known["lost"] == {"/r/T": 1}
    assert known["clock_jumps"] == []


@pytest.mark.parametrize("chunk_bytes", [1, 1_000_000])
def test_info_names_where_the_clock_jumps_back(chunk_bytes: int) -> None:
    limits = dataclasses.replace(LIMITS, chunk_bytes=chunk_bytes)
    writer = RecordingWriter(Path("x.mcap"), ANCHOR, {}, limits)
    for topic in ("/r/T", "/r/U"):  # one topic after the other is no jump
        for moment in (100.0, 130.0, 129.5, 109.5, 110.0, 105.0):
            writer.add(RecordedTopic(topic), b"x", moment, moment)
    writer.close()
    jumps = facts("info x.mcap")["clock_jumps"]
    assert [each["back_s"] for each in jumps] == [20.0, 5.0]
    said = log("info x.mcap")
    assert said.count("the clock jumps back by") == 2
    assert "the clock jumps back by 20.0 s at 20" in said
    assert facts("info x.mcap --quick")["clock_jumps"] is None


@pytest.mark.parametrize(
    ("span", "first", "last"),
    [
        ("--from +10s --to +20s", 10.0, 20.0),
        ("--from +90s", 90.5, 100.0),
        ("--to=-98s", 0.5, 2.0),
        ("--around victim --before 5s --after '2 s'", 35.0, 42.0),
        ("--around 1 --before 0 --after 0", 40.0, 40.0),
        ("--from 1790000010 --to 1790000011.5", 10.0, 11.5),
        ("--from 2026-09-21T14:13:30+00:00 --to 2026-09-21T14:13:31Z", 10.0, 11.0),
    ],
)
def test_a_span_is_cut_out(drive: Path, span: str, first: float, last: float) -> None:
    log(f"cut {drive} -o part.mcap {span}")
    times = seconds("part.mcap")["/rover/GCM_DriveState"]
    if "+" in span.split("--to", maxsplit=1)[0] and "T" not in span:
        first, last = first + 0.5 * (first != 90.5), min(100.0, last + 0.5)
    assert (times[0], times[-1]) == (first, last)


def test_a_cut_can_begin_with_what_held_before(drive: Path) -> None:
    log(f"cut {drive} -o part.mcap --from +80s --newest")
    assert seconds("part.mcap")["/scout/GCM_Battery"] == [80.5]
    assert seconds("part.mcap")["/rover/GCM_DriveState"][:2] == [80.5, 80.5]


def test_topics_and_robots_are_filtered(drive: Path) -> None:
    log(f"filter {drive} -o a.mcap --robot scout")
    log(f"filter {drive} -o b.mcap -e Drive Battery -x scout")
    assert list(seconds("a.mcap")) == ["/scout/GCM_Battery"]
    assert list(seconds("b.mcap")) == ["/rover/GCM_DriveState"]
    assert "no topic of drive.mcap is meant" in log(f"filter {drive} -o c.mcap -e nothing", 2)


def test_parts_are_merged_in_the_order_of_time(drive: Path) -> None:
    log(f"filter {drive} -o a.mcap --robot scout")
    log(f"filter {drive} -o b.mcap --robot rover --compression none")
    log("merge a.mcap b.mcap -o c.mcap --compression zstd")
    assert seconds("c.mcap") == seconds("drive.mcap")
    with Recording.open(Path("c.mcap")) as recording:
        assert {place.name for place in recording.attachments} == {"search.xml"}
        stamps = [each.stamp for each in recording.messages()]
    assert stamps == sorted(stamps)


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_an_unfinished_file_is_saved_and_the_loss_said(drive: Path, share: float) -> None:
    raw = drive.read_bytes()
    Path("cut.mcap").write_bytes(raw[: int(share * len(raw))])
    assert "unfinished" in log("info cut.mcap", 0 if share == 0.9 else 1)
    known = facts("recover cut.mcap -o saved.mcap", 0 if share == 0.9 else 1)
    assert known["messages"] == facts("info saved.mcap")["messages"] > 50
    times = seconds("saved.mcap")["/rover/GCM_DriveState"]
    assert times == seconds("drive.mcap")["/rover/GCM_DriveState"][: len(times)]


def test_damage_in_the_middle_costs_its_chunk_only(drive: Path) -> None:
    raw = bytearray(drive.read_bytes())
    begin, end = chunks_of(raw)[3]
    raw[(begin + end) // 2] ^= 0xFF
    Path("flipped.mcap").write_bytes(raw)
    assert "fault: at byte" in log("info flipped.mcap", 1)
    known = facts("recover flipped.mcap -o saved.mcap", 1)
    assert known["unreadable_bytes"] > 0
    assert 0 < known["missing"] < 30
    assert known["messages"] == 260 - known["missing"]
    assert log("recover drive.mcap -o all.mcap").count("lost: 0 bytes") == 1


def test_recover_keeps_messages_of_a_damaged_part_where_that_is_wanted(drive: Path) -> None:
    log(f"convert {drive} -o plain.mcap --compression none")
    raw = bytearray(Path("plain.mcap").read_bytes())
    _, end = chunks_of(raw)[0]
    raw[end - 3] ^= 0xFF
    Path("flipped.mcap").write_bytes(raw)
    assert "--damaged" in log("recover flipped.mcap -o whole.mcap", 1)
    whole = facts("info whole.mcap")
    known = facts("recover flipped.mcap -o more.mcap --damaged", 1)
    assert whole["messages"] < known["messages"] <= 260
    assert "may be wrong" in facts("info more.mcap")["about"]["rune recovered"]["1"]


def test_recover_reads_what_is_left_of_a_cut_database(tmp_path: Path) -> None:
    content = [*ros_bags.entries(2)]
    folder = ros_bags.write_bag(tmp_path / "rover", storage=StoragePlugin.SQLITE3, content=content)
    assert facts(f"info {folder}")["clock_jumps"] is None, "it is read in the order of stamps"
    assert "jumps of the clock are not known" in log(f"info {folder}")
    (whole,) = folder.glob("*.db3")
    raw = whole.read_bytes()
    half = tmp_path / "half.db3"
    half.write_bytes(raw[: len(raw) // 2 // 4096 * 4096])
    known = facts("recover half.db3 -o saved.mcap", 1)
    assert known["faults"]
    assert 0 < known["messages"] == facts("info saved.mcap")["messages"] < len(content)


@pytest.mark.parametrize("which", ["first record", "third record", "chunk"])
def test_a_wrong_length_is_named_though_the_index_finds_all_messages(
    drive: Path, which: str
) -> None:
    raw = bytearray(drive.read_bytes())
    at = len(MAGIC)
    if which == "third record":
        for _ in range(2):
            at += RECORD.size + RECORD.unpack_from(raw, at)[1]
    elif which == "chunk":
        at = chunks_of(raw)[3][0]
    RECORD.pack_into(raw, at, raw[at], 10**10)
    Path("long.mcap").write_bytes(raw)
    for quick in ("", " --quick"):
        known = facts(f"info long.mcap{quick}", 1)
        assert known["messages"] == 260
        assert [each for each in known["faults"] if f"at byte {at}: the length of a" in each]


@pytest.mark.parametrize(
    ("recorder", "numbers", "missing"),
    [
        ("hub", (1, 2, 5), 2),
        ("hub", (1, 80, 2, 81), None),  # two publishers
        ("hub", (7, 8, 1, 2), None),  # one that began again
        ("console", (1, 6, 9), None),  # one counter for all topics
    ],
)
def test_info_counts_missing_numbers_only_where_one_publisher_counts_a_topic(
    recorder: str, numbers: tuple[int, ...], missing: int | None
) -> None:
    writer = RecordingWriter(Path("x.mcap"), ANCHOR, {"recorder": recorder}, LIMITS)
    for at, number in enumerate(numbers):
        writer.add(RecordedTopic("/r/T"), b"x", 100.0 + at, 100.0 + at, number)
    writer.close()
    assert [each["missing"] for each in facts("info x.mcap")["topics"]] == [missing]


def test_tables_on_a_full_disk_leave_no_file(drive: Path) -> None:
    Path("tables").mkdir()
    done = subprocess.run(
        [sys.executable, "-c", _FULL, str(drive)], check=False, capture_output=True, text=True
    )
    assert "tables/rover-GCM_DriveState.csv cannot be written: File too large" in done.stderr
    assert list(Path("tables").iterdir()) == []


_FULL = """
import resource, signal, sys
sys.dont_write_bytecode = True  # else caches of modules would be cut
from hub.cli import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))
sys.exit(main(["log", "csv", sys.argv[1], "-o", "tables", "-e", "GCM_DriveState"]))
"""
"""Every file has room for 3000 bytes."""


WORDS = "- history: keep_all\n  reliability: 'best_effort'\n  durability: volatile\n  depth: 3\n"
"""A quality of service as rosbag2 writes it since its version 9."""
NUMBERS = "- history: 2\n  reliability: 2\n  durability: 2\n  depth: 3\n"
"""As before."""


def test_tools_of_ros_read_a_bag_that_was_made(drive: Path) -> None:
    log(f"convert {drive} -o bag --ros-names")
    with AnyReader([Path("bag")], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        names = {each.topic for each in reader.connections}
        assert {"/rover/odom", "/scout/battery_state", "/rover/GCM_DriveState"} <= names
        hashes = {each.topic: each.digest for each in reader.connections}
        voltages = [
            getattr(reader.deserialize(raw, connection.msgtype), "voltage")  # noqa: B009
            for connection, _, raw in reader.messages()
            if connection.topic == "/scout/battery_state"
        ]
    assert voltages[:2] == pytest.approx([0.2, 0.4])
    types = get_typestore(Stores.ROS2_JAZZY)
    assert hashes["/rover/odom"] == types.hash_rihs01("nav_msgs/msg/Odometry")
    with Path("bag/bag_0.mcap").open("rb") as file:
        channels = make_reader(file).get_summary().channels.values()
    assert hashes["/rover/odom"] in {each.metadata.get(TYPE_HASH) for each in channels}
    log("filter bag -o odometry.mcap -e odom")
    assert len(seconds("odometry.mcap")["/rover/odom"]) == 199
    log("convert bag -o again --ros-names")
    assert seconds("again/again_0.mcap") == seconds("bag/bag_0.mcap")


def test_a_bag_has_qualities_that_all_releases_of_rosbag2_read(drive: Path) -> None:
    later = RecordedTopic("/t", "a/msg/B", metadata={QOS: WORDS})
    with NewRecording(Path("later.mcap")) as new:
        new.add(later, ANCHOR.wall_ns, ANCHOR.wall_ns, 1, b"x")
    log(f"merge {drive} later.mcap -o both.mcap")
    log("convert both.mcap -o bag --ros-names")
    text = Path("bag/metadata.yaml").read_text()
    with Path("bag/bag_0.mcap").open("rb") as file:
        reader = make_reader(file)
        facts = {each.name: each.metadata for each in reader.iter_metadata()}
        qualities = {
            each.topic: each.metadata[QOS] for each in reader.get_summary().channels.values()
        }
    assert "version: 5" in text
    assert "version: 5" in facts["rosbag2"]["serialized_metadata"]
    assert qualities["/t"] == NUMBERS
    assert json.dumps(NUMBERS) in text
    assert all("durability: 2" in each for each in qualities.values())


def test_tables_have_a_column_for_each_field(drive: Path) -> None:
    known = [json.loads(line) for line in log(f"csv {drive} -o tables --json").splitlines()]
    assert {each["rows"] for each in known} == {199, 60, 1}
    with Path("tables/scout-GCM_Battery.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["voltage"]) for row in rows[:2]] == pytest.approx([0.2, 0.4])
    assert rows[0]["log_time_s"] == "1790000001.000000000"
    assert rows[0]["cell_voltage"] == "[]"
    with Path("tables/rover-GCM_Record_Mark.csv").open() as file:
        assert next(csv.DictReader(file))["text"] == "a victim"


def test_tables_have_no_formulas_and_their_lists_are_json() -> None:
    writer = RecordingWriter(Path("x.mcap"), ANCHOR, {}, LIMITS)
    schema = b"float32[3] ranges\nfloat64 speed\nstring said"
    topic = RecordedTopic("/scan", "a/msg/Scan", "ros2msg", schema, "cdr")
    payload = b"\0\1\0\0" + struct.pack("<3fxxxxd", 1.5, math.nan, -math.inf, math.nan)
    text = b'=HYPERLINK("http://x")\x1b[31m\0'
    writer.add(topic, payload + struct.pack("<I", len(text)) + text, 100.0, 100.0)
    writer.close()
    log("csv x.mcap -o tables")
    with Path("tables/scan.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert json.loads(row["ranges"], parse_constant=pytest.fail) == [1.5, "nan", "-inf"]
    assert row["speed"] == "nan"
    assert row["said"] == '\'=HYPERLINK("http://x")\\x1b[31m'


def test_a_folder_is_listed_with_its_bags_and_its_damage(drive: Path) -> None:
    log(f"convert {drive} -o deep/bag --ros-names", 2)  # the folder above is not made
    Path("deep").mkdir()
    log(f"convert {drive} -o deep/bag --ros-names")
    Path("deep/none.mcap").write_bytes(b"hello")
    said = log("ls .", 1)
    assert "deep/none.mcap cannot be read: it is no MCAP file" in said
    assert [line.split()[0] for line in said.splitlines()[1:3]] == ["deep/bag", "drive.mcap"]
    assert "there are no recordings in empty" in (Path("empty").mkdir() or log("ls empty"))


@pytest.mark.usefixtures("drive")
def test_a_folder_that_cannot_be_read_hides_no_other(tmp_path: Path) -> None:
    for _ in range(20):  # deeper than the longest path
        os.mkdir("x" * 250)  # noqa: PTH102 - relative to the folder here
        os.chdir("x" * 250)
    os.chdir(tmp_path)
    said = log("ls .", 1)
    assert "cannot be read: File name too long" in said
    assert [line.split()[0] for line in said.splitlines() if ".mcap" in line] == ["drive.mcap"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("info none.mcap", "none.mcap does not exist"),
        ("cut drive.mcap -o drive.mcap", "drive.mcap exists; choose another name"),
        ("cut drive.mcap -o x.mcap --from tomorrow", "'tomorrow' is no time; write +90s"),
        ("cut drive.mcap -o x.mcap --from +200s", "has no messages in that span; it goes from"),
        ("cut drive.mcap -o x.mcap --around 7", "0 marks are '7'; the marks are: 1 a victim"),
        ("csv drive.mcap -o drive.mcap", "drive.mcap cannot be written: File exists"),
        ("recover none.mcap -o x.mcap", "none.mcap does not exist"),
        ("ls nowhere", "there is no folder nowhere"),
    ],
)
def test_what_cannot_be_done_is_one_sentence(drive: Path, line: str, said: str) -> None:
    before = drive.read_bytes()
    complained = log(line, 2)
    assert said in complained
    assert len(complained.splitlines()) == 1
    assert drive.read_bytes() == before
    assert [each.name for each in Path().iterdir()] == ["drive.mcap"]


def test_force_replaces_a_file(drive: Path) -> None:
    log(f"cut {drive} -o {drive} --to +10s --force")
    assert max(seconds("drive.mcap")["/rover/GCM_DriveState"]) == 10.5


@pytest.mark.parametrize("line", ["cut drive.mcap -o x.mcap", "csv drive.mcap -o tables"])
def test_an_interrupted_copy_leaves_nothing(
    drive: Path, line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(RecordingSet, "messages", interrupted)
    assert "interrupted: no new file is written" in log(line, 1)
    assert [each for each in Path().rglob("*") if each.is_file()] == [drive]
