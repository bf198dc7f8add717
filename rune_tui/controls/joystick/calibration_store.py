"""Calibrations in the user's configuration: read with care, written whole or not at all."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hub import files
from rune_tui.controls.joystick.calibration import Calibration
from rune_tui.controls.joystick.user_files import user_file

FILE_NAME = "joysticks.json"
_VERSION = 1
_LARGEST_FILE = 1 << 18
_MOST_DEVICES = 200
_MOST_AXES = 64
_LONGEST_NAME = 200
_LARGEST_RAW = 1 << 31

Known = Mapping[str, Mapping[str, Calibration]]
"""Calibrations by device and by the usage of the axis."""


class CalibrationStore:
    """The calibrations of devices, in a file.

    A file that is not valid is ignored, and renamed when a new one is written.

    Attributes:
        path: The file.
        trouble: The mistake in it, in one sentence; empty: none.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.path = path or user_file(FILE_NAME)
        self.trouble = ""
        self._known: dict[str, dict[str, Calibration]] = {}
        try:
            self._known = self._read()
        except FileNotFoundError:
            pass
        except (OSError, ValueError, RecursionError) as error:
            self.trouble = (
                f"the calibrations in {self.path} cannot be read ({error}); joysticks are used "
                "uncalibrated"
            )

    def of(self, device: str) -> Mapping[str, Calibration]:
        """The calibrations of a device's axes, by usage.

        Args:
            device: Its key.
        """
        return self._known.get(device, {})

    def add(self, device: str, found: Mapping[str, Calibration]) -> None:
        """Keep the ranges of a device's axes, by usage; `save` writes them."""
        others = {key: axes for key, axes in self._known.items() if key != device}
        newest = {**self._known.get(device, {}), **found}
        # The mapping as a whole, as a thread may be writing the one before.
        self._known = dict([*others.items(), (device, newest)][-_MOST_DEVICES:])

    def save(self) -> None:
        """Write the file.

        Raises:
            OSError: It cannot be written; the one before is as it was.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if self.trouble:
            with contextlib.suppress(FileNotFoundError):
                self.path.replace(self.path.with_suffix(".broken"))
            self.trouble = ""
        devices = {
            device: dict(map(_written, axes.items())) for device, axes in self._known.items()
        }
        text = json.dumps({"version": _VERSION, "devices": devices}, indent=1)
        files.replace(self.path, text.encode(), mode=0o600)

    def _read(self) -> dict[str, dict[str, Calibration]]:
        whole = _mapping(json.loads(files.read_regular(self.path, _LARGEST_FILE)))
        if whole.get("version") != _VERSION:
            text = f"it is not of version {_VERSION}"
            raise ValueError(text)
        devices = _mapping(whole.get("devices"), _MOST_DEVICES)
        return {
            device: {
                usage: _calibration(f"{device} {usage}", _mapping(stored))
                for usage, stored in _mapping(axes, _MOST_AXES).items()
            }
            for device, axes in devices.items()
        }


def _written(item: tuple[str, Calibration]) -> tuple[str, dict[str, int | None]]:
    usage, found = item
    return usage, {"low": found.low, "high": found.high, "centre": found.centre}


def _mapping(value: object, most: int = 16) -> Mapping[str, Any]:
    if not isinstance(value, dict) or len(value) > most:
        text = "it does not hold the tables that it should"
        raise ValueError(text)
    if any(len(key) > _LONGEST_NAME or not key.isprintable() for key in value):
        text = "a name in it is too long or cannot be printed"
        raise ValueError(text)
    return value


def _calibration(owner: str, stored: Mapping[str, Any]) -> Calibration:
    low, high, centre = (stored.get(name) for name in ("low", "high", "centre"))
    numbers = [low, high] if centre is None else [low, high, centre]
    whole = all(type(number) is int and abs(number) <= _LARGEST_RAW for number in numbers)
    if whole and isinstance(low, int) and isinstance(high, int):
        found = Calibration(low=low, high=high, centre=centre)
        if found.sound:
            return found
    text = f"what it says of {owner} cannot be"
    raise ValueError(text)
