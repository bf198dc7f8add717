"""Files of parameters, a "NAME,VALUE" a line, as ground stations write and read them."""

from __future__ import annotations

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
_LINE: Final = re.compile(r"([A-Z0-9_]{1,16})(?:\s*,\s*|\s+)(\S+)")


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
        text = files.read_regular(path, _MOST_BYTES).decode()
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        message = f"{path} cannot be read: {reason}"
        raise ParameterFileError(message) from fault
    values: dict[str, float] = {}
    for number, line in enumerate(text.splitlines(), 1):
        content = line.partition("#")[0].strip()
        if content:
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
    """Name and value in a line such as "FS_TIMEOUT,0.1" or "FS_TIMEOUT 0.1".

    Raises:
        ValueError: It is none.
    """
    found = _LINE.fullmatch(text)
    try:
        value = float(found[2]) if found is not None else math.nan
    except ValueError:
        value = math.nan
    if found is None or not abs(value) < 3e38:
        message = f"{text[:40]!r} is no name with a value"
        raise ValueError(message)
    return found[1], value
