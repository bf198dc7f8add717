"""The user's own file of roles: the controls of a pad that are its left stick, its trigger, ..."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from hub.files import read_regular
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.hid.sdl import guid_end, roles_from_sdl
from rune_tui.controls.joystick.user_files import user_file

FILE_NAME = "gamecontrollerdb.txt"
"""As SDL_GameControllerDB and the games that take it call it."""
_LARGEST_FILE = 1 << 22
_MOST_LINES = 64
"""Of one device; a real database has a few."""


class Mappings:
    """Roles by that file, where it is there; it is read whenever a device is opened.

    Attributes:
        path: The file.
        fault: The fault of the file, in one sentence; empty: none.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.path = path or user_file(FILE_NAME)
        self.fault = ""

    def applied(
        self, device: DeviceInfo, controls: tuple[PhysicalControl, ...]
    ) -> tuple[PhysicalControl, ...]:
        """A device's controls with the roles of its line; as they are if it has none."""
        self.fault = ""
        try:
            text = read_regular(self.path, _LARGEST_FILE).decode("utf-8", errors="replace")
        except FileNotFoundError:
            return controls
        except (OSError, ValueError) as error:
            self.fault = (
                f"the mappings of gamepads in {self.path} cannot be read ({error}); gamepads are "
                "used without them"
            )
            return controls
        lines = islice(_lines_of(device, text), _MOST_LINES)
        found = roles_from_sdl(lines, controls, device.vid, device.pid, device.bus, device.name)
        if found.left_out:
            self.fault = (
                f"{device.shown}: its line in {self.path} has {', '.join(found.left_out)} in a "
                "form that Rune cannot use; its own guess counts for them, see rune joytest"
            )
        return found.controls


def _lines_of(device: DeviceInfo, text: str) -> Iterator[str]:
    """Lines with its numbers; to parse each line of a large file would delay input."""
    numbers = guid_end(device.vid, device.pid, device.name)
    at = text.find(numbers) if numbers else -1
    while at >= 0:
        begin, end = text.rfind("\n", 0, at) + 1, text.find("\n", at)
        end = len(text) if end < 0 else end
        yield text[begin:end]
        at = text.find(numbers, end)
