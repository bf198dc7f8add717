"""The state of the console and of all robots at one moment; immutable."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import field
from typing import Self

from hub.gcm.mapping import PointKind
from hub.gcm.vision import ImageCoding, ImageKind
from hub.values import dataclass
from rune_tui.layout.actions import inputs_of
from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import CHOSEN, LayoutSpec
from rune_tui.model.attention import AttentionEntry
from rune_tui.model.display_state import DisplayState
from rune_tui.model.joystick_state import JoystickState
from rune_tui.model.operating_limits import NO_LIMITS, OperatingLimits
from rune_tui.model.page import Page
from rune_tui.model.robot_state import RobotState, titles
from rune_tui.model.theme import DARK, Theme
from rune_tui.model.world import WorldPoint

MOST_NOTICES = 200
_DAY_S = 86400


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """A report for the operator.

    Attributes:
        text: One sentence.
        when: When it happened, on the console's monotonic clock [s].
        clock: The time of day then, such as "14:03:22".
        robot: Its robot; empty: the console itself.
        alarm: Whether the operator must act.
        quiet: Whether it is for the log only.
        past: Whether it happened before the console's start: history, never an alarm.
        routine: Whether it only confirms an order of the operator, such as to save a file.
        question_s: Time in which a second press answers its question [s]; 0: it asks nothing.
    """

    text: str
    when: float
    clock: str = ""
    robot: str = ""
    alarm: bool = False
    quiet: bool = False
    past: bool = False
    routine: bool = False
    question_s: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Banner:
    """The alarm that is drawn over the view.

    Attributes:
        robot: Its robot; empty: the console itself.
        text: Its text.
        more: Number of further alarms.
        advice: The remedy; empty: the text has it.
        calm: Whether it is information and no alarm: the robot moves by itself.
    """

    robot: str
    text: str
    more: int = 0
    advice: str = ""
    calm: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Ghost:
    """A mark that the operator has not confirmed yet.

    Attributes:
        kind: Its kind.
        place: Its place.
        until: Time at which it disappears, on the console's monotonic clock [s].
    """

    kind: PointKind
    place: WorldPoint
    until: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureWish:
    """The kind of requested pictures.

    Attributes:
        kind: Grey or colour.
        width: Width [pixels]; 0: that of the viewport.
        height: Height [pixels]; 0: that of the viewport.
        quality: 1 to 100; if the coding is measured, that of run lengths.
        coding: Their coding; None: the best for the link, by measurement.
    """

    kind: ImageKind = ImageKind.COLOUR
    width: int = 0
    height: int = 0
    quality: int = 60
    coding: ImageCoding | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsoleState:
    """The state of the console and of all robots.

    Attributes:
        now: The console's monotonic clock [s].
        began: The start of the console, on the same clock [s]; what happened before is history.
        held: Keys that are HELD, in the order of their presses.
        must_release: Keys that must be released before a key drives.
        tap_first: Whether those must be tapped once before they drive.
        hold_s: Duration of a hold after a repeat, where releases are not reported [s].
        releases_reported: Whether the terminal reports releases of keys.
        robots: The state of each robot, by name.
        chosen: The robot that inputs of viewports with `CHOSEN` command.
        peeked: The robot that those viewports show instead, without commands; empty: none.
        looked: Time at which the operator last looked away from each robot [s], by name.
        shown: Viewports that the operator has shown (True) or hidden (False).
        places: Viewports that have a place at this size, and whether each is shown by default.
        zooms: Zoom of each viewport, relative to its layout, by name.
        wishes: The requested kind of pictures, by the robot's name.
        cameras: The camera that the operator chose, by robot; default: the main one.
        night: Robots with night mode on, by name.
        trims: The trim of each robot's controls [m/s or rad/s].
        speed_limits: Share of its speed at which each robot is driven, 0 to 1; default: 1.
        theme: The colours.
        notices: The reports, the newest last.
        help: Whether the page of keys is open.
        log: Whether the page of reports is open.
        page: The position and search of that page.
        rows: Height of the terminal [cells].
        leaving: Reasons against the end of the console, while the operator is asked to confirm.
        full: The viewport in full screen; empty: none.
        operator: The operator of this console.
        clock: The time of day now, such as "14:03:22".
        recording: The file of the running recording; empty: none.
        trouble: The mistake in the layout file as last saved; drawn over the view.
        display: The state of the connection to the terminal; None: there is no terminal.
        pixel_height: Height of a pixel, half a cell of the terminal, over its width.
        inputs: The first input of each purpose of a widget, in words, by purpose and robot.
        joysticks: The state of the layout's joysticks, by name.
        unconfirmed: Number of marks that were sent and not confirmed, by widget and robot.
        overdue: Number of those that are late, in the same form.
        banner: The alarm that is drawn over the view; panes do not repeat it.
        drawn: Function and robot of each visualizer that is shown.
        stop_shown: Whether a line of keys or a button that is seen says how to stop.
        attention: The problems of all robots, in the order in which they need the operator.
        ghosts: Marks that the operator has not confirmed yet, by robot.
        sent_off: Time of the last order to go somewhere from this console [s], by robot.
        limits: What robots may do by themselves in the condition of a study.
    """

    now: float
    began: float = -math.inf
    held: tuple[str, ...] = ()
    must_release: tuple[str, ...] = ()
    tap_first: bool = False
    hold_s: float = 0.6
    releases_reported: bool = False
    robots: Mapping[str, RobotState] = field(default_factory=dict)
    chosen: str = ""
    peeked: str = ""
    looked: Mapping[str, float] = field(default_factory=dict)
    shown: Mapping[str, bool] = field(default_factory=dict)
    places: Mapping[str, bool] = field(default_factory=dict)
    zooms: Mapping[str, float] = field(default_factory=dict)
    wishes: Mapping[str, PictureWish] = field(default_factory=dict)
    cameras: Mapping[str, str] = field(default_factory=dict)
    night: frozenset[str] = frozenset()
    speed_limits: Mapping[str, float] = field(default_factory=dict)
    trims: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    theme: Theme = DARK
    notices: tuple[Notice, ...] = ()
    help: bool = False
    log: bool = False
    page: Page = field(default_factory=Page)
    rows: int = 24
    leaving: tuple[str, ...] = ()
    full: str = ""
    operator: str = ""
    clock: str = ""
    recording: str = ""
    trouble: str = ""
    display: DisplayState | None = None
    pixel_height: float = 1.0
    inputs: Mapping[tuple[Purpose, str], str] = field(default_factory=dict)
    joysticks: Mapping[str, JoystickState] = field(default_factory=dict)
    unconfirmed: Mapping[tuple[int, str], int] = field(default_factory=dict)
    overdue: Mapping[tuple[int, str], int] = field(default_factory=dict)
    banner: Banner | None = None
    drawn: frozenset[tuple[str, str]] = frozenset()
    stop_shown: bool = False
    attention: tuple[AttentionEntry, ...] = ()
    ghosts: Mapping[str, Ghost] = field(default_factory=dict)
    sent_off: Mapping[str, float] = field(default_factory=dict)
    limits: OperatingLimits = NO_LIMITS

    @classmethod
    def at_start(cls, layout: LayoutSpec, now: float, operator: str = "") -> Self:
        """The state at the start of a layout, without robots."""
        return cls(
            now=now,
            began=now,
            chosen=layout.robots[0].name,
            operator=operator,
            inputs=inputs_of(layout),
            joysticks={
                joystick.name: JoystickState(name=joystick.name) for joystick in layout.joysticks
            },
        )

    @property
    def paged(self) -> bool:
        """Whether a page is open; then only keys of the page, stop and quit count."""
        return self.help or self.log

    @property
    def latency(self) -> float:
        """Time from drawing to the operator's screen [s]; 0: not known."""
        known = self.display is not None and math.isfinite(self.display.latency)
        return self.display.latency if self.display is not None and known else 0.0

    @property
    def seen(self) -> str:
        """The robot that the operator looks at: the peeked one, else the chosen one."""
        return self.peeked or self.chosen

    def unseen_s(self, robot: str) -> float:
        """Time since the operator looked away from a robot [s]; infinite: not looked at yet."""
        away = self.now - self.looked.get(robot, -math.inf)
        return 0.0 if robot == self.seen else max(0.0, away)

    def robot(self, name: str) -> RobotState | None:
        """The robot that a viewport commands; its name may be `CHOSEN`. None: there is none."""
        return self.robots.get(self.chosen if name == CHOSEN else name)

    def shown_robot(self, name: str) -> RobotState | None:
        """The robot that a viewport shows; its name may be `CHOSEN`. None: there is none."""
        return self.robots.get(self.seen if name == CHOSEN else name)

    def title(self, robot: str) -> str:
        """The name of the robot of a role, for people; empty: no robot."""
        return titles(self.robots.values()).get(robot, robot)

    def speed_limit(self, robot: str) -> float:
        """Speed limit of a robot, which may be `CHOSEN`, as a share of its speed, 0 to 1."""
        return self.speed_limits.get(self.chosen if robot == CHOSEN else robot, 1.0)

    def trim(self, robot: str) -> Mapping[str, float]:
        """The trim of each control of a robot, which may be `CHOSEN` [m/s or rad/s]."""
        return self.trims.get(self.chosen if robot == CHOSEN else robot, {})

    def unconfirmed_marks(self, robot: str) -> int:
        """Number of marks that this robot has not confirmed."""
        return sum(count for (_, marked), count in self.unconfirmed.items() if marked == robot)

    def overdue_marks(self, robot: str) -> int:
        """Number of marks whose confirmation by this robot is late."""
        return sum(count for (_, marked), count in self.overdue.items() if marked == robot)

    def input_of(self, purpose: Purpose, robot: str) -> str:
        """The input that does this for a robot, in words; empty if none does."""
        own = self.inputs.get((purpose, robot), "")
        return self.inputs.get((purpose, CHOSEN), own) if robot == self.chosen else own

    def notice(
        self, text: str, *, robot: str = "", alarm: bool = False, ago: float = 0.0
    ) -> Notice:
        """A notice of an event.

        Args:
            text: One sentence.
            robot: Its robot; empty: the console itself.
            alarm: Whether the operator must act; an event before the console's start is no alarm.
            ago: Time since it happened [s].
        """
        when = self.now - max(0.0, ago)
        past = when < self.began
        return Notice(
            text=text,
            when=when,
            clock=clock_before(self.clock, ago),
            robot=robot,
            alarm=alarm and not past,
            quiet=past,
            past=past,
        )


def clock_before(clock: str, ago: float) -> str:
    """The time of day [HH:MM:SS] some time [s] before another one; from a day on, "2 d ago"."""
    seconds = int(ago) if math.isfinite(ago) else 0
    if seconds <= 0 or not clock:
        return clock
    if seconds >= _DAY_S:
        return f"{seconds // _DAY_S} d ago"
    hours, minutes, rest = (int(part) for part in clock.split(":"))
    then = (3600 * hours + 60 * minutes + rest - seconds) % _DAY_S
    return f"{then // 3600:02d}:{then // 60 % 60:02d}:{then % 60:02d}"


def carried_over(state: ConsoleState, layout: LayoutSpec) -> ConsoleState:
    """The state after a change of the layout.

    The operator's settings of viewports and robots that exist in both layouts stay.
    """
    robots = {robot.name for robot in layout.robots}
    viewports = {viewport.name for viewport in layout.view.viewports}
    if lost := sum(state.unconfirmed.values()):
        text = f"{lost} marks were not confirmed before the layout changed: are they there?"
        notices = (*state.notices, state.notice(text, alarm=True))
        state = dataclasses.replace(state, notices=notices, unconfirmed={}, overdue={})
    return dataclasses.replace(
        state,
        chosen=state.chosen if state.chosen in robots else layout.robots[0].name,
        peeked="",
        looked={name: since for name, since in state.looked.items() if name in robots},
        shown={name: shown for name, shown in state.shown.items() if name in viewports},
        full=state.full if state.full in viewports else "",
        zooms={name: zoom for name, zoom in state.zooms.items() if name in viewports},
        wishes={name: wish for name, wish in state.wishes.items() if name in robots},
        cameras={name: each for name, each in state.cameras.items() if name in robots},
        night=state.night & robots,
        trims={name: each for name, each in state.trims.items() if name in robots},
        speed_limits={name: limit for name, limit in state.speed_limits.items() if name in robots},
        trouble="",
        ghosts={},  # the widget that ends or confirms them is gone
        inputs=inputs_of(layout),
    )
