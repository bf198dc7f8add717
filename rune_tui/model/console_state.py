"""What the console itself is doing, and all that it knows at one moment; immutable."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

from hub.gcm.mapping import PointKind
from hub.gcm.vision import ImageCoding, ImageKind
from rune_tui.layout.actions import inputs_of
from rune_tui.layout.rules import Purpose
from rune_tui.layout.spec import CHOSEN, LayoutSpec
from rune_tui.model.display_state import DisplayState
from rune_tui.model.joystick_state import JoystickState
from rune_tui.model.page import Page
from rune_tui.model.robot_state import RobotState, titles
from rune_tui.model.theme import DARK, Theme
from rune_tui.model.world import WorldPoint

MOST_NOTICES = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """Something that happened, for the operator to read.

    Attributes:
        text: One sentence.
        when: On the console's monotonic clock [s].
        clock: The time of day then, such as "14:03:22".
        robot: Whom it is about; empty for the console itself.
        alarm: Whether it needs a hand.
        quiet: Whether it is for the log only, and not shown by itself where there is none.
        routine: Whether it only says that what the operator wanted is done, such as a file.
    """

    text: str
    when: float
    clock: str = ""
    robot: str = ""
    alarm: bool = False
    quiet: bool = False
    routine: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Banner:
    """The alarm that stands over everything.

    Attributes:
        robot: Whose it is; empty for the console itself.
        text: What it says.
        more: How many more alarms there are.
        advice: What to do about it; empty: that is plain.
        calm: Whether it is no alarm, but what the operator must know: the robot moves by itself.
    """

    robot: str
    text: str
    more: int = 0
    advice: str = ""
    calm: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Ghost:
    """A mark that was pointed at and is not made yet.

    Attributes:
        kind: What would be marked.
        place: Where.
        until: When it ends by itself, on the console's monotonic clock [s].
    """

    kind: PointKind
    place: WorldPoint
    until: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureWish:
    """What kind of pictures are asked for.

    Attributes:
        kind: Grey or colour.
        width: Width wanted [pixels]; 0: as wide as is shown.
        height: Height wanted [pixels]; 0: as high as is shown.
        quality: 1 to 100; where the coding is chosen by measurement, of run lengths.
        coding: How they are coded; None: by measurement, whatever suits the link.
    """

    kind: ImageKind = ImageKind.COLOUR
    width: int = 0
    height: int = 0
    quality: int = 60
    coding: ImageCoding | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ConsoleState:
    """What the console is doing and what it knows.

    Attributes:
        now: The console's monotonic clock [s].
        held: Keys that count as held down, in the order they were pressed.
        must_release: Keys that must be released before a key drives.
        tap_first: Whether those drive only when they are tapped once, and then held.
        hold_s: How long a key that repeats counts as held where no release is told [s].
        releases_told: Whether the terminal tells when keys go up.
        run_number: The layout's run number.
        robots: All that is known of each robot, by name.
        chosen: The robot that viewports of `CHOSEN` show and command.
        shown: Which viewports the operator has shown (True) or hidden (False).
        places: Viewports that have a place at this size of the terminal, and whether they are shown
            there until the operator wants it otherwise.
        zooms: How many times larger than its layout says a viewport shows the world, by name.
        wishes: What pictures somebody wants of a robot, by the robot's name.
        night: Robots whose night mode somebody switched on, by name.
        speed_limits: With what share of its speed each robot is driven, 0 to 1; not there: 1.
        theme: The colours.
        notices: What happened, the newest last.
        help: Whether the page that says what keys do lies over the view.
        log: Whether the page of all that happened lies over the view.
        page: How that page is shown.
        rows: Height of the terminal [cells].
        leaving: What speaks against the end of the console, while the operator is asked about it.
        full: The viewport that is shown over the whole view; empty if none is.
        operator: Who sits here.
        clock: The time of day now, such as "14:03:22".
        recording: The file that everything is being recorded in; empty if nothing is.
        trouble: What is wrong with the layout as it was saved last; drawn over everything.
        display: How the picture reaches the operator's eyes; None without a terminal.
        pixel_height: Height of a pixel, half a cell of the terminal, over its width.
        inputs: The first input of each purpose of a widget, in words, by purpose and robot.
        joysticks: All that is known of the layout's joysticks, by name.
        unconfirmed: How many marks a widget has sent that no robot has confirmed, by the widget and
            the robot.
        overdue: How many of those should be confirmed long ago, likewise.
        banner: The alarm that stands over everything; panes do not repeat it.
        ghosts: Marks that were pointed at and are not made yet, by robot.
        sent_off: When each robot was last sent somewhere from here [s], by robot.
    """

    now: float
    held: tuple[str, ...] = ()
    must_release: tuple[str, ...] = ()
    tap_first: bool = False
    hold_s: float = 0.6
    releases_told: bool = False
    run_number: int = 0
    robots: Mapping[str, RobotState] = field(default_factory=dict)
    chosen: str = ""
    shown: Mapping[str, bool] = field(default_factory=dict)
    places: Mapping[str, bool] = field(default_factory=dict)
    zooms: Mapping[str, float] = field(default_factory=dict)
    wishes: Mapping[str, PictureWish] = field(default_factory=dict)
    night: frozenset[str] = frozenset()
    speed_limits: Mapping[str, float] = field(default_factory=dict)
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
    ghosts: Mapping[str, Ghost] = field(default_factory=dict)
    sent_off: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def at_start(cls, layout: LayoutSpec, now: float, operator: str = "") -> Self:
        """The state in which a layout begins; its robots are still to come."""
        return cls(
            now=now,
            run_number=layout.run_number,
            chosen=layout.robots[0].name,
            operator=operator,
            inputs=inputs_of(layout),
            joysticks={
                joystick.name: JoystickState(name=joystick.name) for joystick in layout.joysticks
            },
        )

    @property
    def paged(self) -> bool:
        """Whether a page lies over the view; then only keys of the page, stop and quit count."""
        return self.help or self.log

    @property
    def latency(self) -> float:
        """How long after it is drawn the operator sees a picture [s]; 0 where nobody knows."""
        known = self.display is not None and math.isfinite(self.display.latency)
        return self.display.latency if self.display is not None and known else 0.0

    def robot(self, name: str) -> RobotState | None:
        """The robot of this name, which may be `CHOSEN`; None if there is none."""
        return self.robots.get(self.chosen if name == CHOSEN else name)

    def title(self, robot: str) -> str:
        """The name by which people know the robot of a role; empty for no robot."""
        return titles(self.robots.values()).get(robot, robot)

    def speed_limit(self, robot: str) -> float:
        """With what share of its speed a robot, which may be `CHOSEN`, is driven, 0 to 1."""
        return self.speed_limits.get(self.chosen if robot == CHOSEN else robot, 1.0)

    def unconfirmed_marks(self, robot: str) -> int:
        """How many marks this robot has not confirmed."""
        return sum(count for (_, whose), count in self.unconfirmed.items() if whose == robot)

    def overdue_marks(self, robot: str) -> int:
        """How many marks this robot should have confirmed long ago."""
        return sum(count for (_, whose), count in self.overdue.items() if whose == robot)

    def input_of(self, purpose: Purpose, robot: str) -> str:
        """The input that does this for a robot, in words; empty if none does."""
        chosen = self.inputs.get((purpose, CHOSEN), "") if robot == self.chosen else ""
        return self.inputs.get((purpose, robot), chosen)

    def notice(self, text: str, *, robot: str = "", alarm: bool = False) -> Notice:
        """Something that happens now, for the operator to read."""
        return Notice(text=text, when=self.now, clock=self.clock, robot=robot, alarm=alarm)


def carried_over(state: ConsoleState, layout: LayoutSpec) -> ConsoleState:
    """The state of a console that goes on with another layout.

    What the operator did to viewports and robots that are there again holds.
    """
    robots = {robot.name for robot in layout.robots}
    viewports = {viewport.name for viewport in layout.view.viewports}
    if lost := sum(state.unconfirmed.values()):
        text = f"{lost} marks were not confirmed before the layout changed: are they there?"
        notices = (*state.notices, state.notice(text, alarm=True))
        state = dataclasses.replace(state, notices=notices, unconfirmed={}, overdue={})
    return dataclasses.replace(
        state,
        run_number=layout.run_number,
        chosen=state.chosen if state.chosen in robots else layout.robots[0].name,
        shown={name: shown for name, shown in state.shown.items() if name in viewports},
        full=state.full if state.full in viewports else "",
        zooms={name: zoom for name, zoom in state.zooms.items() if name in viewports},
        wishes={name: wish for name, wish in state.wishes.items() if name in robots},
        night=state.night & robots,
        speed_limits={name: limit for name, limit in state.speed_limits.items() if name in robots},
        trouble="",
        ghosts={},  # whoever would end or confirm them is gone
        inputs=inputs_of(layout),
    )
