"""Every error the console raises on purpose.

    ConsoleError
    ├── LayoutError (ValueError)        a layout file with mistakes, all of them listed
    ├── DemoError (RuntimeError)        the demo's hub did not come up
    ├── HubChoiceError (ValueError)     one hub is named for several robots
    ├── TunnelError (ConnectionError)   ssh does not make a way to a robot
    ├── PictureFileError (OSError)      `rune shot` cannot write its file
    ├── DeviceChoiceError (ValueError)  a joystick is meant that is not plugged in
    ├── FontError (OSError)             a font that cannot be drawn with
    └── DescriptorError (ValueError)    a device describes its reports in a way that makes no sense

A lost hub, a lost joystick and a stale picture are no errors but drawn states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


class ConsoleError(Exception):
    """Root of the console's errors."""


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class LayoutProblem:
    """One mistake in a layout file.

    Attributes:
        path: The file as the operator named it.
        line: Line, counted from 1; 0 when the file as a whole is meant.
        column: Column, counted from 1; 0 when it is not known.
        message: What is wrong, the nearest known name, what is allowed.
    """

    path: str
    line: int
    column: int
    message: str

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.path, self.line, self.column) if part)
        return f"{place}: {self.message}"


class LayoutError(ConsoleError, ValueError):
    """A layout file with mistakes.

    Attributes:
        problems: All mistakes found, in file order.
        files: The files that were read, and those that should have been there.
    """

    def __init__(self, problems: Sequence[LayoutProblem], files: Sequence[Path] = ()) -> None:
        self.problems = tuple(sorted(set(problems)))
        self.files = tuple(files)
        super().__init__("\n".join(map(str, self.problems)))


class DemoError(ConsoleError, RuntimeError):
    """The demo's hub did not come up."""


class HubChoiceError(ConsoleError, ValueError):
    """One hub is named for several robots."""


class TunnelError(ConsoleError, ConnectionError):
    """Ssh does not make a way to a robot."""


class PictureFileError(ConsoleError, OSError):
    """A picture file that cannot be written."""


class DeviceChoiceError(ConsoleError, ValueError):
    """A joystick is meant that is not plugged in."""


class FontError(ConsoleError, OSError):
    """A font whose file cannot be read or is none, or a size that cannot be drawn."""


class DescriptorError(ConsoleError, ValueError):
    """A report descriptor that makes no sense, or describes more than any real device has."""
