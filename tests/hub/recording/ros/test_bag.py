"""Bags that others write are read whole; damaged ones as far as they go, with a sentence."""

from __future__ import annotations

import itertools
import random
import shutil
import sqlite3
from collections import Counter
from pathlib import Path

import pytest
import zstandard
from mcap.writer import CompressionType, IndexType
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from hub.errors import RecordingError
from hub.recording.ros.bag import Bag
from hub.recording.ros.sqlite_rows import MessageRows
from hub.ros.decoding import RosDecoder
from tests.support import ros_bags
from tests.support.ros_bags import START, Entry

CONTENT = list(ros_bags.entries(2))


@pytest.fixture(scope="module", name="whole")
def _whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags")
    return ros_bags.write_bag(folder / "db3", storage=StoragePlugin.SQLITE3, content=CONTENT)


def read(bag: Bag) -> list[Entry]:
    topics = bag.channels
    return [
        (topics[each.channel].name, topics[each.channel].schema_name, each.stamp, each.payload)
        for each in bag.messages()
    ]


def check(path: Path) -> None:
    """All messages of the content are there, in every way to ask for them."""
    with Bag.open(path) as bag:
        assert sorted(read(bag)) == sorted(CONTENT)
        assert [each.stamp for each in bag.messages()] == sorted(each[2] for each in CONTENT)
        backward = [each.stamp for each in bag.messages(reverse=True)]
        assert backward == sorted(backward, reverse=True)
        assert (bag.start, bag.end) == (CONTENT[0][2], CONTENT[-1][2])
        counts = {bag.channels[number].name: count for number, count in bag.counts.items()}
        assert counts in ({}, Counter(each[0] for each in CONTENT))
        by_name = {topic.name: number for number, topic in bag.channels.items()}
        for stamp in (START - 1, START, START + 777_777_777, bag.end, bag.end + 1):
            newest = bag.newest(stamp)
            expected = {by_name[topic]: (at, data) for topic, _, at, data in CONTENT if at <= stamp}
            assert {n: (each.stamp, each.payload) for n, each in newest.items()} == expected
        some = {by_name["/odom"], by_name["/map"]}
        part = [*bag.messages(START + 1, START + 500_000_000, some)]
        assert Counter(each.channel for each in part) == {by_name["/odom"]: 10}
        assert bag.newest(bag.end, some).keys() == some
        for number, message in bag.newest(bag.end).items():
            RosDecoder.of(bag.channels[number]).decode(message.payload)
        assert bag.faults == []


@pytest.mark.parametrize("version", [8, 9])
@pytest.mark.parametrize(
    ("storage", "mode"),
    [
        *itertools.product(
            [StoragePlugin.SQLITE3, StoragePlugin.MCAP],
            [None, CompressionMode.FILE, CompressionMode.MESSAGE],
        ),
        (StoragePlugin.MCAP, CompressionMode.STORAGE),
    ],
)
def test_folders_of_rosbag2_are_read(
    tmp_path: Path, version: int, storage: StoragePlugin, mode: CompressionMode | None
) -> None:
    folder = ros_bags.write_bag(
        tmp_path / "bag", storage=storage, version=version, compression=mode, content=CONTENT
    )
    check(folder)
    (folder / "metadata.yaml").unlink()
    check(folder)
    check(next(each for each in folder.iterdir() if ".mcap" in each.name or ".db3" in each.name))


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("options", [{}, {"use_chunking": False}, {"chunk_size": 999}, "no index"])
def test_files_of_other_mcap_writers_are_read(
    tmp_path: Path, compression: CompressionType, options: dict[str, object] | str
) -> None:
    if isinstance(options, str):
        options = {
            "index_types": IndexType.NONE,
            "use_statistics": False,
            "use_summary_offsets": False,
            "repeat_schemas": False,
            "repeat_channels": False,
        }
    check(ros_bags.write_mcap(tmp_path / "a.mcap", CONTENT, compression=compression, **options))


def test_splits_are_one_time_line(tmp_path: Path) -> None:
    for at, name in enumerate(("z.mcap", "b.mcap", "c.mcap")):
        # Splits of several recorders overlap in time.
        ros_bags.write_mcap(tmp_path / name, CONTENT[at::3])
    with Bag.open(tmp_path) as bag:
        assert Counter(read(bag)) == Counter(CONTENT)
        stamps = [each.stamp for each in bag.messages()]
        assert stamps == sorted(stamps)
        assert len(bag.channels) == len({each[0] for each in CONTENT})
        names = {number: topic.name for number, topic in bag.channels.items()}
        for stamp in (START, START + 1_234_567_890, bag.end):
            expected = {topic: at for topic, _, at, _ in CONTENT if at <= stamp}
            assert {names[n]: each.stamp for n, each in bag.newest(stamp).items()} == expected


def test_one_bad_split_leaves_the_others(tmp_path: Path) -> None:
    ros_bags.write_mcap(tmp_path / "a.mcap", CONTENT[:50])
    (tmp_path / "b.mcap").write_bytes(b"nothing")
    (tmp_path / "c.db3.zstd").write_bytes(zstandard.compress(b"nothing"))
    (tmp_path / "metadata.yaml").write_text("relative_file_paths:\n  - a.mcap\n  - 'gone.db3'\n")
    with Bag.open(tmp_path) as bag:
        assert len(read(bag)) == 50
        said = "\n".join(bag.faults)
        assert "b.mcap cannot be read" in said
        assert "c.db3" in said
        assert "gone.db3, which is missing" in said


@pytest.mark.parametrize("content", ["", "empty", "text"])
def test_what_is_no_bag_is_refused(tmp_path: Path, content: str) -> None:
    path = tmp_path / "bag"
    if content == "empty":
        path.mkdir()
    elif content:
        path.write_text("SELECT")
    with pytest.raises(RecordingError, match=f"{path}.* (does not exist|cannot be read)"):
        Bag.open(path)


def test_cut_and_flipped_bags_are_read_as_far_as_they_go(whole: Path, tmp_path: Path) -> None:
    database = next(whole.glob("*.db3"))
    log = ros_bags.write_mcap(tmp_path / "whole.mcap", CONTENT, chunk_size=4096)
    chance = random.Random(4)
    seen = Counter[str]()
    for source in (database, log):
        data = source.read_bytes()
        for _ in range(60):
            broken = bytearray(data[: chance.choice([len(data), chance.randrange(len(data))])])
            for _ in range(chance.randrange(6)):
                if broken:
                    broken[chance.randrange(len(broken))] ^= 1 << chance.randrange(8)
            path = tmp_path / f"broken{source.suffix}"
            path.write_bytes(broken)
            try:
                with Bag.open(path) as bag:
                    messages = [*bag.messages()]
                    bag.newest(START + 10**9)
                    seen[f"{source.suffix} {bool(messages)}"] += 1
            except RecordingError:
                seen[f"{source.suffix} refused"] += 1
    assert seen[".mcap True"] > 20
    assert seen[".db3 True"] > 5


@pytest.mark.parametrize("share", [0.2, 0.5, 0.95])
def test_a_cut_database_has_the_messages_before_the_cut(
    whole: Path, tmp_path: Path, share: float
) -> None:
    data = next(whole.glob("*.db3")).read_bytes()
    path = tmp_path / "cut.db3"
    path.write_bytes(data[: int(share * len(data))])
    with Bag.open(path) as bag:
        found = Counter(read(bag))
        assert found <= Counter(CONTENT)
        assert found.total() > (share - 0.15) * len(CONTENT)
        assert "it is cut, or its head is damaged" in bag.faults


def test_a_damaged_page_costs_its_messages_only(whole: Path, tmp_path: Path) -> None:
    path = changed(whole, tmp_path, "DROP INDEX timestamp_idx")
    data = bytearray(path.read_bytes())
    place = data.index(CONTENT[len(CONTENT) // 2][3][:60]) // 4096 * 4096
    data[place : place + 4096] = b"\xff" * 4096
    path.write_bytes(data)
    with Bag.open(path) as bag:
        found = {each[2] for each in read(bag)}
        assert {CONTENT[0][2], CONTENT[-1][2]} <= found
        assert "a part of it cannot be read" in bag.faults[0]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("share", [0.5, 0.8])
def test_what_is_left_of_a_cut_part_is_read_if_wanted(
    tmp_path: Path, compression: CompressionType, share: float
) -> None:
    chance = random.Random(1)
    entries = [("/a", "std_msgs/msg/Float64", START + n, chance.randbytes(900)) for n in range(900)]
    path = ros_bags.write_mcap(
        tmp_path / "one.mcap", entries, compression=compression, chunk_size=1 << 30
    )
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with Bag.open(path) as bag:
        assert not read(bag)
    with Bag.open(path, partial=True) as bag:
        found = Counter(read(bag))
        assert found <= Counter(entries)
        assert found.total() > (share - 0.3) * len(entries)
        assert any("which may be wrong" in each for each in bag.faults)


@pytest.mark.parametrize("indexed", [True, False])
def test_a_flipped_bit_costs_one_message_if_wanted(tmp_path: Path, *, indexed: bool) -> None:
    options = {} if indexed else {"index_types": IndexType.NONE}
    path = ros_bags.write_mcap(tmp_path / "one.mcap", CONTENT, chunk_size=1 << 30, **options)
    data = bytearray(path.read_bytes())
    data[data.index(CONTENT[-20][3]) + 50] ^= 4
    path.write_bytes(data)
    with Bag.open(path, partial=True) as bag:
        found = read(bag)
        assert len(found) == len(CONTENT)
        assert (Counter(found) & Counter(CONTENT)).total() == len(CONTENT) - 1
        assert any("which may be wrong" in each for each in bag.faults)


HOSTILE = {
    "a view in place of the messages": (
        "DROP TABLE messages; CREATE VIEW messages AS WITH RECURSIVE n(i) AS "
        "(SELECT 1 UNION ALL SELECT i + 1 FROM n) "
        "SELECT i id, 1 topic_id, i timestamp, 'x' data FROM n"
    ),
    "no topics": "DROP TABLE topics",
}
STRANGE = {
    "texts in place of numbers": (
        "UPDATE messages SET timestamp = 'now', topic_id = 'x' WHERE id > 5"
    ),
    "times before the epoch and after the end": (
        "UPDATE messages SET timestamp = -5 WHERE id = 3; "
        "UPDATE messages SET timestamp = 9223372036854775807 WHERE id = 4"
    ),
    "no bytes": "UPDATE messages SET data = 7 WHERE id % 2 = 0",
    "a definition that is none": (
        "UPDATE message_definitions SET encoded_message_definition = x'ff00'"
    ),
    "no definitions": "DROP TABLE message_definitions",
    "topics of no type": "UPDATE topics SET type = '', serialization_format = 'x'",
}


def changed(whole: Path, folder: Path, orders: str) -> Path:
    path = folder / "changed.db3"
    shutil.copy(next(whole.glob("*.db3")), path)
    with sqlite3.connect(path) as database:
        database.executescript(orders)
    database.close()
    return path


@pytest.mark.parametrize("orders", HOSTILE.values(), ids=HOSTILE)
def test_databases_that_compute_are_refused(whole: Path, tmp_path: Path, orders: str) -> None:
    with pytest.raises(RecordingError, match="no bag of rosbag2"):
        Bag.open(changed(whole, tmp_path, orders))


@pytest.mark.parametrize("orders", STRANGE.values(), ids=STRANGE)
def test_strange_rows_are_left_out(whole: Path, tmp_path: Path, orders: str) -> None:
    with Bag.open(changed(whole, tmp_path, orders)) as bag:
        messages = [*bag.messages()]
        assert len(messages) >= 5
        assert bag.newest(bag.end)


def test_large_databases_are_not_read_to_open_them(
    whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hub.recording.ros.sqlite_rows.MOST_COUNTED", 5)
    monkeypatch.setattr("hub.recording.ros.sqlite_rows.MOST_BACK", 3)
    check(whole)
    database = next(whole.glob("*.db3"))
    check(database)
    counted = Counter(each[0] for each in CONTENT)
    for path in (whole, database):
        with Bag.open(path) as bag:  # metadata.yaml says it
            assert {bag.channels[n].name: count for n, count in bag.counts.items()} == counted
    monkeypatch.setattr(MessageRows, "learn", None)
    with Bag.open(whole) as bag:
        assert next(bag.messages(bag.end)).stamp == bag.end


@pytest.mark.parametrize("counted", [5, 10**9])
def test_databases_without_an_index_are_read(
    whole: Path, tmp_path: Path, counted: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hub.recording.ros.sqlite_rows.MOST_COUNTED", counted)
    check(changed(whole, tmp_path, "DROP INDEX timestamp_idx"))


@pytest.mark.parametrize("damage", [b"\xff", b"\x00", b"\x0a"])
def test_a_damaged_index_loses_no_message(whole: Path, tmp_path: Path, damage: bytes) -> None:
    path = changed(whole, tmp_path, "")
    with sqlite3.connect(path) as database:
        query = "SELECT rootpage FROM sqlite_master WHERE name = 'timestamp_idx'"
        (page,) = database.execute(query).fetchone()
        (size,) = database.execute("PRAGMA page_size").fetchone()
    database.close()
    data = bytearray(path.read_bytes())
    data[(page - 1) * size + 12 : page * size] = damage * (size - 12)
    path.write_bytes(data)
    with Bag.open(path) as bag:
        assert Counter(read(bag)) == Counter(CONTENT)


@pytest.mark.parametrize("whole_journal", [True, False])
def test_messages_in_a_journal_are_read(
    whole: Path, tmp_path: Path, *, whole_journal: bool
) -> None:
    path = changed(whole, tmp_path, "PRAGMA journal_mode = WAL")
    with sqlite3.connect(path) as writer:
        writer.execute("PRAGMA wal_autocheckpoint = 0")
        writer.execute("DELETE FROM messages WHERE id = 1")
        writer.commit()
        journal = tmp_path / f"{path.name}-wal"
        copied = tmp_path / "copy" / path.name
        copied.parent.mkdir()
        shutil.copy(path, copied)
        (copied.parent / journal.name).write_bytes(
            journal.read_bytes() if whole_journal else b"nothing"
        )
    writer.close()
    with Bag.open(copied) as bag:
        assert len(read(bag)) == len(CONTENT) - whole_journal
        assert bag.faults == []


def test_a_packed_bomb_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hub.recording.ros.bag.LEAST_FREE", 1 << 60)
    path = tmp_path / "a.db3.zstd"
    path.write_bytes(zstandard.compress(bytes(1 << 26)))
    with pytest.raises(RecordingError, match="has no room for it"):
        Bag.open(path)


def test_parts_without_the_wanted_topics_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    odometry = [each for each in CONTENT if each[0] == "/odom"]
    pictures = [each for each in CONTENT if each[0] == "/camera/image_raw"]
    ros_bags.write_mcap(path, [*odometry, *pictures], chunk_size=40_000)
    data = bytearray(path.read_bytes())
    place = data.rindex(pictures[-1][3][200:300])
    data[place : place + 50] = bytes(50)  # the checksum of its part is wrong now
    path.write_bytes(data)
    with Bag.open(path) as bag:
        by_name = {topic.name: number for number, topic in bag.channels.items()}
        assert len([*bag.messages(channels={by_name["/odom"]})]) == len(odometry)
        assert bag.faults == []
        assert len([*bag.messages()]) < len(odometry) + len(pictures)
        assert bag.faults != []
