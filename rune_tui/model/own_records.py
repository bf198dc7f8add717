"""The messages of recordings about the console itself; they go over no bus.

| message | written |
| --- | --- |
| `RuneTerminal` | at the start, and at each new size |
| `RuneLayout` | when a layout opens; its files are attachments of the recording |
| `RuneState` | when a field of the console's own state changes, on a topic of the field's name |
| `RuneLink` | when the state of the connection to a robot changes |
| `RuneFrame` | for each frame: what it was drawn from, and the checksum of its cells |
| `RuneShown` | when the terminal got a frame, or said that it shows it |
| `RuneInput` | for each input: what became of it |
| `RuneSelect` | when the operator looks at something else |

From these and the messages of robots, `rune replay` draws each frame again.
"""

from __future__ import annotations

import enum
from typing import Annotated

import numpy as np
import numpy.typing as npt

from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.wire_types import Sequence, Uint8, Uint16, Uint32
from hub.values import dataclass
from rune_tui.model.display_state import DisplayState
from rune_tui.model.robot_state import PictureFlow

Numbers = Annotated[npt.NDArray[np.uint32], Sequence()]


@dataclass(frozen=True, slots=True, kw_only=True)
class TerminalRecord:
    """The terminal.

    Attributes:
        columns: Its width [cells]; 0: not drawn yet.
        rows: Its height [cells].
        colours: Its colours, as `--colors` names them.
        glyphs: The characters of pictures, as `--glyphs` names them.
        theme: The theme at that time.
        aspect: Height of a cell over its width.
        term: The variable TERM.
        pixels_across: Pixels of a picture across a cell.
        pixels_down: Pixels of a picture down a cell.
        utc_offset_s: Local time of the console less UTC [s].
    """

    columns: Uint16 = 0
    rows: Uint16 = 0
    colours: str = ""
    glyphs: str = ""
    theme: str = ""
    aspect: float = 2.0
    term: str = ""
    pixels_across: Uint8 = 1
    pixels_down: Uint8 = 2
    utc_offset_s: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class GivenVariable:
    """A variable of a layout that the command line gave.

    Attributes:
        name: Its name.
        value: Its value.
    """

    name: str
    value: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutRecord:
    """The layout that is shown from now on, or its file after a change.

    Attributes:
        layout: Its path.
        run: The number of the experiment's run that it names.
        sha256: Of all its files, in hexadecimal digits.
        variables: The variables that the command line gave.
        files: Names of the attachments with its files; the layout itself comes first.
    """

    layout: str
    run: int
    sha256: str = ""
    variables: Annotated[tuple[GivenVariable, ...], Sequence()] = ()
    files: Annotated[tuple[str, ...], Sequence()] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class StateRecord:
    """A field of the console's own state, from now on.

    Attributes:
        field: Its name in `ConsoleState`.
        value: Its value as JSON, see `plain_values`.
    """

    field: str
    value: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LackRecord:
    """A requested capability that the robot does not provide.

    Attributes:
        capability: Its name.
        kind: The name of the `LackKind`.
        why: The reason in words.
    """

    capability: str
    kind: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class UnfitRecord:
    """A message with values out of their range.

    Attributes:
        message: Its name.
        why: The first fault, in a sentence.
    """

    message: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkRecord:
    """The state of the connection to a robot; fields that `LinkState` has mean the same.

    Attributes:
        robot: The robot's name in the layout.
        topic: Its name in topics of this recording.
        number: Counts the records of this robot; `RuneFrame` refers to it.
        phase: The name of the `LinkPhase`.
        since: Begin of the phase [s].
        endpoint: The hub's endpoint.
        detail: The last failure.
        may_command: Whether the operator's key allows to drive.
        round_trip: Round trip of the newest answer [s].
        bytes_per_s: Rate of received bytes [1/s].
        messages_per_s: Rate of received messages [1/s].
        missed: Number of messages lost.
        console: The console's number at the hub.
        owned_since: Time of day at which its owner got control.
        refusal: Reason of the last refusal.
        refusal_count: Number of refusals.
        lacking: Requested capabilities that are not provided.
        unfit: Messages with values out of their range.
        pictures: Statistics of recent pictures.
    """

    robot: str
    topic: str
    number: Uint32
    phase: str
    since: float
    endpoint: str
    detail: str
    may_command: bool
    round_trip: float
    bytes_per_s: float
    messages_per_s: float
    missed: Uint32
    console: Uint32
    owned_since: str
    refusal: str
    refusal_count: Uint32
    lacking: Annotated[tuple[LackRecord, ...], Sequence()] = ()
    unfit: Annotated[tuple[UnfitRecord, ...], Sequence()] = ()
    pictures: PictureFlow | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FramePicture:
    """A camera's picture in a frame.

    Attributes:
        camera: The camera; empty: the main one.
        number: The received number of the picture.
        interval_s: Usual time until the next one [s].
    """

    camera: str
    number: Uint32
    interval_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameRobot:
    """The state of a robot in a frame, by the received numbers of its messages.

    Attributes:
        robot: The robot's name in the layout.
        link: Number of the `LinkRecord`.
        map: Number of the map; 0: none.
        messages: Numbers of the newest message of each kind.
        diagnostics: Numbers of the newest problems of each publisher.
        publishers: Those publishers, in the same order.
        pictures: The newest picture of each camera.
    """

    robot: str
    link: Uint32
    map: Uint32
    messages: Numbers
    diagnostics: Numbers
    publishers: Numbers
    pictures: Annotated[tuple[FramePicture, ...], Sequence()] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class SlowDrawing:
    """A viewport that rests after a long drawing.

    Attributes:
        viewport: Its name.
        took_s: Processor time of the drawing [s].
    """

    viewport: str
    took_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameRecord:
    """A frame, and all that it was drawn from besides `RuneState` and messages.

    Attributes:
        number: Counts the frames from 1.
        now: The state's time, on the console's monotonic clock [s].
        clock: The state's time of day, such as "14:03:22".
        columns: Width of the view [cells].
        rows: Height of the view [cells].
        arranged: Counts how often the viewports were placed.
        drawn: Whether anything changed; else the frame before stays.
        crc32: Checksum of the cells; 0 if nothing changed.
        display: The state of the connection to the terminal.
        robots: The state of each robot.
        slow: Slow drawings of this frame.
    """

    number: Uint32
    now: float
    clock: str
    columns: Uint16
    rows: Uint16
    arranged: Uint32
    drawn: bool
    crc32: Uint32
    display: DisplayState
    robots: Annotated[tuple[FrameRobot, ...], Sequence()] = ()
    slow: Annotated[tuple[SlowDrawing, ...], Sequence()] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownRecord:
    """A frame on its way to the operator, on the console's monotonic clock.

    Attributes:
        number: The number of the frame.
        handed: Time at which its bytes were handed over [s].
        answered: Time at which the terminal said that it shows it [s]; NaN: it says nothing.
    """

    number: Uint32
    handed: float
    answered: float


class InputOutcome(enum.IntEnum):
    """What became of an input.

    Attributes:
        NONE: It is bound to nothing, changed the console alone, or answered a study's question.
        SENT: A message went to a robot.
        REFUSED: A message to a robot was meant, and a notice gave the reason why none went.
        DEAF: It is bound, and nothing came of it: it was stale, held, or under a page.
        WITHHELD: The study withheld control, so that it could only stop.
    """

    NONE = 0
    SENT = 1
    REFUSED = 2
    DEAF = 3
    WITHHELD = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class InputRecord:
    """An input, as widgets get it.

    Attributes:
        t_read: Time at which the terminal's or the device's report was read [s].
        input: Its name as in layouts, such as "w", "mouse left", "joystick pad lefty".
        pressed: Whether it was pressed, repeated or moved; else released, or an axis in neutral.
        repeat: Whether it was pressed, or out of neutral, before.
        value: 1 for keys; clicks of a wheel; the position of an axis, -1 to 1.
        viewport: The nearest viewport under the mouse; empty: none.
        x: Place in that viewport, as a share of its width.
        y: Place in that viewport, as a share of its height.
        in_picture: Whether a camera's picture is at that place.
        handlers: The widgets that the layout binds to it.
        robot: The robot that it commands, or that the mouse is on; empty: none.
        outcome: What became of it.
    """

    t_read: float
    input: str
    pressed: bool
    repeat: bool
    value: float
    viewport: str
    x: float
    y: float
    in_picture: bool
    handlers: Annotated[tuple[str, ...], Sequence()]
    robot: str
    outcome: InputOutcome


class Selection(enum.IntEnum):
    """What the operator looks at.

    Attributes:
        CHOSEN: The chosen robot.
        PEEKED: The robot that is looked at without commands; empty: the chosen one again.
        FULL: The viewport in full screen; empty: none.
        HELP: The page of keys: open or not.
        LOG: The page of reports: open or not.
        FOCUS: The terminal has the focus, or lost it.
    """

    CHOSEN = 0
    PEEKED = 1
    FULL = 2
    HELP = 3
    LOG = 4
    FOCUS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectRecord:
    """The operator looks at something else.

    Attributes:
        what: What changed.
        robot: The robot, if it is one.
        viewport: The viewport, if it is one.
        on: Whether it begins; False: it ends.
    """

    what: Selection
    robot: str = ""
    viewport: str = ""
    on: bool = True


RUNE_TERMINAL = MessageDefinition(name="RuneTerminal", type=TerminalRecord)
RUNE_LAYOUT = MessageDefinition(name="RuneLayout", type=LayoutRecord)
RUNE_STATE = MessageDefinition(name="RuneState", type=StateRecord)
RUNE_LINK = MessageDefinition(name="RuneLink", type=LinkRecord)
RUNE_FRAME = MessageDefinition(name="RuneFrame", type=FrameRecord)
RUNE_SHOWN = MessageDefinition(name="RuneShown", type=ShownRecord)
RUNE_INPUT = MessageDefinition(name="RuneInput", type=InputRecord)
RUNE_SELECT = MessageDefinition(name="RuneSelect", type=SelectRecord)
