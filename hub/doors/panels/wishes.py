"""What panels want of a hub, and what a server for them offers."""

from __future__ import annotations

from typing import Final, Protocol

from hub.recording.topics import RecordedTopic
from hub.values import dataclass

Panel = tuple[int, int]
"""A panel that sends commands: the numbers of its program and of its channel."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SenderKind:
    """What the senders of a door's velocities are, in words.

    Attributes:
        owner: Who has control while one of them drives: "a panel of Foxglove".
        noun: One of them: "panel".
        release: What to do to end its velocities: "release it".
        rate: How to make it send fast enough: "set its publish rate to 10 Hz".
    """

    owner: str
    noun: str
    release: str
    rate: str


CMD_VEL: Final = "/cmd_vel"
"""The topic on which panels drive."""
LARGEST_COMMAND: Final = 4096
"""Longest command of a panel [bytes]."""
MOST_PANELS: Final = 32
"""Most panels that may send commands at a time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PanelCommand:
    """A command of a panel.

    Attributes:
        panel: Whose.
        encoding: "cdr" or "json".
        schema_name: Its type: "geometry_msgs/Twist".
        data: Its bytes.
        came: When [s], on the monotonic clock.
    """

    panel: Panel
    encoding: str
    schema_name: str
    data: bytes
    came: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What panels want now.

    Attributes:
        watched: The channels that a program shows.
        fresh: Those that got one more since the last time.
        commands: The newest commands of each panel since then, in turn.
        panels: All panels that may send commands.
    """

    watched: frozenset[int]
    fresh: frozenset[int]
    commands: tuple[PanelCommand, ...]
    panels: frozenset[Panel]


class TopicServer(Protocol):
    """Serves topics to panels. One thread calls it; its own threads note what panels ask for."""

    def take_wishes(self) -> Wishes:
        """What panels want now."""

    def open(self, topic: RecordedTopic) -> int:
        """Offer a topic; returns its number."""

    def close_topic(self, number: int) -> None:
        """Offer a topic no more."""

    def send(self, number: int, payload: bytes, stamp: int) -> None:
        """Send a message of a topic, measured at `stamp` [ns since the epoch]."""

    def set_parameters(self, values: dict[str, str | float | bool]) -> None:
        """Set what panels see as parameters."""

    def say(self, text: str) -> None:
        """Show a sentence to the people at the panels; empty: take it away."""

    def close(self) -> None:
        """Disconnect all panels."""
