"""Files of parameters, as ground stations write them.

| ground station | line | comment |
| --- | --- | --- |
| Mission Planner, Rune | NAME,VALUE | # to the end |
| MAVProxy | NAME VALUE, columns of spaces; whole numbers also as 0x1F | # to the end |
| QGroundControl | system, component, NAME, VALUE, type; tabs between | # to the end |

Lines of QGroundControl for other components than the autopilot are left out. A mark of the byte
order at the start is skipped; UTF-16 is read too.
"""

from __future__ import annotations

import codecs
import math
import re
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from hub import files, paths
from hub.errors import ParameterFileError
from hub.robots.mavlink.asking.parameters import MOST_PARAMETERS, Parameter, shown

_MOST_BYTES: Final = 1 << 20
_NAME: Final = re.compile(r"[A-Z0-9_]{1,16}")
_BETWEEN: Final = re.compile(r"\s*,\s*|\s+")
_HEXADECIMAL: Final = re.compile(r"-?0[xX][0-9a-fA-F]{1,8}")
_COLUMNS: Final = 5
"""Columns of a line of QGroundControl."""
_AUTOPILOT: Final = "1"
"""Number of the component that is the autopilot."""


def keep_parameters(robot: str, vehicle: str, parameters: Iterable[Parameter]) -> Path:
    """Write present values to a new file in the user's folder; returns its path.

    Args:
        robot: Name for the file.
        vehicle: What the vehicle is, for the first line.
        parameters: The values.

    Raises:
        ParameterFileError: It cannot be written.
    """
    folder = paths.for_vehicle_parameters()
    now = time.localtime()
    stamp = time.strftime("%Y%m%d-%H%M%S", now)
    lines = [f"# {vehicle}, before a change at {time.strftime('%Y-%m-%d %H:%M:%S', now)}"]
    lines += [f"{each.name},{shown(each.value)}" for each in parameters]
    name = f"{paths.as_file_name(robot)}-{stamp}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.param"
        number = 2
        while path.exists():
            path = folder / f"{name}-{number}.param"
            number += 1
        files.replace(path, "\n".join([*lines, ""]).encode())
    except OSError as fault:
        text = f"the old values cannot be kept in {folder}: {fault.strerror}; nothing was changed"
        raise ParameterFileError(text) from fault
    return path


def read_parameters(path: Path) -> dict[str, float]:
    """The values in a file, by name.

    Raises:
        ParameterFileError: It cannot be read, or a line is no parameter.
    """
    try:
        text = _decoded(files.read_regular(path, _MOST_BYTES))
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        message = f"{path} cannot be read: {reason}"
        raise ParameterFileError(message) from fault
    values: dict[str, float] = {}
    for number, line in enumerate(text.splitlines(), 1):
        content = line.partition("#")[0].strip()
        if content and not _is_of_another_component(content):
            try:
                name, value = parameter_in(content)
            except ValueError as fault:
                message = f"{path}, line {number}: {fault}"
                raise ParameterFileError(message) from fault
            values[name] = value
    if not 0 < len(values) <= MOST_PARAMETERS:
        message = f"{path} has {len(values)} parameters, not 1 to {MOST_PARAMETERS}"
        raise ParameterFileError(message)
    return values


def parameter_in(text: str) -> tuple[str, float]:
    """Name and value in a line such as "FS_TIMEOUT,0.1", or one of another ground station.

    Raises:
        ValueError: It is none.
    """
    columns = _BETWEEN.split(text.strip())
    name, *rest = columns[2:4] if _is_of_qgroundcontrol(columns) else columns
    value = _number(rest[0]) if len(rest) == 1 else math.nan
    if _NAME.fullmatch(name) is None or not abs(value) < 3e38:
        message = f"{text[:40]!r} is no name with a value"
        raise ValueError(message)
    return name, value


def _decoded(data: bytes) -> str:
    """The text of a file; letters of comments in another coding do no harm."""
    is_wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return data.decode("utf-16" if is_wide else "utf-8-sig", "replace")


def _is_of_qgroundcontrol(columns: list[str]) -> bool:
    return len(columns) == _COLUMNS and columns[0].isdecimal() and columns[1].isdecimal()


def _is_of_another_component(text: str) -> bool:
    columns = _BETWEEN.split(text)
    return _is_of_qgroundcontrol(columns) and columns[1] != _AUTOPILOT


def _number(text: str) -> float:
    """A number as ground stations write it; NaN: it is none."""
    if _HEXADECIMAL.fullmatch(text):
        return float(int(text, 16))
    try:
        return float(text)
    except ValueError:
        return math.nan
