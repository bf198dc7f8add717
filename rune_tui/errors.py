"""The console's errors.

    ConsoleError
    ├── LayoutError (ValueError)        a layout file with mistakes, all of them listed
    ├── OwnHubError (RuntimeError)      a hub that the console starts did not come up
    ├── HubChoiceError (ValueError)     one hub is named for several robots
    ├── TunnelError (ConnectionError)   ssh cannot open a tunnel to a robot
    ├── PictureFileError (OSError)      `rune shot` cannot write its file
    ├── DeviceChoiceError (ValueError)  the chosen joystick is not plugged in
    ├── FontError (OSError)             a font that cannot be drawn with
    ├── DescriptorError (ValueError)    a device's report descriptor makes no sense
    └── LogError (ValueError)           a recording that cannot be shown, or a part of it
        └── DamagedLogError             nothing of it can be read

A lost hub, a lost joystick and a stale picture are drawn states, not errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hub.values import dataclass


class ConsoleError(Exception):
    """Root of the console's errors."""


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class LayoutProblem:
    """One mistake in a layout file.

    Attributes:
        path: The file as the operator named it.
        line: Counted from 1; 0 for the whole file.
        column: Counted from 1; 0 if unknown.
        message: The mistake, the nearest known name, the allowed values.
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
        files: Files that were read, and files that are missing.
    """

    def __init__(self, problems: Sequence[LayoutProblem], files: Sequence[Path] = ()) -> None:
        self.problems = tuple(sorted(set(problems)))
        self.files = tuple(files)
        super().__init__("\n".join(map(str, self.problems)))


class DriveAddressError(ConsoleError, ValueError):
    """An address to drive that has no kind of link, or a robot file that would be replaced."""


class OwnHubError(ConsoleError, RuntimeError):
    """A hub that the console starts did not come up."""


class HubChoiceError(ConsoleError, ValueError):
    """One hub is named for several robots."""


class TunnelError(ConsoleError, ConnectionError):
    """Ssh cannot open a tunnel to a robot."""


class PictureFileError(ConsoleError, OSError):
    """A picture file that cannot be written."""


class DeviceChoiceError(ConsoleError, ValueError):
    """The chosen joystick is not plugged in."""


class FontError(ConsoleError, OSError):
    """A font file that cannot be read, or a size that cannot be drawn."""


class DescriptorError(ConsoleError, ValueError):
    """A report descriptor that makes no sense, or is larger than any real device's."""


class LogError(ConsoleError, ValueError):
    """A recording that cannot be shown, or a part of it."""


class DamagedLogError(LogError):
    """A damaged recording, without any part that can be read."""
