"""Other tools read these files, and files of other writers are read, whatever their options."""

from __future__ import annotations

import dataclasses
import io
import itertools
from pathlib import Path

import pytest
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.writer import CompressionType, IndexType, Writer
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from hub.errors import RecordingError
from hub.gcm.battery import BATTERY as MESSAGE
from hub.ipc.definition import MessageDefinition
from hub.recording.anchor import TimeAnchor
from hub.recording.encoder import McapEncoder
from hub.recording.new_recording import NewRecording
from hub.recording.reader import Recording
from hub.recording.topics import RecordedTopic, topic_of
from hub.recording.writer import RecordingWriter, WriterLimits
from hub.values import dataclass

ANCHOR = TimeAnchor(1_700_000_000_000_000_000, 50.0)
COUNT = 300


def test_the_mcap_library_reads_all_that_was_written(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    limits = WriterLimits(chunk_bytes=2000, least_free=0)
    writer = RecordingWriter(path, ANCHOR, {"layout": "search"}, limits)
    topics = [RecordedTopic(f"/rover/T{n}", "a/msg/B", "ros2msg", b"int8 x\n") for n in range(3)]
    writer.attach("search.xml", "application/xml", b"<layout/>", 50.0)
    for number in range(1, COUNT + 1):
        topic = topics[number % 3]
        writer.add(topic, [b"ab", bytes(number)], 50 + number / 10, 49.0, number)
    writer.close()
    content = path.read_bytes()
    for kind in (SeekingReader, NonSeekingReader):
        summary = kind(io.BytesIO(content), validate_crcs=True).get_summary()
        assert summary.statistics.message_count == COUNT
        assert summary.statistics.channel_message_counts == {1: 100, 2: 100, 3: 100}
        assert summary.statistics.message_start_time == ANCHOR.stamp(50.1)
        assert summary.statistics.message_end_time == ANCHOR.stamp(80.0)
        assert [len(each) for each in (summary.schemas, summary.channels)] == [1, 3]

    def reader() -> SeekingReader:
        return SeekingReader(io.BytesIO(content), validate_crcs=True)

    read = [
        (schema.name, channel.topic, message.sequence, message.log_time, len(message.data))
        for schema, channel, message in reader().iter_messages()
    ]
    (attachment,) = reader().iter_attachments()
    _, metadata = reader().iter_metadata()
    assert read == [
        ("a/msg/B", f"/rover/T{number % 3}", number, ANCHOR.stamp(50 + number / 10), number + 2)
        for number in range(1, COUNT + 1)
    ]
    assert (attachment.name, attachment.data) == ("search.xml", b"<layout/>")
    assert metadata.metadata["layout"] == "search"


def test_no_part_of_a_file_begins_in_1970(tmp_path: Path) -> None:
    """Other tools take the begin of a file from those of its parts."""
    encoder = McapEncoder()
    topic = RecordedTopic("/t", "a/msg/B", "ros2msg", b"int8 x\n")
    parts = [encoder.begin()]
    first, second = encoder.register(topic), encoder.register(dataclasses.replace(topic, name="/u"))
    parts += [encoder.end_chunk(), encoder.attachment("a", "b", b"c", 1)]
    encoder.add(first, 10**18, 10**18, 1, b"x")
    parts += [encoder.end_chunk(), encoder.end()]
    (tmp_path / "cut.mcap").write_bytes(b"".join(parts[:-1]))
    with Recording.open(tmp_path / "cut.mcap") as recording:
        assert [each.payload for each in recording.messages()] == [b"x"]
    reader = SeekingReader(io.BytesIO(b"".join(parts)), validate_crcs=True)
    summary = reader.get_summary()
    assert summary.channels.keys() == {first, second}
    assert [each.message_start_time for each in summary.chunk_indexes] == [10**18]
    assert [message.data for _, _, message in reader.iter_messages()] == [b"x"]


@dataclass(frozen=True, slots=True)
class Nothing:
    """ROS 2 writes a byte for it, Rune none."""


def test_a_message_that_ros_has_no_type_for_has_a_named_one(tmp_path: Path) -> None:
    """rosbag2 reads no topic of a file where one has no schema."""
    definition = MessageDefinition(name="TEST_Nothing", type=Nothing)
    path = tmp_path / "x.mcap"
    with NewRecording(path) as new:
        new.add(topic_of("rover", definition), 1, 1, 1, b"")
    with path.open("rb") as file:
        ((schema, channel, message),) = SeekingReader(file, validate_crcs=True).iter_messages()
    assert schema is not None
    assert (schema.name, schema.encoding, schema.data) == ("rune_msgs/msg/TESTNothing", "", b"")
    assert (channel.topic, message.data) == ("/rover/TEST_Nothing", b"")


@pytest.mark.parametrize("compression", ["lz4", "zstd", "none"])
def test_rosbags_reads_messages_of_the_hub(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "x.mcap"
    topic = topic_of("rover", MESSAGE)
    with NewRecording(path, compression=compression) as new:
        for number in range(20):
            new.add(topic, number, number, number, MESSAGE.encode(MESSAGE.type()))
    with AnyReader([path], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        stamps = [
            stamp
            for connection, stamp, raw in reader.messages()
            if reader.deserialize(raw, connection.msgtype)
        ]
    assert stamps == list(range(20))


OPTIONS = list(
    itertools.product(
        (True, False),  # chunks
        (CompressionType.NONE, CompressionType.LZ4, CompressionType.ZSTD),
        (IndexType.ALL, IndexType.NONE, IndexType.CHUNK, IndexType.MESSAGE),
        (True, False),  # definitions at the end
        (True, False),  # statistics and offsets
    )
)


@pytest.mark.parametrize("cut", [False, True])
def test_files_of_other_writers_are_read_whatever_their_options(
    tmp_path: Path, *, cut: bool
) -> None:
    for number, (chunks, compression, indexes, repeat, statistics) in enumerate(OPTIONS):
        path = tmp_path / f"{number}.mcap"
        with path.open("wb") as file:
            writer = Writer(
                file,
                chunk_size=500,
                compression=compression,
                index_types=indexes,
                repeat_channels=repeat,
                repeat_schemas=repeat,
                use_chunking=chunks,
                use_statistics=statistics,
                use_summary_offsets=statistics,
            )
            writer.start("", "another")
            schema = writer.register_schema("a/msg/B", "ros2msg", b"int8 x\n")
            channels = [writer.register_channel(f"/t{n}", "cdr", schema) for n in range(3)]
            for stamp in range(COUNT):
                writer.add_message(channels[stamp % 3], stamp, bytes(stamp), stamp, stamp)
            writer.finish()
        if cut:
            path.write_bytes(path.read_bytes()[:20_000])
        with Recording.open(path) as recording:
            topics = [topic for _, topic in sorted(recording.channels.items())]
            assert [topic.name for topic in topics] == ["/t0", "/t1", "/t2"]
            assert {topic.schema for topic in topics} == {b"int8 x\n"}
            stamps = [each.stamp for each in recording.messages()]
            assert stamps == list(range(len(stamps)))
            if cut:
                assert 30 < len(stamps) < COUNT or compression != CompressionType.NONE
            else:
                assert (len(stamps), recording.finished, recording.faults) == (COUNT, True, [])
            assert recording.newest(100)[channels[0]].stamp == 99


def test_a_new_recording_replaces_nothing_unasked_and_leaves_nothing_behind(
    tmp_path: Path,
) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(b"old")
    with pytest.raises(RecordingError, match=r"x\.mcap exists; choose another name"):
        NewRecording(path)
    with pytest.raises(KeyError), NewRecording(path, replace=True):
        raise KeyError
    assert [each.name for each in tmp_path.iterdir()] == ["x.mcap"]
    assert path.read_bytes() == b"old"
    with NewRecording(path, replace=True) as new:
        new.add(RecordedTopic("/t"), 1, 1, 1, b"x")
    with Recording.open(path) as recording:
        assert [each.payload for each in recording.messages()] == [b"x"]
    with pytest.raises(RecordingError, match="exists"), NewRecording(tmp_path / "y.mcap"):
        (tmp_path / "y.mcap").write_bytes(b"came meanwhile")
    assert sorted(each.name for each in tmp_path.iterdir()) == ["x.mcap", "y.mcap"]
    with pytest.raises(RecordingError, match="No such file or directory"):
        NewRecording(tmp_path / "no" / "x.mcap")
