"""The user's own file of roles: which control of which pad is the left stick, the trigger, ..."""

from __future__ import annotations

from pathlib import Path

from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.controls.hid.sdl import roles_from_sdl
from rune_tui.controls.joystick.matching import DeviceInfo
from rune_tui.controls.joystick.user_files import read_user_file, user_file

FILE_NAME = "gamecontrollerdb.txt"
"""As SDL_GameControllerDB and the games that take it call it."""
_LARGEST_FILE = 1 << 22


class Mappings:
    """Roles by that file, where it is there; it is read whenever a device is opened.

    Attributes:
        path: The file.
        trouble: What is wrong with it, in one sentence; empty if nothing is.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.path = path or user_file(FILE_NAME)
        self.trouble = ""

    def applied(
        self, device: DeviceInfo, controls: tuple[PhysicalControl, ...]
    ) -> tuple[PhysicalControl, ...]:
        """A device's controls with the roles of its line; as they are if it has none."""
        self.trouble = ""
        try:
            text = read_user_file(self.path, _LARGEST_FILE).decode("utf-8", errors="replace")
        except FileNotFoundError:
            return controls
        except (OSError, ValueError) as error:
            self.trouble = (
                f"the mappings of gamepads in {self.path} cannot be read ({error}); gamepads are "
                "used without them"
            )
            return controls
        return roles_from_sdl(text.splitlines(), controls, device.vid, device.pid, device.bus)
