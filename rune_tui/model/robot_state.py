"""The state of one robot at the console; immutable, replaced whole."""

from __future__ import annotations

import dataclasses
import enum
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Set
from dataclasses import field
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from hub.gcm.autopilot import AutopilotText
from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.diagnostics import Diagnostics
from hub.gcm.navigation import ROBOT_STATE
from hub.gcm.navigation import RobotState as NavigationState
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.vision import CAMERA_STATE, CameraState, ImageCoding
from hub.ipc.definition import MessageDefinition
from hub.ipc.roles import Role
from hub.ipc.security.publish_rights import may_publish
from hub.values import dataclass

T = TypeVar("T")


class LinkPhase(enum.Enum):
    """The phase of the connection to a robot's hub.

    Attributes:
        CONNECTING: Central has not answered yet.
        CONNECTED: Central answers.
        LOST: Central does not answer any more; the link retries.
    """

    CONNECTING = "connecting"
    CONNECTED = "connected"
    LOST = "lost"


@dataclass(frozen=True, slots=True, kw_only=True)
class Received(Generic[T]):
    """A value and its age.

    Attributes:
        value: The value.
        measured: When it was measured, on the console's monotonic clock [s].
        number: Counts the values of its kind, to detect a new one.
    """

    value: T
    measured: float
    number: int

    def age(self, now: float) -> float:
        """Time since it was measured [s]."""
        return max(0.0, now - self.measured)


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A decoded camera image.

    Attributes:
        pixels: Red, green, blue, shape (height, width, 3).
        camera: State of the camera at that moment.
        interval_s: Usual time until the next one [s].
    """

    pixels: npt.NDArray[np.uint8]
    camera: CameraState
    interval_s: float = 0.0

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [pixels]."""
        height, width = self.pixels.shape[:2]
        return height, width


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureFlow:
    """Statistics of recent pictures.

    Attributes:
        coding: Coding of the newest.
        quality: Requested quality.
        width_px: Width of the newest.
        height_px: Height of the newest.
        shrunk: Whether they are smaller than their viewport, because the link is slow.
        per_s: Rate [1/s].
    """

    coding: ImageCoding
    quality: int
    width_px: int
    height_px: int
    shrunk: bool
    per_s: float


class LackKind(enum.Enum):
    """Why a robot does not provide a capability.

    Attributes:
        ABSENT: It has no module for it: that is how the robot is made.
        COMING: Its module is not ready yet.
        BROKEN: Its module cannot run.
    """

    ABSENT = "absent"
    COMING = "coming"
    BROKEN = "broken"


@dataclass(frozen=True, slots=True, kw_only=True)
class Lack:
    """A requested capability that the robot does not provide now.

    Attributes:
        kind: The reason.
        why: The reason in words.
    """

    kind: LackKind
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkState:
    """The state of the connection.

    Attributes:
        phase: Its phase.
        since: Begin of the phase, on the console's monotonic clock [s].
        endpoint: The hub's endpoint.
        detail: One sentence on the last failure; empty: none.
        may_command: Whether the operator's key allows to drive; every key allows to stop.
        round_trip: Round trip of the newest answer [s]; NaN: none yet.
        bytes_per_s: Rate of received bytes; NaN: not measured yet.
        messages_per_s: Rate of received messages; NaN: not measured yet.
        missed: Number of messages lost.
        lacking: Requested capabilities that the robot does not provide now, by name.
        unfit: First fault in the values of each message, in a sentence, by its name.
        number: This console's number at the robot's hub, as in frame headers; 0: none yet.
        owned_since: Time of day at which its owner got control, such as "14:03".
        refusal: Reason of the last refusal by the robot or its hub; empty: none.
        refusal_count: Number of refusals, to detect a new one.
        pictures: Statistics of recent pictures; None: no pictures come.
    """

    phase: LinkPhase
    since: float
    endpoint: str
    detail: str = ""
    may_command: bool = True
    round_trip: float = math.nan
    bytes_per_s: float = math.nan
    messages_per_s: float = math.nan
    missed: int = 0
    lacking: Mapping[str, Lack] = field(default_factory=dict)
    unfit: Mapping[str, str] = field(default_factory=dict)
    number: int = 0
    owned_since: str = ""
    refusal: str = ""
    refusal_count: int = 0
    pictures: PictureFlow | None = None

    def may_send(self, message: str) -> bool:
        """Whether the operator's key allows to send this command."""
        return self.may_command or may_publish(Role.OBSERVE, message)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotState:
    """The state of one robot.

    Attributes:
        name: Its role: the robot's name in the layout.
        link: The state of the connection.
        picture: Newest image of the main camera.
        pictures: Newest image of each other camera that is shown, by the camera's name.
        map: Newest map.
        messages: The newest of each other message, by its name.
        diagnostics: The newest problems that each module reports, by its number at the hub.
        texts: The newest texts of its autopilot, the oldest first.
    """

    name: str
    link: LinkState
    picture: Received[Picture] | None = None
    pictures: Mapping[str, Received[Picture]] = field(default_factory=dict)
    map: Received[OccupancyMap] | None = None
    messages: Mapping[str, Received[Any]] = field(default_factory=dict)
    diagnostics: Mapping[int, Received[Diagnostics]] = field(default_factory=dict)
    texts: tuple[Received[AutopilotText], ...] = ()

    def newest(self, definition: MessageDefinition[T]) -> Received[T] | None:
        """The newest message of a kind; None: none arrived, or no viewport uses it."""
        return self.messages.get(definition.name)

    @property
    def all_pictures(self) -> Mapping[str, Received[Picture]]:
        """The newest image of each camera, by its name; the main one's is empty."""
        return self.pictures if self.picture is None else {"": self.picture, **self.pictures}

    @property
    def body(self) -> RobotBody | None:
        """The hub's report of the robot's body; None: none yet."""
        described = self.newest(ROBOT_DESCRIPTION)
        return described.value if described is not None else None

    @property
    def title(self) -> str:
        """Its name for people: its own, or its role until that is known."""
        body = self.body
        return body.name if body is not None and body.name else self.name

    @property
    def navigation(self) -> Received[NavigationState] | None:
        """Newest state of the robot itself."""
        return self.newest(ROBOT_STATE)

    @property
    def camera(self) -> Received[CameraState] | None:
        """Newest state of the main camera."""
        return self.newest(CAMERA_STATE)

    def with_picture(self, camera: str, picture: Received[Picture]) -> RobotState:
        """A copy with the newest picture of a camera; the main one's name is empty."""
        if not camera:
            return self.with_(picture=picture)
        return self.with_(pictures={**self.pictures, camera: picture})

    def with_pictures_of(self, cameras: Set[str]) -> RobotState:
        """A copy without the pictures of other cameras, which would only grow old."""
        kept = {name: each for name, each in self.pictures.items() if name in cameras}
        return self.with_(picture=self.picture if "" in cameras else None, pictures=kept)

    def with_(self, **changes: Any) -> RobotState:  # noqa: ANN401 - the fields have several types
        """A copy with other values."""
        return dataclasses.replace(self, **changes)


def titles(robots: Iterable[RobotState]) -> dict[str, str]:
    """The name of each robot for people, by its role.

    It is the role if two robots have the same name, or if one is named as the role of another.
    """
    known = tuple(robots)
    uses = Counter(name for robot in known for name in {robot.title, robot.name})
    return {robot.name: robot.title if uses[robot.title] == 1 else robot.name for robot in known}
