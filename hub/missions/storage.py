"""The folder of saved maps: NAME.pgm, NAME.yaml and NAME.geojson."""

from __future__ import annotations

import os
import re
from pathlib import Path

from hub import files
from hub.errors import MapFileError
from hub.gcm.mapping import InterestPoint
from hub.gcm.occupancy_map import OccupancyMap
from hub.missions import point_file, ros_map

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")


def checked_name(name: str) -> str:
    """The name, which cannot lead out of the folder.

    Raises:
        MapFileError: It is no name of a map.
    """
    if _NAME.fullmatch(name) is None:
        text = (
            f"{name[:40]!r} is no name of a map: up to 64 letters, digits, dots, '-' and '_',"
            " not beginning with a dot or '-'"
        )
        raise MapFileError(text)
    return name


def save(folder: Path, name: str, picture: OccupancyMap, points: tuple[InterestPoint, ...]) -> Path:
    """Write a map; a file that is there already is replaced as a whole, or not at all.

    Returns:
        The YAML file, which is written last.

    Raises:
        MapFileError: It has a wrong name, or a file cannot be written.
    """
    described = folder / f"{checked_name(name)}.yaml"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files.replace(folder / f"{name}.pgm", ros_map.encode_pgm(picture))
        files.replace(folder / f"{name}.geojson", point_file.encode_points(points))
        files.replace(described, ros_map.encode_yaml(picture, f"{name}.pgm"))
    except OSError as fault:
        text = f"map {name} cannot be written to {folder}: {fault.strerror or fault}"
        raise MapFileError(text) from fault
    return described


def load(folder: Path, name: str) -> tuple[OccupancyMap, tuple[InterestPoint, ...]]:
    """Read a map; there are no points where there is no file of them.

    Raises:
        MapFileError: It has a wrong name, or a file cannot be read or is damaged.
    """
    described = folder / f"{checked_name(name)}.yaml"
    header = ros_map.decode_yaml(files.read(described, ros_map.MAX_YAML_BYTES))
    image = folder / checked_name(header.image)
    grey = ros_map.decode_pgm(files.read(image, ros_map.MAX_PGM_BYTES))
    picture = ros_map.picture_of(header, grey)
    marked = folder / f"{name}.geojson"
    if not os.path.lexists(marked):
        return picture, ()
    return picture, point_file.decode_points(files.read(marked, point_file.MAX_BYTES))
