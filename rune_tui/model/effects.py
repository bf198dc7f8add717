"""Effects of widgets: the app executes them, or they change the console's state."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, ClassVar

from hub.gcm.autonomy import AUTONOMY_COMMAND
from hub.gcm.control import ControlAction, is_driving, is_restricted
from hub.gcm.mission import MissionAction
from hub.gcm.navigation import GOAL_COMMAND, STOP, VELOCITY_COMMAND
from hub.gcm.recording import RecordCommand
from hub.ipc.definition import MessageDefinition
from hub.values import dataclass
from rune_tui.model.console_state import ConsoleState, Ghost, Notice, PictureWish
from rune_tui.model.effect_facts import EffectFacts, RobotEffect
from rune_tui.model.page import Page

SPEED_LIMITS = (0.1, 0.25, 0.5, 1.0)
"""Shares of the full speed that a robot is driven with."""


MOST_TRIM = 0.3
"""Largest trim of a control [m/s or rad/s]."""
_SENDS_OFF = frozenset({GOAL_COMMAND.name, AUTONOMY_COMMAND.name})
"""Messages that start a robot's own task."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SendEffect(RobotEffect):
    """Publish a message to a robot.

    Attributes:
        definition: Which message.
        value: Its value.
    """

    definition: MessageDefinition[Any]
    value: Any

    @property
    def stopped(self) -> str:
        """The robot, by a stop."""
        return self.robot if self.definition is STOP else ""

    @property
    def driven(self) -> str:
        """The robot, by a command of its velocity."""
        return self.robot if self.definition is VELOCITY_COMMAND else ""

    @property
    def controlled(self) -> str:
        """The robot, for messages that only its owner may send."""
        return self.robot if is_restricted(self.definition.name, self.value) else ""

    @property
    def takes_control(self) -> bool:
        """Whether it drives the robot, other than to rest."""
        return is_driving(self.definition.name, self.value)

    @property
    def sent_off(self) -> str:
        """The robot, by a goal or an order to autonomy."""
        return self.robot if self.definition.name in _SENDS_OFF else ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlEffect(RobotEffect):
    """Take control of a robot, ask for it, hand it over or give it up.

    Attributes:
        action: The requested action.
        by_driving: Whether a key that drives causes it, and not the key of control.
    """

    action: ControlAction
    by_driving: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleaseFirst(EffectFacts):
    """A robot was stopped: its keys that are down must be released before a key drives.

    Attributes:
        keys: All keys that drive it.
    """

    keys: frozenset[str]


@dataclass(frozen=True, slots=True)
class QuitEffect(EffectFacts):
    """End the console."""


@dataclass(frozen=True, slots=True)
class NextLayoutEffect(EffectFacts):
    """Open the next layout of the command line."""


@dataclass(frozen=True, slots=True)
class ScreenshotEffect(EffectFacts):
    """Write the view into two files, a picture and a text."""


@dataclass(frozen=True, slots=True)
class RecordEffect(EffectFacts):
    """Begin or end a recording of all messages from and to robots."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AskEffect(EffectFacts):
    """Ask the operator for a text, and execute the effects of the answer.

    Attributes:
        robot: The robot's name in the layout.
        asked: The question.
        text: The initial text.
        answer: Gives the effects of an answer, from the state at that time.
    """

    robot: str
    asked: str
    text: str
    answer: Callable[[str, ConsoleState], tuple[Effect, ...]]


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionEffect(RobotEffect):
    """Begin, name or end a robot's mission.

    Attributes:
        action: The requested action.
        name: The mission's name.
    """

    action: MissionAction
    name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotRecordEffect(RobotEffect):
    """Give the robot's own recorder an order.

    Attributes:
        command: The order.
    """

    command: RecordCommand


@dataclass(frozen=True, slots=True, kw_only=True)
class MarksWaiting(EffectFacts):
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
class ExportEffect(RobotEffect):
    """Write a robot's interest points into files."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrateEffect(EffectFacts):
    """Begin the calibration of a joystick's axes; if it is active, end it.

    Attributes:
        joystick: The joystick's name in the layout; empty: the first.
        control: The axis; empty: those that the layout names, or all.
    """

    joystick: str = ""
    control: str = ""


@dataclass(frozen=True, slots=True)
class PaletteEffect(EffectFacts):
    """Open the list of the layout's actions."""


@dataclass(frozen=True, slots=True)
class SuspendEffect(EffectFacts):
    """Suspend the console and return to the shell."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowViewport(EffectFacts):
    """Show or hide a viewport.

    Attributes:
        viewport: Its name.
        shown: The requested state; None: toggle.
    """

    moves_view: ClassVar[bool] = True

    viewport: str
    shown: bool | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooseRobot(EffectFacts):
    """Choose the robot that some viewports show and command.

    Attributes:
        robot: Its name; empty: the next one.
    """

    robot: str = ""

    @property
    def ends_holds(self) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, slots=True, kw_only=True)
class Peek(EffectFacts):
    """Look at another robot without commands to it, or look at the chosen robot again.

    Attributes:
        robot: Its name; empty: the chosen robot again.
    """

    robot: str = ""

    @property
    def ends_driving(self) -> bool:
        """When it begins."""
        return bool(self.robot)


@dataclass(frozen=True, slots=True, kw_only=True)
class Zoom(EffectFacts):
    """Show the world larger or smaller in a viewport.

    Attributes:
        viewport: Its name.
        factor: Change of the zoom; 0: back to the layout's.
    """

    viewport: str
    factor: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WishPictures(RobotEffect):
    """Ask for another kind of pictures.

    Attributes:
        wish: The kind.
    """

    wish: PictureWish


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooseCamera(RobotEffect):
    """Show another camera of a robot, where the layout has the camera `*`.

    Attributes:
        camera: Its name; empty: the main one.
    """

    camera: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitSpeed(RobotEffect):
    """Drive a robot with no more than a share of its speed.

    Attributes:
        share: The share, 0 to 1; None: the next of `SPEED_LIMITS`.
        up: Whether the next one is larger.
    """

    share: float | None = None
    up: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class TrimSpeed(RobotEffect):
    """Change the trim of a control: a small velocity that is added while a robot is driven.

    Attributes:
        control: The control of `widgetSetSpeed`; empty: all of them.
        change: Added to its trim [m/s or rad/s]; 0: no trim any more.
    """

    control: str = ""
    change: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ToggleNight(RobotEffect):
    """The report's local message `RuneToggleNightMode`: night mode on, or off again.

    Attributes:
        on: The requested state; None: toggle.
    """

    on: bool | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SetTheme(EffectFacts):
    """Change the colours.

    Attributes:
        name: The theme's name; empty: the next one.
    """

    name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToggleHelp(EffectFacts):
    """Open or close the page of keys."""

    @property
    def ends_holds(self) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, slots=True, kw_only=True)
class ToggleLog(EffectFacts):
    """Open or close the page of messages."""

    @property
    def ends_holds(self) -> bool:
        """Always."""
        return True


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnPage(EffectFacts):
    """Change the position or search of the page.

    Attributes:
        page: The new state.
    """

    page: Page


@dataclass(frozen=True, slots=True, kw_only=True)
class AskToLeave(EffectFacts):
    """Ask the operator to confirm the end of the console.

    Attributes:
        reasons: Reasons against it; none: the operator answered, and the console stays.
    """

    reasons: tuple[str, ...]

    @property
    def ends_holds(self) -> bool:
        """Whether it opens the question; the answer releases no inputs."""
        return bool(self.reasons)


@dataclass(frozen=True, slots=True, kw_only=True)
class FillView(EffectFacts):
    """Show one viewport in full screen, or all viewports again.

    Attributes:
        viewport: Its name.
    """

    moves_view: ClassVar[bool] = True

    viewport: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ShowGhost(EffectFacts):
    """Show the place of a mark before it is made.

    Attributes:
        robot: The robot of the map.
        ghost: The mark; None: remove it.
    """

    robot: str
    ghost: Ghost | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Notify(EffectFacts):
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
        question_s: float = 0.0,
    ) -> Notify:
        """Report an event."""
        notice = state.notice(text, robot=robot, alarm=alarm)
        return cls(notice=dataclasses.replace(notice, routine=routine, question_s=question_s))


CoverEffect = FillView | ToggleHelp | ToggleLog | TurnPage | AskToLeave
"""Open or close a page over the view."""
StateEffect = (
    ShowViewport
    | CoverEffect
    | ChooseRobot
    | Peek
    | Zoom
    | WishPictures
    | ChooseCamera
    | ToggleNight
    | MarksWaiting
    | LimitSpeed
    | TrimSpeed
    | SetTheme
    | ShowGhost
    | Notify
)
"""Effects that only change the console's state."""
OrderEffect = SendEffect | ControlEffect | MissionEffect | RobotRecordEffect
"""Orders to a robot."""
LocalEffect = (
    ReleaseFirst
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
"""Effects that the app executes without a robot."""
Effect = OrderEffect | LocalEffect | StateEffect
