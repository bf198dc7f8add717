"""A map as ROS's map_server writes and reads it: a PGM picture and a YAML file of few keys; pure.

Black is occupied, white free, grey 205 unknown; the picture's first row is the one at the largest y
(http://wiki.ros.org/map_server). Read is what map_server would read, mode "trinary" only, and
nothing else of YAML than one `key: value` a line.
"""

from __future__ import annotations

import re
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from hub.errors import MapFileError
from hub.gcm.map_coding import MAX_CELLS
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.turned_cells import turned_map
from hub.pose import Pose
from hub.values import dataclass

MAX_YAML_BYTES = 10_000
MAX_PGM_BYTES = MAX_CELLS + 1024

_OCCUPIED, _UNKNOWN, _FREE = 0, 205, 254
_OCCUPIED_FROM, _FREE_TO = 65, 25
"""Percent; map_saver's own."""
_GAP = rb"(?:\s|#[^\n]{0,200}\n){1,200}"
_PGM = re.compile(rb"P5" + _GAP + rb"(\d{1,8})" + _GAP + rb"(\d{1,8})" + _GAP + rb"(\d{1,8})\s")
_LINE = re.compile(r"([a-z_]{1,40})[ \t]*:(?:[ \t]+(.*))?")
_NUMBER = re.compile(r"[-+]?(\d{1,20}(\.\d{0,20})?|\.\d{1,20})([eE][-+]?\d{1,3})?")
_FARTHEST = 1e5


@dataclass(frozen=True, slots=True, kw_only=True)
class MapHeader:
    """The content of the YAML file.

    Attributes:
        image: Name of the picture, in the same folder.
        resolution: Edge of a cell [m].
        origin_x: Lower left corner of the picture in `map` [m].
        origin_y: Lower left corner of the picture in `map` [m].
        theta: Direction of the picture's rows in `map`, from left to right [rad].
        negate: Whether white is occupied.
        occupied_thresh: A cell that is occupied with a greater probability counts as occupied.
        free_thresh: A cell that is occupied with a smaller probability counts as free.
    """

    image: str
    resolution: float
    origin_x: float
    origin_y: float
    theta: float = 0.0
    negate: bool = False
    occupied_thresh: float = 0.65
    free_thresh: float = 0.196


def encode_pgm(picture: OccupancyMap) -> bytes:
    """The picture's file."""
    cells = picture.cells[::-1]
    grey = np.full(cells.shape, _UNKNOWN, np.uint8)
    grey[(cells >= 0) & (cells <= _FREE_TO)] = _FREE
    grey[cells >= _OCCUPIED_FROM] = _OCCUPIED
    height, width = cells.shape
    return f"P5\n# Rune {picture.resolution:.3f} m/pix\n{width} {height}\n255\n".encode() + (
        grey.tobytes()
    )


def encode_yaml(picture: OccupancyMap, image: str) -> bytes:
    """The YAML file beside the picture of this name."""
    return (
        f"image: {image}\n"
        f"resolution: {picture.resolution:.6f}\n"
        f"origin: [{picture.origin_x:.6f}, {picture.origin_y:.6f}, 0.000000]\n"
        "negate: 0\n"
        "occupied_thresh: 0.65\n"
        "free_thresh: 0.196\n"
        "mode: trinary\n"
    ).encode()


def decode_pgm(raw: bytes) -> npt.NDArray[np.uint8]:
    """The shades of a picture's file, shape (height, width), first row at the largest y.

    Raises:
        MapFileError: It is no binary PGM of 8 bits, too large, or cut.
    """
    match = _PGM.match(raw[:4096])
    if match is None:
        _refuse("picture is no binary PGM (P5)")
    width, height, white = (int(digits) for digits in match.groups())
    if white != 255:
        _refuse(f"picture's white is {white}, not 255")
    # Checked before anything is made of that size.
    if not (width >= 1 and height >= 1 and width * height <= MAX_CELLS):
        _refuse(f"picture of {width}x{height} cells is not between 1 and {MAX_CELLS} cells")
    body = raw[match.end() :]
    if len(body) != width * height:
        _refuse(f"picture of {width}x{height} cells has {len(body)} bytes of them")
    return np.frombuffer(body, np.uint8).reshape(height, width)


def decode_yaml(raw: bytes) -> MapHeader:
    """The content of the YAML file.

    Raises:
        MapFileError: It is too large, no such file, or a value is missing or out of its bounds.
    """
    values = _lines(raw)
    if values.get("mode", "trinary") != "trinary":
        _refuse(f"mode is {values['mode'][:40]!r}; only trinary is read")
    origin = values.get("origin", "")
    parts = origin[1:-1].split(",") if origin[:1] == "[" and origin[-1:] == "]" else []
    if len(parts) != 3:
        _refuse("origin is not [x, y, yaw]")
    x, y, yaw = (_number("origin", part.strip(), -_FARTHEST, _FARTHEST) for part in parts)
    negate = values.get("negate", "")
    if negate not in ("0", "1"):
        _refuse("negate is neither 0 nor 1")
    header = MapHeader(
        image=values.get("image", ""),
        resolution=_number("resolution", values.get("resolution", ""), 0.001, 100.0),
        origin_x=x,
        origin_y=y,
        theta=yaw,
        negate=negate == "1",
        occupied_thresh=_number("occupied_thresh", values.get("occupied_thresh", ""), 0.0, 1.0),
        free_thresh=_number("free_thresh", values.get("free_thresh", ""), 0.0, 1.0),
    )
    if header.free_thresh >= header.occupied_thresh:
        _refuse("free_thresh is not below occupied_thresh")
    return header


def picture_of(header: MapHeader, grey: npt.NDArray[np.uint8]) -> OccupancyMap:
    """The cells that map_server would publish of the two files, along x: -1, 0 and 100.

    Raises:
        MapFileError: The picture is turned, and too large for that.
    """
    shades = np.arange(256) / 255.0
    occupied = shades if header.negate else 1.0 - shades
    table = np.full(256, -1, np.int8)
    table[occupied > header.occupied_thresh] = 100
    table[occupied < header.free_thresh] = 0
    origin = Pose(x=header.origin_x, y=header.origin_y, theta=header.theta)
    made = turned_map(np.take(table, grey[::-1]), header.resolution, origin)
    if made is None:
        _refuse(f"picture is turned by {header.theta:g} rad, and too large for that")
    return made


def _lines(raw: bytes) -> dict[str, str]:
    """The values by their keys, without comments and quotes."""
    if len(raw) > MAX_YAML_BYTES:
        _refuse(f"description is larger than {MAX_YAML_BYTES} bytes")
    try:
        text = raw.decode()
    except UnicodeDecodeError as error:
        reason = f"the map's description is no UTF-8 text at byte {error.start}"
        raise MapFileError(reason) from error
    values: dict[str, str] = {}
    for number, whole in enumerate(text.splitlines(), start=1):
        line = re.split(r"(?:^|\s)#", whole, maxsplit=1)[0].rstrip()
        if not line or line in ("---", "..."):
            continue
        match = _LINE.fullmatch(line)
        if match is None or match[1] in values:
            _refuse(f"description, line {number}: {whole[:40]!r} is no new 'key: value'")
        value = (match[2] or "").strip()
        quoted = len(value) >= 2 and value[0] == value[-1] and value[0] in "'\""
        values[match[1]] = value[1:-1] if quoted else value
    return values


def _number(key: str, text: str, low: float, high: float) -> float:
    if _NUMBER.fullmatch(text) is None or not low <= float(text) <= high:
        _refuse(f"{key} {text[:40]!r} is not a number between {low:g} and {high:g}")
    return float(text)


def _refuse(reason: str) -> NoReturn:
    text = f"the map's {reason}"
    raise MapFileError(text)
