"""Values of recorded messages, as a link to a robot makes them; decoded when first used."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.errors import CodecError, MessageFormatError
from hub.gcm.catalog import BY_NAME
from hub.gcm.mapping import MAP
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.vision import Image
from hub.ipc.definition import MessageDefinition
from hub.recording.anchor import TimeAnchor
from hub.recording.reader import LoggedMessage
from hub.recording.topics import RecordedTopic, topic_of
from rune_tui.link.pictures import picture_of
from rune_tui.model import own_records, study_records, team_events
from rune_tui.model.robot_state import Picture, Received

OWN: Mapping[str, MessageDefinition[Any]] = {
    each.name: each
    for each in (
        own_records.RUNE_TERMINAL,
        own_records.RUNE_LAYOUT,
        own_records.RUNE_STATE,
        own_records.RUNE_LINK,
        own_records.RUNE_FRAME,
        own_records.RUNE_SHOWN,
        own_records.RUNE_INPUT,
        own_records.RUNE_SELECT,
        team_events.RUNE_TEAM,
        study_records.RUNE_STUDY,
        study_records.RUNE_PROBE,
        study_records.RUNE_SECONDARY,
    )
}
"""Messages of the console itself and of studies, by name."""
_GREY = np.full((3, 4, 3), 64, np.uint8)


class LoggedPicture(Picture):
    """A picture that is decoded when it is drawn: most frames of a replay are not."""

    __slots__ = ("_image", "_pixels")
    _image: Image
    _pixels: npt.NDArray[np.uint8] | None

    def __init__(self, image: Image, interval_s: float) -> None:
        """Keep the message, and the usual time until the next one [s]."""
        for name, value in (
            ("_image", image),
            ("_pixels", None),
            ("camera", image.camera),
            ("interval_s", interval_s),
        ):
            object.__setattr__(self, name, value)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [pixels], as the message says."""
        return self._image.height_px, self._image.width_px

    @property
    def pixels(self) -> npt.NDArray[np.uint8]:
        """Red, green, blue; a grey one in place of a damaged picture."""
        if self._pixels is not None:
            return self._pixels
        try:
            found = picture_of(self._image).pixels
        except CodecError:
            found = _GREY
        object.__setattr__(self, "_pixels", found)
        return found


class Decoder:
    """Decodes the messages of one recording.

    Attributes:
        faults: What cannot be decoded, and why, once for each topic.
    """

    def __init__(
        self, channels: Mapping[int, RecordedTopic], anchor: TimeAnchor, faults: list[str]
    ) -> None:
        """Compare the recorded schemas with those of this version.

        Args:
            channels: The topics by number.
            anchor: The clock of the recording.
            faults: Gets what cannot be decoded.
        """
        self.faults = faults
        self._anchor = anchor
        self._known: dict[int, MessageDefinition[Any]] = {}
        self._failed: set[int] = set()
        self._topics = channels
        for number, topic in channels.items():
            name = topic.message if topic.message in BY_NAME else _own_name(topic)
            definition = BY_NAME.get(name) or OWN.get(name)
            if definition is None:
                continue
            if topic.encoding == "cdr" and topic.schema == topic_of("", definition).schema:
                self._known[number] = definition
            else:
                faults.append(f"{topic.name} is of another version of Rune, and is left out")

    def definition(self, channel: int) -> MessageDefinition[Any] | None:
        """The definition of a channel's messages; None: they cannot be decoded."""
        return self._known.get(channel)

    def value(self, message: LoggedMessage) -> Any:  # noqa: ANN401 - of any message
        """The value of a message; None: it cannot be decoded."""
        definition = self._known.get(message.channel)
        if definition is None:
            return None
        try:
            return definition.decode(message.payload)
        except (CodecError, MessageFormatError) as error:
            if message.channel not in self._failed:
                self._failed.add(message.channel)
                name = self._topics[message.channel].name
                self.faults.append(f"a message of {name} is damaged: {error}")
            return None

    def received(
        self, message: LoggedMessage, number: int, interval_s: float = 0.0
    ) -> Received[Any] | None:
        """A robot's message as its link would have it; None: it cannot be decoded.

        Args:
            message: The message.
            number: Its received number.
            interval_s: Usual time until the next one [s], for pictures.
        """
        value = self.value(message)
        if value is None:
            return None
        if isinstance(value, Image):
            value = LoggedPicture(value, interval_s)
        elif self._known[message.channel] is MAP:
            try:
                value = OccupancyMap.of(value)
            except CodecError:
                return None
        measured = self._anchor.moment(message.published)
        return Received(value=value, measured=measured, number=number)


def _own_name(topic: RecordedTopic) -> str:
    """The message of a topic /console/NAME or /console/NAME/PART."""
    parts = topic.name.split("/")
    return parts[2] if len(parts) > 2 and parts[1] == "console" else topic.message
