"""Which part of a recording is meant: topics, robots, and a span of time in words."""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterator
from typing import NamedTuple

from hub.errors import CodecError, RecordingError
from hub.gcm.recording import RECORD_MARK
from hub.recording.live.words import seconds_of
from hub.recording.recording_set import RecordingSet
from hub.toml_reader import RefusedError
from hub.values import dataclass

_SECOND = 1_000_000_000
_LEAST_EPOCH_S = 1e8
"""Numbers from here on are dates [s since 1970]."""
_OFFSET = re.compile(r"([+-])\s*(.+)")


class LoggedMark(NamedTuple):
    """A moment that an operator marked.

    Attributes:
        number: Its number.
        stamp: When it was logged [ns].
        text: What it is about.
    """

    number: int
    stamp: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """A part of a recording.

    Attributes:
        topics: Expressions; a topic is meant if its name has one of them; none: all topics.
        exclude: Expressions that its name has not.
        robots: The robots whose topics are meant; none: all.
        start: The first moment, in words; empty: the first message.
        end: The last; empty: the last message.
        around: Number or text of the mark that is meant instead; empty: none.
        before_s: How much is before the mark [s].
        after_s: How much is after it [s].
    """

    topics: tuple[re.Pattern[str], ...] = ()
    exclude: tuple[re.Pattern[str], ...] = ()
    robots: tuple[str, ...] = ()
    start: str = ""
    end: str = ""
    around: str = ""
    before_s: float = 30.0
    after_s: float = 10.0

    def channels(self, recording: RecordingSet) -> set[int]:
        """The channels that are meant.

        Raises:
            RecordingError: There are none, though the recording has some.
        """
        found = {
            number
            for number, topic in recording.channels.items()
            if (not self.topics or any(each.search(topic.name) for each in self.topics))
            and not any(each.search(topic.name) for each in self.exclude)
            and (not self.robots or topic.robot in self.robots)
        }
        if not found and recording.channels:
            text = f"no topic of {recording.path} is meant; `rune-hub log info` shows all"
            raise RecordingError(text)
        return found

    def span(self, recording: RecordingSet) -> tuple[int, int]:
        """The first and the last stamp [ns].

        Raises:
            RecordingError: The words are no times, or nothing lies between them.
        """
        first, last = recording.start, recording.end
        if self.around:
            mark = _meant(self.around, list(marks_of(recording)))
            first = mark.stamp - round(self.before_s * _SECOND)
            last = mark.stamp + round(self.after_s * _SECOND)
        if self.start:
            first = time_of(self.start, recording)
        if self.end:
            last = time_of(self.end, recording)
        if first > last or first > recording.end or last < recording.start:
            text = (
                f"{recording.path} has no messages in that span; "
                f"it goes from {date(recording.start)} to {date(recording.end)}"
            )
            raise RecordingError(text)
        return max(0, first), last


def marks_of(recording: RecordingSet) -> Iterator[LoggedMark]:
    """The marks of a recording, in order."""
    channels = {
        number for number, topic in recording.channels.items() if topic.message == RECORD_MARK.name
    }
    if not channels:
        return
    for message in recording.messages(channels=channels):
        try:
            mark = RECORD_MARK.decode(message.payload)
        except CodecError:
            continue
        yield LoggedMark(mark.number, message.stamp, mark.text)


def time_of(words: str, recording: RecordingSet) -> int:
    """The moment that words mean [ns].

    Args:
        words: "+90s" after the start, "-10 s" before the end, or seconds since 1970. A date is
            "2026-11-22 14:03:22", with or without a zone; "14:03:22" is on the day of the start.
        recording: What it is a moment of.

    Raises:
        RecordingError: They are no moment.
    """
    offset = _OFFSET.fullmatch(words.strip())
    try:
        if offset:
            seconds = round(seconds_of(offset[2]) * _SECOND)
            return recording.start + seconds if offset[1] == "+" else recording.end - seconds
        if words.replace(".", "", 1).isdigit() and float(words) >= _LEAST_EPOCH_S:
            return min(round(float(words) * _SECOND), 2**63)
        if ":" in words and "-" not in words:
            day = datetime.datetime.fromtimestamp(recording.start / 1e9).astimezone().date()
            words = f"{day} {words}"
        moment = datetime.datetime.fromisoformat(words)
        zoned = moment if moment.tzinfo else moment.astimezone()
        return max(0, round(zoned.timestamp() * 1e6) * 1000)
    except (RefusedError, ValueError, OverflowError, OSError) as error:
        text = (
            f"{words[:80]!r} is no time; write +90s (after the start), -10s (before the end), "
            "14:03:22 or '2026-11-22 14:03:22'"
        )
        raise RecordingError(text) from error


def date(stamp: int) -> str:
    """A stamp [ns] as date and time of this machine's zone."""
    try:
        moment = datetime.datetime.fromtimestamp(stamp / 1e9).astimezone()
    except (ValueError, OverflowError, OSError):
        return f"{stamp} ns"
    return moment.strftime("%Y-%m-%d %H:%M:%S.%f")[:-3]


def _meant(words: str, marks: list[LoggedMark]) -> LoggedMark:
    """The mark of a number or a text.

    Raises:
        RecordingError: There is none, or several.
    """
    found = [each for each in marks if str(each.number) == words] or [
        each for each in marks if words.casefold() in each.text.casefold()
    ]
    if len(found) == 1:
        return found[0]
    known = "; ".join(f"{each.number} {each.text}".strip() for each in marks[:20]) or "none"
    text = f"{len(found)} marks are {words[:80]!r}; the marks are: {known[:400]}"
    raise RecordingError(text)
