"""What is written is read back, in order, at any time, and from a cut file."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.errors import RecordingError
from hub.recording.anchor import TimeAnchor
from hub.recording.reader import LoggedMessage, Recording
from hub.recording.topics import RecordedTopic
from hub.recording.writer import RecordingWriter, WriterLimits

LIMITS = WriterLimits(chunk_bytes=200, least_free=0)
ANCHOR = TimeAnchor(1_700_000_000_000_000_000, 50.0)
_numbers = itertools.count()

ENTRIES = st.lists(
    st.tuples(st.integers(0, 3), st.integers(0, 40), st.binary(max_size=60)), max_size=60
)


def written(folder: Path, entries: list[tuple[int, int, bytes]]) -> Path:
    """A recording of messages: topic, tenths of seconds, payload."""
    path = folder / f"{next(_numbers)}.mcap"
    writer = RecordingWriter(path, ANCHOR, {"layout": "search"}, LIMITS)
    for number, (topic, tenths, payload) in enumerate(entries, 1):
        moment = 50 + tenths / 10
        writer.add(RecordedTopic(f"/rover/T{topic}"), [payload], moment, moment - 0.01, number)
    writer.close()
    assert writer.state.messages == len(entries)
    assert writer.state.bytes == path.stat().st_size
    return path


@settings(deadline=None)
@given(entries=ENTRIES)
def test_messages_come_back_in_the_order_of_their_stamps(
    tmp_path_factory: pytest.TempPathFactory, entries: list[tuple[int, int, bytes]]
) -> None:
    with Recording.open(written(tmp_path_factory.getbasetemp(), entries)) as recording:
        read = list(recording.messages())
        assert [(each.number, each.payload) for each in read] == [
            (number, payload)
            for number, (_, _, payload) in sorted(
                enumerate(entries, 1), key=lambda each: (each[1][1], each[0])
            )
        ]
        assert list(recording.messages(reverse=True)) == read[::-1]
        assert all(each.stamp - each.published == 10_000_000 for each in read)


def test_equal_stamps_keep_their_order_over_well_packed_parts(tmp_path: Path) -> None:
    """A part is longer unpacked than its distance to the next one in the file."""
    entries = [(0, 7, bytes(150))] * 200
    with Recording.open(written(tmp_path, entries)) as recording:
        assert [each.number for each in recording.messages()] == list(range(1, 201))
        backwards = [each.number for each in recording.messages(reverse=True)]
        assert backwards == list(range(200, 0, -1))


@settings(deadline=None)
@given(entries=ENTRIES, tenths=st.integers(-1, 41))
def test_the_newest_messages_are_the_last_ones_in_order(
    tmp_path_factory: pytest.TempPathFactory, entries: list[tuple[int, int, bytes]], tenths: int
) -> None:
    with Recording.open(written(tmp_path_factory.getbasetemp(), entries)) as recording:
        stamp = ANCHOR.stamp(50 + tenths / 10)
        want: dict[int, LoggedMessage] = {}
        for message in recording.messages(end=stamp):
            want[message.channel] = message
        assert recording.newest(stamp) == want


@settings(deadline=None)
@given(entries=ENTRIES, share=st.floats(0, 1))
def test_a_cut_file_has_its_first_messages(
    tmp_path_factory: pytest.TempPathFactory, entries: list[tuple[int, int, bytes]], share: float
) -> None:
    in_order = sorted(entries, key=lambda each: each[1])
    path = written(tmp_path_factory.getbasetemp(), in_order)
    whole = path.read_bytes()
    path.write_bytes(whole[: 8 + int(share * (len(whole) - 9))])
    with Recording.open(path) as recording:
        read = [each.payload for each in recording.messages()]
        assert read == [payload for _, _, payload in in_order][: len(read)]
        assert not recording.finished


def test_what_is_no_recording_is_refused_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(b"hello")
    with pytest.raises(RecordingError, match=r"x\.mcap cannot be read: it is no MCAP file"):
        Recording.open(path)


def test_metadata_clock_and_attachments_come_back(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    writer = RecordingWriter(path, ANCHOR, {"layout": "search"}, LIMITS)
    writer.attach("search.xml", "application/xml", b"<layout/>", 51.0)
    writer.close()
    with Recording.open(path) as recording:
        assert recording.anchor == ANCHOR
        assert recording.about["rune"]["layout"] == "search"
        (place,) = recording.attachments
        assert (place.name, recording.attachment(place)) == ("search.xml", b"<layout/>")
