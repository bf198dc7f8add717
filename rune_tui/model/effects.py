"""Effects of widgets: the app executes them, or they change the console's state."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hub.gcm.control import ControlAction
from hub.gcm.mission import MissionAction
from hub.ipc.definition import MessageDefinition
from rune_tui.model.console_state import ConsoleState, Ghost, Notice, PictureWish
from rune_tui.model.page import Page

SPEED_LIMITS = (0.1, 0.25, 0.5, 1.0)
"""Shares of the full speed that a robot is driven with."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SendEffect:
    """Publish a message to a robot.

    Attributes:
        robot: The robot's name in the layout.
        definition: Which message.
        value: Its value.
    """

    robot: str
    definition: MessageDefinition[Any]
    value: Any


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEffect:
    """Take control of a robot, ask for it, hand it over or give it up.

    Attributes:
        robot: The robot's name in the layout.
        action: The requested action.
        by_driving: Whether a key that drives causes it, and not the key of control.
    """

    robot: str
    action: ControlAction
    by_driving: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleaseFirst:
    """A robot was stopped: its keys that are down must be released before a key drives.

    Attributes:
        keys: All that drive it.
    """

    keys: frozenset[str]


@dataclass(frozen=True, slots=True)
class QuitEffect:
    """End the console."""


@dataclass(frozen=True, slots=True)
class NextLayoutEffect:
    """Open the next of the layouts that the console was started with."""


@dataclass(frozen=True, slots=True)
class ScreenshotEffect:
    """Write what is shown into files, a picture and a text."""


@dataclass(frozen=True, slots=True)
class RecordEffect:
    """Begin to record all that comes from robots and goes to them, or end it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AskEffect:
    """Ask the operator for a text, and execute the effects of the answer.

    Attributes:
        robot: The robot's name in the layout.
        asked: The question.
        text: The initial text.
        answer: Gives the effects of an answer, from the state when it comes.
    """

    robot: str
    asked: str
    text: str
    answer: Callable[[str, ConsoleState], tuple[Effect, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionEffect:
    """Begin, name or end a robot's mission.

    Attributes:
        robot: The robot's name in the layout.
        action: The requested action.
        name: The mission's name.
    """

    robot: str
    action: MissionAction
    name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class MarksWaiting:
    """Marks that a widget has sent and that are not confirmed yet.

    Attributes:
        source: The widget.
        robot: The robot.
        count: Number of marks.
        overdue: Number of those that are late.
    """

    source: int
    robot: str
    count: int
    overdue: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportEffect:
    """Write a robot's interest points into files.

    Attributes:
        robot: The robot's name in the layout.
    """

    robot: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrateEffect:
    """Begin the calibration of a joystick's axes; if it is active, end it.

    Attributes:
        joystick: The joystick's name in the layout; empty: the first.
        control: The axis; empty: those that the layout names, or all.
    """

    joystick: str = ""
    control: str = ""


@dataclass(frozen=True, slots=True)
class PaletteEffect:
    """Open the list of all that the layout's inputs do, to choose from."""


@dataclass(frozen=True, slots=True)
class SuspendEffect:
    """Give the terminal back to the shell for a while."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowViewport:
    """Show or hide a viewport.

    Attributes:
        viewport: Its name.
        shown: The requested state; None: toggle.
    """

    viewport: str
    shown: bool | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooseRobot:
    """Choose the robot that some viewports show and command.

    Attributes:
        robot: Its name; empty: the next one.
    """

    robot: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Zoom:
    """Show the world larger or smaller in a viewport.

    Attributes:
        viewport: Its name.
        factor: Change of the zoom; 0: back to the layout's.
    """

    viewport: str
    factor: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WishPictures:
    """Ask for another kind of pictures.

    Attributes:
        robot: The robot.
        wish: The kind.
    """

    robot: str
    wish: PictureWish


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitSpeed:
    """Drive a robot with no more than a share of its speed.

    Attributes:
        robot: Which robot.
        share: The share, 0 to 1; None: the next of `SPEED_LIMITS`.
        up: Whether the next one is larger.
    """

    robot: str
    share: float | None = None
    up: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ToggleNight:
    """The report's local message `RuneToggleNightMode`: night mode on, or off again.

    Attributes:
        robot: The robot.
        on: The requested state; None: toggle.
    """

    robot: str
    on: bool | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SetTheme:
    """Take other colours.

    Attributes:
        name: The theme's name; empty: the next one.
    """

    name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToggleHelp:
    """Open or close the page of keys."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToggleLog:
    """Show or hide the page of all that happened."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnPage:
    """Show the page over the view otherwise.

    Attributes:
        page: How.
    """

    page: Page


@dataclass(frozen=True, slots=True, kw_only=True)
class AskToLeave:
    """Ask the operator to confirm the end of the console.

    Attributes:
        reasons: Reasons against it; none: the operator answered, and the console stays.
    """

    reasons: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FillView:
    """Show one viewport over the whole view; if it is, show all of them again.

    Attributes:
        viewport: Its name.
    """

    viewport: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowGhost:
    """Show the place of a mark before it is made.

    Attributes:
        robot: The robot of the map.
        ghost: The mark; None: remove it.
    """

    robot: str
    ghost: Ghost | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Notify:
    """Report an event to the operator.

    Attributes:
        notice: The report.
    """

    notice: Notice

    @classmethod
    def now(
        cls,
        state: ConsoleState,
        text: str,
        *,
        robot: str = "",
        alarm: bool = False,
        routine: bool = False,
    ) -> Notify:
        """Report an event."""
        notice = state.notice(text, robot=robot, alarm=alarm)
        return cls(notice=dataclasses.replace(notice, routine=routine))


CoverEffect = FillView | ToggleHelp | ToggleLog | TurnPage | AskToLeave
"""Open or close a page over the view."""
StateEffect = (
    ShowViewport
    | CoverEffect
    | ChooseRobot
    | Zoom
    | WishPictures
    | ToggleNight
    | MarksWaiting
    | LimitSpeed
    | SetTheme
    | ShowGhost
    | Notify
)
"""Effects that only change the console's state."""
ActionEffect = (
    SendEffect
    | ControlEffect
    | ReleaseFirst
    | MissionEffect
    | QuitEffect
    | NextLayoutEffect
    | ScreenshotEffect
    | RecordEffect
    | AskEffect
    | ExportEffect
    | CalibrateEffect
    | PaletteEffect
    | SuspendEffect
)
"""Effects that the app executes."""
Effect = ActionEffect | StateEffect
