"""The content of a layout file as frozen values; only the loader makes them from XML."""

from __future__ import annotations

import enum
from dataclasses import field
from pathlib import Path

from hub.values import dataclass
from rune_tui.layout.rules import Options, Vocabulary

CHOSEN = "*"
"""In place of a robot's name: the one that the operator has chosen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CapabilitySpec:
    """A capability of a robot that the console wants.

    Attributes:
        name: Name from `hub.gcm.capability`.
        interval_s: Shortest time between two requests of its data [s].
    """

    name: str
    interval_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSpec:
    """A robot that the console connects to.

    Attributes:
        name: Its name for viewports.
        hub: Endpoint of its central, such as "tcp://127.0.0.1:1381".
        capabilities: Its wanted capabilities, by name.
        messages: Names of the messages that its viewports and widgets make use of.
        commands: Names of the messages that its widgets send.
        keys: File of the operator's key for it; empty: the one of the command line, if any.
        fleet: The fleet in which its hub is found under its name; empty: the hub is at `hub`.
    """

    name: str
    hub: str
    capabilities: tuple[CapabilitySpec, ...]
    messages: frozenset[str] = frozenset()
    commands: frozenset[str] = frozenset()
    keys: str = ""
    fleet: str = ""


class ControlKind(enum.Enum):
    """The kind of a joystick's control; the values are the words of layouts."""

    AXIS = "axis"
    BALL = "ball"
    BUTTON = "button"
    HAT = "hat switch"


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlSpec:
    """A control of a joystick; only one of role, usage and index is given.

    Attributes:
        name: Its name for events.
        kind: Its kind.
        role: Its role on any device, such as "leftx"; empty: not given.
        usage: Its name in the device's report, such as "rz" or "slider#2"; empty: not given.
        index: Which of its kind it is in the report, from 0.
        calibrate: Whether the operator is asked to move it to its ends.
        minimum: Raw value at one end; None: the device's own.
        maximum: Raw value at the other end; None: the device's own.
        invert: Whether its directions are exchanged; a button is then pressed while it is up.
        deadzone: Neutral share of its range, 0 to 0.9; None: the device's own.
        expo: How much finer it is about its neutral, 0 (linear) to 1; None for the device's own.
        bindings: Raw values of a hat that is pushed up, right, down and left; None for those of
            the device.
    """

    name: str
    kind: ControlKind
    role: str = ""
    usage: str = ""
    index: int | None = None
    calibrate: bool = False
    minimum: int | None = None
    maximum: int | None = None
    invert: bool = False
    deadzone: float | None = None
    expo: float | None = None
    bindings: tuple[int, int, int, int] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class JoystickSpec:
    """A joystick of a layout; without vid, pid, serial and device it is any device.

    Attributes:
        name: Its name for events.
        vid: The vendor's number.
        pid: The product's number.
        serial: The device's serial number; empty for any.
        device: Pattern of the product's name, such as "Logitech*"; empty for any.
        controls: Those that the layout describes, and then the roles that its events name.
    """

    name: str
    vid: int | None = None
    pid: int | None = None
    serial: str = ""
    device: str = ""
    controls: tuple[ControlSpec, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class EventSpec:
    """An input pattern that wakes a widget.

    Attributes:
        name: The input, such as "w", "up", "ctrl+c", "mouse left", "mouse wheel",
            "joystick pad lefty".
        released: Whether it wakes when the input is released, not when it is pressed.
        control: The control that the input moves, if a handler has several, such as
            "translate" or "rotate"; empty where it has one.
        value: How far the control is moved while the key is down, -1 to 1.
        line: Line in the layout file.
    """

    name: str
    control: str
    value: float
    line: int
    released: bool = False
    kind: ControlKind | None = None

    def __hash__(self) -> int:
        return hash(self.name)  # widgets look up their inputs at each move


@dataclass(frozen=True, slots=True, kw_only=True)
class WidgetSpec:
    """Events and the handler that gets them.

    Attributes:
        handler: Name of the handler, such as "widgetSetSpeed".
        options: Options of the handler, with those that the layout leaves out.
        events: Input patterns.
        viewport: The viewport it belongs to; empty for a global widget.
    """

    handler: str
    options: Options
    events: tuple[EventSpec, ...]
    viewport: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class FontSpec:
    """Letters of a size.

    Attributes:
        file: Path of a TrueType file; empty for the font that is built in.
        points: Size [points]; a point is a pixel.
    """

    file: str
    points: float


@dataclass(frozen=True, slots=True, kw_only=True)
class VisualizerSpec:
    """The visualizer of a viewport.

    Attributes:
        function: Name of the function, such as "visualizeCameraImage".
        message: Message it draws, such as "GCM_Common_Image".
        option: Its numeric option; its meaning depends on the visualizer.
        text: Text for visualizers that show one.
        options: Its other options, with those that the layout leaves out.
        viewport: The viewport it draws into.
        font: Letters for its text; None for the terminal's own.
    """

    function: str
    message: str
    option: float
    text: str
    options: Options
    viewport: str = ""
    font: FontSpec | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewportSpec:
    """A visualizer, and the actions of keys, mouse and joysticks there; arrangements place it.

    Attributes:
        name: Name in messages to the operator.
        robot: Robot of the shown messages, or `CHOSEN`.
        visualizer: Its visualizer, if any.
        widgets: The widgets of its inputs.
        title: Text of the rule above it; empty: no rule.
    """

    name: str
    robot: str
    visualizer: VisualizerSpec | None
    widgets: tuple[WidgetSpec, ...]
    title: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceSpec:
    """Where and how an arrangement shows a viewport.

    Attributes:
        viewport: The viewport's name.
        visible: Whether it is drawn at the start.
        transparency: 0 is opaque, 255 cannot be seen.
        xpos: Left edge in design pixels of the arrangement; may be negative.
        ypos: Top edge in design pixels of the arrangement; may be negative.
        zpos: Larger is nearer to the eye.
        xsize: Width in design pixels.
        ysize: Height in design pixels.
        scaled: Whether place and size follow the terminal's; if not, a design pixel is a pixel.
    """

    viewport: str
    visible: bool = True
    transparency: int = 0
    xpos: int
    ypos: int
    zpos: int = 0
    xsize: int
    ysize: int
    scaled: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrangementSpec:
    """The places of viewports on terminals of sufficient size.

    Attributes:
        name: Name in messages to the operator; empty for the only one of a view.
        min_columns: Least width of the terminal [cells].
        min_rows: Least height of the terminal [cells].
        xsize: Design width in pixels; a terminal cell is one pixel wide.
        ysize: Design height in pixels; a terminal cell is two pixels high.
        places: In file order.
    """

    name: str = ""
    min_columns: int = 1
    min_rows: int = 1
    xsize: int
    ysize: int
    places: tuple[PlaceSpec, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewSpec:
    """The whole picture.

    Attributes:
        background: Red, green, blue behind all viewports in the theme "dark"; None: the theme's.
        viewports: In file order.
        widgets: Global widgets.
        arrangements: One or more, in file order.
    """

    background: tuple[int, int, int] | None
    viewports: tuple[ViewportSpec, ...]
    widgets: tuple[WidgetSpec, ...]
    arrangements: tuple[ArrangementSpec, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutSpec:
    """A layout file.

    Attributes:
        path: Where it was read from.
        run_number: The run it is for, shown and recorded.
        robots: Robots, in file order.
        joysticks: Joysticks, in file order.
        view: The whole picture.
        files: The file itself, the parts that it includes, its extensions and its fonts.
        notes: Old spellings in it that still work, a sentence each.
        variables: Names and values of variables that are not those of the file.
        vocabulary: All visualizers and widgets.
    """

    path: str
    run_number: int
    robots: tuple[RobotSpec, ...]
    view: ViewSpec
    joysticks: tuple[JoystickSpec, ...] = ()
    files: tuple[Path, ...] = ()
    notes: tuple[str, ...] = ()
    variables: tuple[tuple[str, str], ...] = ()
    vocabulary: Vocabulary = field(compare=False, repr=False)

    def robot(self, name: str) -> RobotSpec:
        """The robot of this name.

        Raises:
            KeyError: The layout has no such robot; the loader refuses such layouts.
        """
        return next(robot for robot in self.robots if robot.name == name)
