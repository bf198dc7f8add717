"""The cameras of a robot: which one a viewport shows, and what it sees."""

from __future__ import annotations

from typing import Final

from hub.gcm.vision import CAMERA_STATE
from hub.values import dataclass
from rune_tui.layout.rules import TextOption
from rune_tui.layout.spec import CHOSEN
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Received, RobotState

MAIN: Final = ""
"""Name of the main camera for the console; the robot may have another for it."""

CAMERA_OPTION: Final = TextOption(
    longest=100,
    meaning="name of the camera, as the robot describes it; empty: the main one; *: the one that "
    "the operator chose by widgetChooseCamera, at first the main one",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureNeed:
    """The pictures of one camera that the viewports on the screen need.

    Attributes:
        size: Width and height of the largest of them [pixels].
        interval_s: Shortest time between two of them [s]; 0: as often as the layout's `VIS_VID`.
    """

    size: tuple[int, int]
    interval_s: float = 0.0

    def and_also(self, other: PictureNeed) -> PictureNeed:
        """The pictures that serve both: the larger, and the more frequent."""
        return PictureNeed(
            size=max(self.size, other.size), interval_s=min(self.interval_s, other.interval_s)
        )


def camera_names(robot: RobotState) -> tuple[str, ...]:
    """The names of a robot's cameras, the main one first; none while they are not known."""
    return tuple(each.name for each in robot.body.cameras) if robot.body is not None else ()


def camera_of(option: str, robot: RobotState, state: ConsoleState) -> str:
    """The camera that a value of `CAMERA_OPTION` means now; `MAIN` for the main one."""
    name = state.cameras.get(robot.name, MAIN) if option == CHOSEN else option
    names = camera_names(robot)
    return MAIN if names and name == names[0] else name


def camera_title(camera: str, robot: RobotState) -> str:
    """A camera's name on its picture; empty: the robot has no other."""
    names = camera_names(robot)
    return (camera or names[0]) if len(names) > 1 else camera


def unknown_camera(camera: str, robot: RobotState) -> str:
    """Why a robot cannot show a camera, in words; empty: it can, or its cameras are not known."""
    names = camera_names(robot)
    if robot.body is None or camera == MAIN or camera in names:
        return ""
    there = f"it has {', '.join(names)}" if names else "it describes none"
    return f"no camera {camera}; {there}"


def seen_by(robot: RobotState, camera: str) -> RobotState:
    """The robot with the picture and the state of this camera in place of its main one's."""
    if camera == MAIN:
        return robot
    picture = robot.pictures.get(camera)
    messages = {name: each for name, each in robot.messages.items() if name != CAMERA_STATE.name}
    if picture is not None:
        messages[CAMERA_STATE.name] = Received(
            value=picture.value.camera, measured=picture.measured, number=picture.number
        )
    return robot.with_(picture=picture, messages=messages)
