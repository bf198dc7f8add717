"""What a bridge for Foxglove says; values."""

from __future__ import annotations

from collections.abc import Mapping

from hub.robots.ros.line import Payload, RosService, RosTopic
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeInfo:
    """What a bridge says first.

    Attributes:
        capabilities: What it can do besides giving messages.
        encodings: Encodings of messages that it takes.
        distribution: The distribution of ROS; empty: not known.
        session: Another one: all its channels are others.
        of_hub: Whether it is the door of a hub, and no bridge of a robot.
    """

    capabilities: frozenset[str]
    encodings: tuple[str, ...]
    distribution: str
    session: str
    of_hub: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeChannels:
    """Channels that a bridge has from now on.

    Attributes:
        channels: The topic of each, by number.
    """

    channels: Mapping[int, RosTopic]


@dataclass(frozen=True, slots=True, kw_only=True)
class GoneChannels:
    """Channels that a bridge has no more.

    Attributes:
        ids: Their numbers.
    """

    ids: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeServices:
    """Services that a bridge has from now on.

    Attributes:
        services: Each by number.
    """

    services: Mapping[int, RosService]


@dataclass(frozen=True, slots=True, kw_only=True)
class GoneServices:
    """Services that a bridge has no more.

    Attributes:
        ids: Their numbers.
    """

    ids: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeStatus:
    """A sentence of a bridge.

    Attributes:
        text: The sentence.
        id: Names it; empty: it is not taken back.
        is_error: Whether it is an error, no hint and no warning.
    """

    text: str
    id: str
    is_error: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class GoneStatuses:
    """Sentences that do not hold any more.

    Attributes:
        ids: Their names.
    """

    ids: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeParameters:
    """Values of parameters.

    Attributes:
        values: By name.
        question: The name of the question that they answer; empty: none.
    """

    values: Mapping[str, object]
    question: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeGraph:
    """A change of the nodes that publish and subscribe.

    Attributes:
        publishers: The nodes that publish a topic.
        subscribers: The nodes that subscribe to a topic.
        gone: Topics without either.
    """

    publishers: Mapping[str, tuple[str, ...]]
    subscribers: Mapping[str, tuple[str, ...]]
    gone: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BridgeData:
    """A message of a topic.

    Attributes:
        subscription: The number of its subscription.
        time_ns: When the bridge received it, by the robot's clock [ns]; 0: not known.
        payload: The message.
    """

    subscription: int
    time_ns: int
    payload: memoryview


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BridgeAnswer:
    """The answer of a service, or a file that was asked for.

    Attributes:
        call: The number of the request.
        payload: The answer, or the content of the file; None: there is none.
        why: The reason why there is none.
    """

    call: int
    payload: Payload | None
    why: str = ""


BridgeEvent = (
    BridgeInfo
    | BridgeChannels
    | GoneChannels
    | BridgeServices
    | GoneServices
    | BridgeStatus
    | GoneStatuses
    | BridgeParameters
    | BridgeGraph
    | BridgeData
    | BridgeAnswer
)
