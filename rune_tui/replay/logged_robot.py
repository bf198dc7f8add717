"""A robot of Rune's own recordings: its newest messages, from any writer."""

from __future__ import annotations

import itertools
import zlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.catalog import BY_NAME
from hub.gcm.diagnostics import DIAGNOSTICS, Diagnostics
from hub.gcm.mapping import MAP
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.supervision import CAPABILITY_REPORTS, CapabilityReports
from hub.gcm.vision import IMAGE
from hub.recording.anchor import TimeAnchor
from hub.recording.reader import LoggedMessage
from hub.recording.recording_set import RecordingSet
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.model.vehicle import with_message
from rune_tui.replay.logged_values import Decoder

_OTHERS = frozenset({"console", "study", "hub"})
"""First parts of topics that are no robots."""
_SEARCHED_NS = 10_000_000_000
"""How far back pictures and problems are searched [ns]."""


class LoggedRobot:
    """The messages of one robot; see `RobotOfLog`."""

    def __init__(
        self,
        recording: RecordingSet,
        channels: Mapping[int, str],
        decoder: Decoder,
        anchor: TimeAnchor,
    ) -> None:
        """Prepare.

        Args:
            recording: The files.
            channels: Names of its messages by channel.
            decoder: Decodes them.
            anchor: The clock.
        """
        self._recording = recording
        self._channels = channels
        self._decoder = decoder
        since = anchor.moment(recording.start)
        self._link = LinkState(phase=LinkPhase.CONNECTED, since=since, endpoint="recording")
        self._several = {
            channel for channel, name in channels.items() if name in (IMAGE.name, DIAGNOSTICS.name)
        }
        self._newest: dict[int, LoggedMessage] = {}
        self._state = RobotState(name="", link=self._link)

    def seek(self, stamp: int) -> None:
        """Go to a time [ns]: take the newest of each message at or before it."""
        self._newest = {}
        self._state = RobotState(name="", link=self._link)
        mine = set(self._channels)
        found = self._recording.newest(stamp, mine)
        recent = self._recording.messages(max(0, stamp - _SEARCHED_NS), stamp, self._several)
        for message in itertools.chain(found.values(), recent):
            self.take(message)

    def take(self, message: LoggedMessage) -> None:
        """Take the next message of the recording, of any robot."""
        if message.channel in self._several:
            self._use(message)
        elif message.channel in self._channels:
            self._newest[message.channel] = message

    def state(self, role: str) -> RobotState:
        """Its state now, under its name in the layout."""
        waiting, self._newest = self._newest, {}
        for message in sorted(waiting.values(), key=lambda each: each.stamp):
            self._use(message)
        return self._state.with_(name=role)

    def _use(self, message: LoggedMessage) -> None:
        received = self._decoder.received(message, message.stamp)
        if received is None:
            return
        name = self._channels[message.channel]
        if isinstance(received.value, Picture):
            camera = received.value.camera.name
            main = self._main_camera
            self._state = self._state.with_picture("" if camera == main else camera, received)
        elif isinstance(received.value, OccupancyMap):
            self._state = self._state.with_(map=received)
        else:
            self._state = with_message(self._state, name, received, _source_of(received))
            if isinstance(received.value, RobotBody):
                self._find_main_picture()

    def _find_main_picture(self) -> None:
        """Pictures that came before the description did not say that they are the main one's."""
        pictures = dict(self._state.pictures)
        early = pictures.pop(self._main_camera, None)
        if early is not None:
            self._state = self._state.with_(pictures=pictures, picture=self._state.picture or early)

    @property
    def _main_camera(self) -> str:
        body = self._state.body
        return body.cameras[0].name if body is not None and body.cameras else ""


def _source_of(received: Received[Any]) -> int:
    """A number for the publisher of problems: recordings do not name it, but its parts."""
    if not isinstance(received.value, Diagnostics):
        return 0
    names = {each.name.partition(":")[0] for each in received.value.status}
    return zlib.crc32(" ".join(sorted(names)).encode())


def robots_in(recording: RecordingSet, decoder: Decoder) -> dict[str, str]:
    """The robots of recordings: their names in topics, and their own; empty: not known."""
    names: dict[str, str] = {}
    for topic in recording.channels.values():
        if topic.robot and topic.robot not in _OTHERS and topic.message in BY_NAME:
            names.setdefault(topic.robot, "")
    for channel, topic in recording.channels.items():
        if topic.message == ROBOT_DESCRIPTION.name and topic.robot in names:
            first = next(recording.messages(channels={channel}), None)
            body = decoder.value(first) if first is not None else None
            if isinstance(body, RobotBody) and body.name:
                names[topic.robot] = body.name
    return names


def same_robots(names: Mapping[str, str]) -> dict[str, list[str]]:
    """The names in topics that mean one robot, by the first of them."""
    groups: dict[str, list[str]] = {}
    for name, own in names.items():
        known = next((first for first in groups if own and own in (first, names[first])), None)
        groups.setdefault(known or name, []).append(name)
    return groups


def channels_of(recording: RecordingSet, decoder: Decoder, names: Sequence[str]) -> dict[int, str]:
    """The channels of a robot with several names in topics; of equal messages the most frequent."""
    found: defaultdict[str, list[int]] = defaultdict(list)
    for channel, topic in recording.channels.items():
        if topic.robot in names and decoder.definition(channel) is not None:
            found[topic.message].append(channel)
    return {
        max(channels, key=lambda each: recording.counts.get(each, 0)): name
        for name, channels in found.items()
    }


def described(
    recording: RecordingSet, decoder: Decoder, channels: Mapping[int, str]
) -> tuple[RobotBody | None, set[str]]:
    """The body of a robot, and the capabilities that it has; None: the recording lacks it."""
    newest = recording.newest(recording.end, set(channels))
    body: RobotBody | None = None
    capabilities: set[str] = set()
    for message in newest.values():
        value = decoder.value(message) if channels[message.channel] in _SAID else None
        if isinstance(value, RobotBody):
            body = value
        elif isinstance(value, CapabilityReports):
            capabilities = {report.name for report in value.capabilities}
    if MAP.name in channels.values():
        capabilities.add("PRO_MAP")
    return body, capabilities


_SAID = (ROBOT_DESCRIPTION.name, CAPABILITY_REPORTS.name)
