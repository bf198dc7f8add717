"""Plays recordings onto a bus: states as they came, and answers to questions from the log.

| message of the recording | what happens |
| --- | --- |
| a command | it stays in the recording: nothing that is connected may obey it |
| a picture, a map | it answers questions |
| states of control and of the recorder | the player has its own |
| any other | it is published when its time comes |
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from hub.errors import CodecError, HandlerFailedError, HubError, RecordingError
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.catalog import BY_NAME
from hub.gcm.control import CONTROL_REFUSAL, CONTROL_STATE
from hub.gcm.diagnostics import DIAGNOSTICS, DiagnosticStatus
from hub.gcm.mapping import MAP, MAP_REQUEST, Map, MapRequest
from hub.gcm.recording import RECORD_STATE
from hub.gcm.vision import IMAGE, IMAGE_REQUEST, Image, ImageRequest
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition, Plane
from hub.ipc.wire import control
from hub.ipc.wire.definition_listing import from_listing
from hub.recording.chunks import LoggedMessage
from hub.recording.holes import beyond_hole
from hub.recording.live.bus_tap import DEFINITION
from hub.recording.open_recording import OpenRecording
from hub.recording.topics import RecordedTopic, topic_of

MOST_LATE_S = 0.05
"""Longest time that published messages keep the player from its other work [s]."""
_PROBLEM_NS = round(2.0e9 / DIAGNOSTICS.rate_hz)
"""Time after which a problem that is not reported again is over [ns]."""
_OWN = frozenset(each.name for each in (CONTROL_STATE, CONTROL_REFUSAL, RECORD_STATE, DIAGNOSTICS))
_ANSWERS = frozenset({IMAGE.name, MAP.name})


def robots_of(log: OpenRecording) -> list[str]:
    """The robots in a recording, those with the most messages first."""
    found: Counter[str] = Counter()
    for channel, topic in log.channels.items():
        if topic.message in BY_NAME:
            found[topic.robot] += max(1, log.counts.get(channel, 1))
    return [name for name, _ in found.most_common() if name]


class Player:
    """Publishes a recording of one robot; for one thread.

    Attributes:
        rate: Seconds of the recording in a second.
        paused: Whether time stands still.
        now: Stamp of the present moment of the recording [ns].
        published: Number of published messages.
        left_out: Why a topic is not played, by its name.
    """

    def __init__(
        self,
        client: Client,
        log: OpenRecording,
        robot: str,
        *,
        chosen: Callable[[str], bool],
        clock: Callable[[], float],
        holes: Sequence[tuple[int, int]] = (),
    ) -> None:
        """Stand at the start.

        Args:
            client: Publishes.
            log: The recordings.
            robot: Which robot.
            chosen: Whether a topic of this name is played.
            clock: Monotonic time [s].
            holes: Long times without messages, which are skipped: begin and end of each [ns].
        """
        self._client, self._log, self._clock, self._holes = client, log, clock, holes
        self.rate, self.paused = 1.0, False
        self.now, self.published = log.start, 0
        self.left_out: dict[str, str] = {}
        self._definitions: dict[int, MessageDefinition[Any]] = {}
        self._answers: dict[int, MessageDefinition[Any]] = {}
        self._pictures: dict[str, LoggedMessage] = {}
        self._map: LoggedMessage | None = None
        self._problems: dict[str, tuple[int, DiagnosticStatus]] = {}
        self._picture_of_any: LoggedMessage | None = None
        self._main = ""
        self._choose(robot, chosen)
        self._at = clock()
        self._left = self._from(log.start)
        self._next: LoggedMessage | None = None
        client.define(*self._definitions.values())
        client.respond(IMAGE_REQUEST, IMAGE, self._picture)
        client.respond(MAP_REQUEST, MAP, self._whole_map)

    @property
    def ended(self) -> bool:
        """Whether the end is reached."""
        return self.now >= self._log.end

    def seek(self, stamp: int) -> None:
        """Go to a moment [ns]: first comes the newest message of each topic before it."""
        stamp = beyond_hole(self._holes, stamp, backwards=stamp < self.now)
        stamp = max(self._log.start, min(self._log.end, stamp))
        self.now, self._at = stamp, self._clock()
        self._pictures.clear()
        self._problems.clear()
        self._map = self._picture_of_any = None
        newest = self._log.newest(stamp, self._channels)
        for message in sorted(newest.values(), key=lambda each: each.stamp):
            self._play(message)
        self._left, self._next = self._from(stamp + 1), None

    def step(self) -> float:
        """Publish what is due; returns the time until the next message, at most 1 [s]."""
        now = self._clock()
        passed, self._at = now - self._at, now
        if not self.paused:
            due = self.now + round(passed * self.rate * 1e9)
            self.now = min(self._log.end, beyond_hole(self._holes, due))
        while True:
            message = self._next or next(self._left, None)
            if message is None:
                return 1.0
            self._next = message
            wait = (message.stamp - self.now) / 1e9
            if wait > 0.0 or self.paused:
                return 1.0 if self.paused else min(1.0, wait / self.rate)
            self._next = None
            self._play(message)
            if self._clock() - now > MOST_LATE_S:
                return 0.0

    @property
    def problems(self) -> list[DiagnosticStatus]:
        """The problems of the robot at this moment of the recording, of all who reported some."""
        since = self.now - _PROBLEM_NS
        return [problem for stamp, problem in self._problems.values() if stamp >= since]

    @property
    def _channels(self) -> set[int]:
        return self._definitions.keys() | self._answers.keys()

    def _from(self, stamp: int) -> Iterator[LoggedMessage]:
        return self._log.messages(stamp, None, self._channels)

    def _choose(self, robot: str, chosen: Callable[[str], bool]) -> None:
        """Find the channels that are played; of equal topics the one with the most messages."""
        best: dict[str, int] = {}
        for channel, topic in self._log.channels.items():
            if topic.robot == robot and chosen(topic.name):
                count = self._log.counts.get(channel, 0)
                known = best.get(topic.name)
                if known is None or count > self._log.counts.get(known, 0):
                    best[topic.name] = channel
        for name, channel in best.items():
            try:
                definition = definition_of(self._log.channels[channel])
            except HubError as error:
                self.left_out[name] = str(error)
                continue
            if definition.plane is Plane.COMMAND:
                self.left_out[name] = "commands are not played"
            elif definition.name in _ANSWERS or definition.name == DIAGNOSTICS.name:
                self._answers[channel] = definition
            elif definition.name not in _OWN:
                self._definitions[channel] = definition

    def _play(self, message: LoggedMessage) -> None:
        definition = self._definitions.get(message.channel)
        if definition is None:
            self._remember(self._answers[message.channel], message)
            return
        if definition is ROBOT_DESCRIPTION:
            self._main = _main_camera(message)
        age = max(0.0, (message.stamp - message.published) / 1e9)
        measured = self._clock() - age
        self._client.publish_payload(definition, message.payload, measured=measured)
        self.published += 1

    def _remember(self, definition: MessageDefinition[Any], message: LoggedMessage) -> None:
        try:
            if definition.name == MAP.name:
                self._map = message
                return
            value = definition.decode(message.payload)
        except CodecError:
            return
        if definition.name == IMAGE.name:
            self._pictures[value.camera.name] = self._picture_of_any = message
        else:
            for problem in value.status:
                self._problems[problem.name] = message.stamp, problem

    def _picture(self, request: ImageRequest) -> Image:
        found = self._pictures.get(request.camera or self._main, self._picture_of_any)
        if found is None:
            text = "the recording has no picture before this moment"
            raise HandlerFailedError(text)
        return IMAGE.decode(found.payload)

    def _whole_map(self, _request: MapRequest) -> Map:
        if self._map is None:
            text = "the recording has no map before this moment"
            raise HandlerFailedError(text)
        return MAP.decode(self._map.payload)


def _main_camera(message: LoggedMessage) -> str:
    """The main camera of a described robot; empty: not known."""
    try:
        cameras = ROBOT_DESCRIPTION.decode(message.payload).cameras
    except CodecError:
        return ""
    return cameras[0].name if cameras else ""


def definition_of(topic: RecordedTopic) -> MessageDefinition[Any]:
    """The definition of a recorded message.

    Raises:
        RecordingError: The recording does not say it.
        MessageFormatError: It says nonsense.
    """
    own = BY_NAME.get(topic.message)
    if own is not None and topic_of(topic.robot, own).schema == topic.schema:
        return own
    try:
        entry = json.loads(topic.metadata[DEFINITION])
        return from_listing(
            control.Define(
                name=str(entry["name"]),
                format=str(entry["format"]),
                fields=str(entry["fields"]),
                keep=str(entry["keep"]),
                plane=str(entry["plane"]),
                rate_hz=float(entry["rate_hz"]),
                lifespan_s=math.inf,
            )
        )
    except (KeyError, ValueError, TypeError) as error:
        text = f"{topic.name} is defined otherwise than here, and the recording does not say how"
        raise RecordingError(text) from error
