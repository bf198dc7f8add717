"""Keys of a replay: notes beside the recording, clips, and the page of the keys."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from rune_tui.replay.clip_writer import ClipWriter
from rune_tui.replay.console_log import ConsoleLog
from rune_tui.replay.desk import Desk
from rune_tui.replay.player import Player
from rune_tui.replay.review_keys import TASKS, ReviewTask
from rune_tui.replay.review_notes import LONGEST, ReviewNotes
from rune_tui.replay.source import EventKind
from tests.console.replay.logged_session import logged_session
from tests.support.waiting import until

SECOND = 1_000_000_000


class Review:
    """A desk with a recording, its notes and its clips."""

    def __init__(self, path: Path) -> None:
        self.path = path
        opened = partial(ConsoleLog, path)
        self.player = Player(opened)
        self.player.seek(self.player.source.start)
        self.notes, self.clips = ReviewNotes(path), ClipWriter(opened, path)
        self.desk = Desk(self.player, lambda: 0.0, self.notes, self.clips)

    def type(self, text: str) -> None:
        for letter in text:
            self.desk.key(letter, letter)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.desk.key(key, None)

    @property
    def head(self) -> str:
        return self.desk.words(400)[0]

    def close(self) -> None:
        self.clips.close()
        self.player.close()


@pytest.fixture
def review(tmp_path: Path) -> Iterator[Review]:
    with closing(Review(logged_session(tmp_path, 4))) as opened:
        yield opened


def test_a_note_goes_beside_the_recording_and_onto_the_timeline(review: Review) -> None:
    before = review.path.read_bytes()
    review.press("right")
    review.type("mq: a ñ")
    assert "note: q: a ñ_" in review.head
    review.press("enter")
    assert "noted in session.mcap.notes.jsonl" in review.head
    (event,) = review.desk.overview.events
    assert (event.kind, event.text, event.stamp) == (
        EventKind.NOTE,
        "q: a ñ",
        review.player.position,
    )
    assert "·" in review.desk.words(100)[1]
    assert ReviewNotes(review.path).events == [event]
    assert review.path.read_bytes() == before
    (line,) = review.notes.path.read_text().splitlines()
    assert json.loads(line)["stamp"] == event.stamp


def test_an_empty_note_and_a_dropped_one_are_not_kept(review: Review) -> None:
    review.type("m  ")
    review.press("enter")
    assert "a note without words is not kept" in review.head
    review.type("mx")
    review.press("escape")
    review.type("m" + LONGEST * "y" + "z")
    review.press("enter")
    (event,) = review.notes.events
    assert event.text == LONGEST * "y"


def test_damaged_notes_are_counted_and_later_ones_are_whole(review: Review) -> None:
    lines = [b'{"stamp": 5, "text": "kept"}', b"[]", b'{"stamp": 1e9, "text": "x"}', b'{"stamp": 7']
    review.notes.path.write_bytes(b"\n".join(lines))
    notes = ReviewNotes(review.path)
    assert [event.text for event in notes.events] == ["kept"]
    assert notes.fault == "3 of 4 lines of session.mcap.notes.jsonl are no notes"
    notes.add(9, "later", "jane")
    assert [event.text for event in ReviewNotes(review.path).events] == ["kept", "later"]


def test_notes_that_cannot_be_written_say_so(review: Review) -> None:
    review.notes.path.mkdir()
    review.type("mx")
    review.press("enter")
    assert "the note is not kept" in review.head
    assert ReviewNotes(review.path).fault


def test_a_clip_is_written_from_one_press_to_the_other(review: Review) -> None:
    review.press("x")
    assert "clip from 0:00.0, X ends it" in review.head
    review.press("x")
    assert "another time" in review.head
    review.player.seek(review.player.source.start + SECOND)
    review.press("x")
    until(lambda: "is written" in review.head, 20.0)
    (path,) = review.path.parent.glob("session.mcap.clip-0m00.0s-0m01.0s.*")
    assert path.stat().st_size
    review.press("x", "escape")
    assert "clip from" not in review.head


def test_a_clip_that_is_dropped_leaves_nothing(review: Review) -> None:
    review.press("x", "end", "x", "q")
    assert not review.desk.ended
    assert "a clip is still written" in review.head
    review.press("q")
    assert review.desk.ended
    review.clips.close()
    assert not [*review.path.parent.glob("*clip*")]


def test_many_jumps_before_a_frame_are_one(review: Review) -> None:
    review.press(*["right"] * 40, "home", "right")
    review.desk.go(-3.0)
    assert review.player.position == review.player.source.start
    review.desk.settle()
    assert review.player.position == review.player.source.end - 3 * SECOND
    review.press("home")
    review.type("x")  # it is about the time that the person wants
    assert "clip from 0:00.0" in review.head


def test_the_page_of_the_keys_opens_and_closes(review: Review) -> None:
    plain = review.desk.cells(100, 30).checksum
    review.type("?")
    assert review.desk.cells(100, 30).checksum != plain
    assert review.desk.cells(8, 5).columns == 8
    review.type("m")  # any key closes it, and does nothing else
    assert review.desk.cells(100, 30).checksum == plain
    review.type("?q")
    assert review.desk.ended


def test_each_key_has_one_task() -> None:
    names = [name for task in ReviewTask for name in task.value.names]
    assert len(names) == len(set(names)) == len(TASKS)
