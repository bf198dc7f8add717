"""Opens recordings for `rune replay`."""

from __future__ import annotations

import dataclasses
import functools
import os
import tempfile
import time
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from hub.gcm.catalog import BY_NAME
from hub.recording.anchor import TimeAnchor
from hub.recording.recording_set import RecordingSet
from rune_tui.errors import DamagedLogError, LogError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.model.own_records import RUNE_TERMINAL, TerminalRecord
from rune_tui.replay.bag_source import BagSource
from rune_tui.replay.console_log import ConsoleLog, has_frames
from rune_tui.replay.desk import SECOND, entered
from rune_tui.replay.logged_robot import (
    LoggedRobot,
    channels_of,
    described,
    robots_in,
    same_robots,
)
from rune_tui.replay.logged_values import Decoder
from rune_tui.replay.player import Player
from rune_tui.replay.source import ReplaySource
from rune_tui.replay.timed_log import TimedLog, paired
from rune_tui.replay.topic_choice import TopicChoice
from rune_tui.startup.auto_layout import layout_text
from rune_tui.startup.opening import open_layout


def open_source(
    files: Sequence[Path],
    layout: LayoutSpec | None,
    choice: TopicChoice | None = None,
    *,
    topics: bool = False,
    unpacked: int = 0,
) -> ReplaySource:
    """The recordings of some files as one source.

    Args:
        files: The files, of one mission.
        layout: A layout that shows them; None: the recorded one, or one made for the recording.
        choice: The topic that is looked at, where the layout shows topics.
        topics: Whether to show the topics alone, also those of Rune.
        unpacked: Most bytes that are unpacked of each file; 0: by its size.

    Raises:
        RecordingError: A file cannot be read.
        LogError: There is nothing in them that can be shown.
    """
    if layout is None and not topics:
        for path in files:
            with RecordingSet.open([path], unpacked=unpacked) as one:
                framed = has_frames(one)
            if framed:
                others = [other for other in files if other != path]
                return ConsoleLog(path, others, unpacked=unpacked)
    recording = RecordingSet.open(files, partial=True, unpacked=unpacked)
    try:
        recording.drop_outliers()
        if next(recording.messages(), None) is None and recording.faults:
            reason = "; ".join((f"nothing of {recording.path} can be read", *recording.faults[:3]))
            raise DamagedLogError(reason)
        of_rune = any(topic.message in BY_NAME for topic in recording.channels.values())
        if topics or not of_rune:
            return BagSource(recording, layout, choice)
        return _timed(recording, layout)
    except BaseException:
        recording.close()
        raise


def _timed(recording: RecordingSet, layout: LayoutSpec | None) -> TimedLog:
    faults: list[str] = []
    # Stamps count from here, so that small numbers stay exact.
    anchor = recording.anchor or TimeAnchor(recording.start, 0.0)
    decoder = Decoder(recording.channels, anchor, faults)
    names = robots_in(recording, decoder)
    if not names:
        reason = f"{recording.path} has no messages of a robot that Rune knows"
        raise LogError(reason)
    groups = same_robots(names)
    channels = {name: channels_of(recording, decoder, all_) for name, all_ in groups.items()}
    if layout is None:
        layout = _made(recording, decoder, channels)
    roles = paired([each.name for each in layout.robots], {each: names[each] for each in groups})
    robots = {
        role: LoggedRobot(recording, channels.get(roles.get(role, ""), {}), decoder, anchor)
        for role in (each.name for each in layout.robots)
    }
    return TimedLog(recording, layout, robots, anchor, faults)


def _made(
    recording: RecordingSet, decoder: Decoder, channels: Mapping[str, Mapping[int, str]]
) -> LayoutSpec:
    """A layout made for the first robot that describes itself.

    Raises:
        LogError: None does.
    """
    for each in channels.values():
        body, capabilities = described(recording, decoder, each)
        if body is not None:
            with tempfile.TemporaryDirectory(prefix="rune-replay-") as folder:
                path = Path(folder) / "auto.xml"
                path.write_text(layout_text(body, capabilities, "127.0.0.1"), "utf-8")
                return dataclasses.replace(open_layout(path), path="auto", files=())
    reason = f"{recording.path} does not describe its robot; name a layout by --layout"
    reason += ", or show its topics by --topics"
    raise LogError(reason)


def opener(
    files: Sequence[Path], layout: LayoutSpec | None, *, topics: bool, unpacked: int = 0
) -> Callable[[], ReplaySource]:
    """The function that opens some files as `open_source` does.

    From then on, this process writes times of day as the first recording's console.

    Raises:
        RecordingError: The first file cannot be read.
    """
    follow_time_zone(files, unpacked)
    choice = TopicChoice()
    return functools.partial(open_source, files, layout, choice, topics=topics, unpacked=unpacked)


def follow_time_zone(files: Sequence[Path], unpacked: int = 0) -> None:
    """Have this process write times of day as the console did that made the first recording.

    Raises:
        RecordingError: The file cannot be read.
    """
    with RecordingSet.open(files[:1], unpacked=unpacked) as recording:
        decoder = Decoder(recording.channels, TimeAnchor(0, 0.0), [])
        terminals = {
            channel
            for channel, topic in recording.channels.items()
            if topic.message == RUNE_TERMINAL.name
        }
        first = next(recording.messages(channels=terminals), None) if terminals else None
        terminal = decoder.value(first) if first is not None else None
    if isinstance(terminal, TerminalRecord) and hasattr(time, "tzset"):
        minutes = -terminal.utc_offset_s // 60  # POSIX counts to the west
        sign = "-" if minutes < 0 else ""
        os.environ["TZ"] = f"LOG{sign}{abs(minutes) // 60}:{abs(minutes) % 60:02d}"
        time.tzset()


def moment_of(text: str, source: ReplaySource) -> int:
    """The moment of a recording that a text means [ns since 1970].

    Raises:
        LogError: It is no time, or the recording has no such time.
    """
    found = entered(text, source.start)
    if found is None:
        reason = f"{text[:40]!r} is no time; 90, 1:30 and 1:02:30 are"
        raise LogError(reason)
    if found > source.end:
        length = (source.end - source.start) / SECOND
        reason = f"{text[:40]} is after the end: {source.title} lasts {length:.1f} s"
        raise LogError(reason)
    return found


def player_of(opened: Callable[[], ReplaySource], options: Namespace) -> Player:
    """A player at the time, with the rate and the loop of the command line."""
    player = Player(opened, rate=options.rate, loop=options.loop)
    try:
        player.seek(moment_of(options.start, player.source))
    except BaseException:
        player.close()
        raise
    player.playing = True
    return player
