"""What the console knows of one robot; immutable, replaced whole."""

from __future__ import annotations

import dataclasses
import enum
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from hub.gcm.navigation import RobotState as NavigationState
from hub.gcm.vision import CameraState

T = TypeVar("T")


class LinkPhase(enum.Enum):
    """How the connection to a robot's hub stands.

    Attributes:
        CONNECTING: Not heard from yet.
        CONNECTED: Central answers.
        LOST: Central answered before and does not now; the link keeps trying.
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
        number: Counts the values of its kind; tells a new one from one already drawn.
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
        camera: Where the camera looked when it was taken.
    """

    pixels: npt.NDArray[np.uint8]
    camera: CameraState


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkState:
    """How the connection stands.

    Attributes:
        phase: How it stands now.
        since: When that began, on the console's monotonic clock [s].
        endpoint: Where the hub is.
        detail: One sentence on the last failure; empty when there is none.
        may_command: Whether the operator's key allows to drive and stop the robot.
    """

    phase: LinkPhase
    since: float
    endpoint: str
    detail: str = ""
    may_command: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotState:
    """What the console knows of one robot.

    Attributes:
        name: The robot's name in the layout.
        link: How the connection stands.
        picture: Newest camera image.
        navigation: Newest state of the robot itself.
        camera: Newest state of the camera.
    """

    name: str
    link: LinkState
    picture: Received[Picture] | None = None
    navigation: Received[NavigationState] | None = None
    camera: Received[CameraState] | None = None

    def with_(self, **changes: Any) -> RobotState:  # noqa: ANN401 - the fields have several types
        """A copy with other values."""
        return dataclasses.replace(self, **changes)
