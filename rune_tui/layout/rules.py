"""The rules for visualizers and widget handlers in layouts; each class states its own rule."""

from __future__ import annotations

import enum
import math
import re
from collections.abc import Mapping
from dataclasses import field
from typing import Any, ClassVar, Literal, Protocol

from hub.values import dataclass

NIGHT_MODE_MESSAGE = "RuneToggleNightMode"
LOCAL_MESSAGES = frozenset({NIGHT_MODE_MESSAGE})
"""Messages of the report that never leave the console."""

_DECIMAL = re.compile(r"[+-]?([0-9]{1,18}(\.[0-9]{0,99})?|\.[0-9]{1,99})")


class Section(enum.Enum):
    """The kind of an input's action; the values are the help's headings, in its order."""

    DRIVE = "Stop and drive"
    LOOK = "Look"
    MARK = "Mark"
    ROBOT = "Robot"
    SCREEN = "Screen"
    SESSION = "Session"


class Purpose(enum.Enum):
    """Effects of a widget that matter to the rest of the console.

    Attributes:
        DRIVE: Commands velocities all the time. Only one of a robot's such widgets acts at a time;
            it is a `DrivingWidget`.
        STOP: Stops a robot. Its keys stop the robot under any page.
        QUIT: Ends the console. Its keys answer the question whether to end.
        TAKE_CONTROL: Takes control of a robot. It is a `TakingWidget`.
        RELEASE_CONTROL: Gives up control.
        GRANT_CONTROL: Hands control to the console that asks for it.
        DENY_CONTROL: Keeps control though another console asks for it.
        MISSION: Begins, names or ends a mission.
        CHOOSE_ROBOT: Chooses the robot of the option `robot`.
        NEXT_ALARM: Chooses the robot that needs the operator next.
        FOLLOW: Asks an autopilot to follow the operator.
        DISARM: Takes the power from the motors. Its keys do so under any page.
    """

    DRIVE = enum.auto()
    STOP = enum.auto()
    QUIT = enum.auto()
    TAKE_CONTROL = enum.auto()
    RELEASE_CONTROL = enum.auto()
    GRANT_CONTROL = enum.auto()
    DENY_CONTROL = enum.auto()
    MISSION = enum.auto()
    CHOOSE_ROBOT = enum.auto()
    NEXT_ALARM = enum.auto()
    FOLLOW = enum.auto()
    DISARM = enum.auto()


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberOption:
    """A number that a layout may give.

    Attributes:
        default: Its value where the layout is silent.
        least: Smallest value allowed.
        most: Largest value allowed.
        unit: Its unit; empty for a plain number.
        meaning: Its meaning, for the reference.
    """

    default: float
    least: float
    most: float
    unit: str = ""
    meaning: str

    @property
    def allowed(self) -> str:
        """The allowed values, in words."""
        return f"{self.least:g} to {self.most:g} {self.unit}".rstrip()

    def accepts(self, text: str) -> bool:
        """Whether a layout may give this."""
        return bool(_DECIMAL.fullmatch(text)) and self.least <= float(text) <= self.most

    def value(self, text: str) -> float:
        """The value of an accepted text."""
        return float(text)

    def shown(self, value: float) -> str:
        """A value as a layout would give it."""
        return f"{value:g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceOption:
    """One of several words that a layout may give.

    Attributes:
        default: Its value where the layout is silent.
        choices: All allowed values.
        meaning: Its meaning, for the reference.
        renamed: New names of older spellings, which are still allowed.
        words: Names of choices for people, if they differ.
    """

    default: str
    choices: tuple[str, ...]
    meaning: str
    renamed: Mapping[str, str] = field(default_factory=dict)
    words: Mapping[str, str] = field(default_factory=dict)

    @property
    def allowed(self) -> str:
        """The allowed values, in words."""
        return " or ".join(self.choices)

    def accepts(self, text: str) -> bool:
        """Whether a layout may give this."""
        return text in self.choices or text in self.renamed

    def value(self, text: str) -> str:
        """The value of an accepted text."""
        return self.renamed.get(text, text)

    def shown(self, value: str) -> str:
        """A value as a layout would give it."""
        return value


@dataclass(frozen=True, slots=True, kw_only=True)
class TextOption:
    """Words that a layout may give.

    Attributes:
        default: Its value where the layout is silent.
        longest: How many characters are allowed.
        names: What of the layout it names, or that it names a field of the message that is drawn;
            empty if it may be any words.
        unnamed: An empty value in words, for the help.
        meaning: Its meaning, for the reference.
    """

    default: str = ""
    longest: int = 200
    names: Literal["", "robot", "viewport", "joystick", "field"] = ""
    unnamed: str = ""
    meaning: str

    @property
    def allowed(self) -> str:
        """The allowed values, in words."""
        if self.names == "field":
            return "a number of the message"
        if self.names:
            return f"name of a {self.names} of the layout"
        return f"at most {self.longest} characters"

    def accepts(self, text: str) -> bool:
        """Whether a layout may give this."""
        return len(text) <= self.longest and text.isprintable()

    def value(self, text: str) -> str:
        """The value of an accepted text."""
        return text

    def shown(self, value: str) -> str:
        """A value as a layout would give it."""
        return value or "empty"


Option = NumberOption | ChoiceOption | TextOption


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Options with their values, those that the layout leaves out included.

    Attributes:
        values: By name.
    """

    values: Mapping[str, float | str] = field(default_factory=dict)

    @classmethod
    def of(
        cls, rules: Mapping[str, Option], given: Mapping[str, float | str] | None = None
    ) -> Options:
        """The given values, and defaults for the rest."""
        return cls(values={name: rule.default for name, rule in rules.items()} | dict(given or {}))

    def number(self, name: str) -> float:
        """The value of a number."""
        value = self.values[name]
        return value if isinstance(value, float | int) else math.nan

    def word(self, name: str) -> str:
        """The value of a choice or of a text."""
        return str(self.values[name])


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualizerRule:
    """The rule for a visualizer in layouts.

    Attributes:
        meaning: Its picture, for the reference.
        message: The message it draws; empty if it draws none.
        others: Further messages that it uses if they exist.
        any_message: Whether the layout may name any message of the vocabulary instead.
        text: Whether it shows the attribute `text`.
        font: Whether it can show that in a font of the layout.
        option: Its numeric option, if it has one.
        options: Its other options, by name.
        vital: Whether it matters for the safety of people and robots: its drawing never rests, and
            it stays to be seen while another viewport fills the view.
        pictures: Whether it shows the camera's pictures; it is a `Picturing`.
        locates: Whether it has the place of a pixel; it is a `Locating`.
        draws_over: Whether a part of it must be seen over those with `above`; it is an
            `Overlaying`.
        above: Whether a visualizer below it with `draws_over` is drawn again over it.
        logs: Whether it lists notices, so that they need not pass over the view.
        heads: Whether nothing covers a row of it at the upper edge.
        of_all: Whether it shows all robots, not the one of its viewport.
        names: Whether it has a word for `{shown}` in a title; it is a `Naming`.
        measured: Whether only some bodies measure its message; others give the room away.
    """

    meaning: str
    message: str = ""
    others: tuple[str, ...] = ()
    any_message: bool = False
    text: bool = False
    font: bool = False
    option: NumberOption | None = None
    options: Mapping[str, Option] = field(default_factory=dict)
    vital: bool = False
    pictures: bool = False
    locates: bool = False
    draws_over: bool = False
    above: bool = False
    logs: bool = False
    heads: bool = False
    of_all: bool = False
    names: bool = False
    measured: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class HandlerRule:
    """The rule for a widget handler in layouts.

    Attributes:
        meaning: Its meaning, for the reference.
        controls: The controls that its events move; empty: no choice.
        options: Its options, by name.
        needs_robot: Whether it commands a robot, and so belongs into a viewport.
        sends: Names of the messages that it sends.
        uses: Names of the messages that it makes use of.
        pointed: Whether it needs the place of the mouse, and so events of the mouse.
        words: Effect of a positive and a negative value, by control (empty: none), for the help;
        a handler without them takes no amounts, and so no axes.
        plane: The controls that a whole hat switch moves: the one with left as positive,
            and the one whose positive is up or forward; None if it cannot.
        held: Whether it acts while an input is held, so that a mere moment of it is nothing.
        under_help: Whether its keys count while the help covers everything.
        section: Where the help lists it; None: with the robot if it commands one, else the screen.
        says: The action of its inputs, in a few plain words, by control. In braces are `direction`
            and names of options, for their values. Empty: made of its meaning.
        purpose: Its meaning for the rest of the console; None for most.
        purpose_with: Values of options without which it does not have that purpose.
        also: Other words by which the list of actions finds it.
    """

    meaning: str
    controls: tuple[str, ...] = ()
    options: Mapping[str, Option] = field(default_factory=dict)
    needs_robot: bool = True
    sends: tuple[str, ...] = ()
    uses: tuple[str, ...] = ()
    pointed: bool = False
    words: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    plane: tuple[str, str] | None = None
    held: bool = False
    under_help: bool = False
    section: Section | None = None
    says: Mapping[str, str] = field(default_factory=dict)
    purpose: Purpose | None = None
    purpose_with: Mapping[str, str] = field(default_factory=dict)
    also: str = ""


class RuledVisualizer(Protocol):
    """The interface of a visualizer's class for layouts."""

    rule: ClassVar[VisualizerRule]

    @classmethod
    def from_spec(cls, spec: Any) -> Any:  # noqa: ANN401 - layouts accept any class
        """The visualizer that a layout asks for."""


class RuledWidget(Protocol):
    """The interface of a widget's class for layouts."""

    rule: ClassVar[HandlerRule]

    @classmethod
    def from_spec(cls, spec: Any, robot: str) -> Any:  # noqa: ANN401 - layouts accept any class
        """The widget that a layout asks for."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Vocabulary:
    """All visualizers and widget handlers that a layout may name.

    Attributes:
        visualizers: Classes by function name.
        widgets: Classes by handler name.
        faults: The mistakes of installed packages, by offered name.
    """

    visualizers: Mapping[str, type[RuledVisualizer]]
    widgets: Mapping[str, type[RuledWidget]]
    faults: Mapping[str, str] = field(default_factory=dict)
