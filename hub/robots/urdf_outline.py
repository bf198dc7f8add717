"""The outline of the shapes of a URDF file on the ground."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.gcm.body import MOST_CORNERS
from hub.gcm.orientation import rotation
from hub.plain_text import plain
from hub.robots.footprint import footprint_fault
from hub.robots.meshes import Points
from hub.robots.xml_text import XmlElement
from hub.values import dataclass

Matrix = npt.NDArray[np.float64]
"""A pose as a matrix, shape (4, 4)."""
ReadMesh = Callable[[str], Points]
"""Reads the points of the mesh of this name; raises ValueError with the reason why not."""
_KINDS: Final = ("collision", "visual")
"""Shapes of a link; the second are needed where it has none of the first."""

_LONGEST_M: Final = 100.0
_RIM: Final = math.tau * np.arange(MOST_CORNERS) / MOST_CORNERS
"""Angles at which a round shape is sampled: those of the edges of the outline [rad]."""
_EDGES: Final = np.stack([np.cos(_RIM), np.sin(_RIM)])
"""Directions of the edges, shape (2, MOST_CORNERS)."""
_AT_ONCE: Final = 10_000
_MOST_NAMED: Final = 3
_NONE: Final = "no link has a box, cylinder, sphere or mesh"


@dataclass(frozen=True, slots=True, kw_only=True)
class UrdfOutline:
    """The outline of a robot, as `UrdfModel` has it."""

    corners: tuple[tuple[float, float], ...]
    fault: str
    reach: float


def mesh_names(links: Iterable[XmlElement]) -> Iterator[str]:
    """The files of meshes that the outline of links needs."""
    for link in links:
        for kind in _KINDS:
            shapes = [*link.iterfind(f"{kind}/geometry/*")]
            yield from (each.get("filename", "") for each in shapes if each.tag == "mesh")
            if shapes:
                break


def outline_of(
    links: Mapping[str, XmlElement], placed: Mapping[str, Matrix], mesh: ReadMesh
) -> UrdfOutline:
    """The outline of links.

    Args:
        links: By name.
        placed: The pose of each on the robot.
        mesh: Reads the points of a mesh.

    Raises:
        ValueError: A shape makes no sense.
    """
    reach = np.full(MOST_CORNERS, -np.inf)
    left_out, reaches = [], 0.0
    for name, link in links.items():
        faults: list[str] = []
        for kind in _KINDS:
            shapes = [
                (shape, placed[name] @ origin_of(body))
                for body in link.iterfind(kind)
                for shape in body.iterfind("geometry/*")
            ]
            unread = [fault for each in shapes if (fault := _add(*each, mesh, reach))]
            faults += unread
            if shapes and not unread:
                faults.clear()
                break
        if faults:
            x, y = placed[name][:2, 3].tolist()
            reaches = max(reaches, math.hypot(x, y))
            left_out.append(f"link {plain(name)[:64]!r} at [{x:.2g}, {y:.2g}] ({faults[0]})")
    known = bool(np.isfinite(reach).all())
    corners = _corners(reach) if known else ()
    fault = "" if known or left_out else _NONE
    if left_out:
        more = len(left_out) - _MOST_NAMED
        named = ", ".join(left_out[:_MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
        fault = f"the outline lacks {named}"
    elif known and (wrong := footprint_fault(corners)):
        fault = f"the outline of its shapes {wrong}"
    reaches = max([reaches, *(math.hypot(x, y) for x, y in corners)])
    return UrdfOutline(corners=corners, fault=fault, reach=reaches)


def _add(shape: XmlElement, pose: Matrix, mesh: ReadMesh, reach: Matrix) -> str:
    """Widen an outline by a shape at a pose; returns why that cannot be done, in words."""
    try:
        points = _seen_from_above(shape, pose, mesh)
    except _UnreadError as fault:
        return str(fault)
    for begin in range(0, len(points), _AT_ONCE):
        some = points[begin : begin + _AT_ONCE] @ _EDGES
        np.maximum(reach, some.max(axis=0), out=reach)
    return ""


class _UnreadError(Exception):
    """A shape cannot be read, which is no mistake of the URDF file."""


def _numbers(
    element: XmlElement,
    attribute: str,
    usual: str,
    count: int,
    least: float = -_LONGEST_M,
) -> list[float]:
    text = element.get(attribute, usual)
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(least <= each <= _LONGEST_M for each in numbers):
        reason = (
            f"line {element.sourceline}: {attribute} of <{element.tag}> is not {count} numbers"
            f" from {least:g} to {_LONGEST_M:g}"
        )
        raise ValueError(reason)
    return numbers


def origin_of(element: XmlElement) -> Matrix:
    """The pose in <origin>: fixed axes, roll first, then pitch, then yaw."""
    pose: Matrix = np.eye(4)
    origin = element.find("origin")
    if origin is not None:
        pose[:3, 3] = _numbers(origin, "xyz", "0 0 0", 3)
        roll, pitch, yaw = _numbers(origin, "rpy", "0 0 0", 3)
        pose[:3, :3] = rotation(roll, pitch, yaw)
    return pose


def _seen_from_above(shape: XmlElement, pose: Matrix, mesh: ReadMesh) -> Matrix:
    """Points whose hull encloses a shape at a pose, seen from above [m], shape (n, 2)."""
    turn = np.eye(3) if shape.tag == "sphere" else pose[:3, :3]
    if shape.tag == "mesh":
        points = _mesh(shape, mesh)
    elif shape.tag == "capsule":
        length = _numbers(shape, "length", "", 1, 0.0)[0]
        ends = np.array([(0.0, 0.0, -length / 2), (0.0, 0.0, length / 2)]) @ turn.T
        turn, points = np.eye(3), (ends[:, None] + _sphere(shape)).reshape(-1, 3)
    elif shape.tag in _SHAPES:
        points = _SHAPES[shape.tag](shape)
    else:
        reason = f"<{plain(shape.tag)[:32]}> is not read"
        raise _UnreadError(reason)
    return np.asarray((points @ turn.T + pose[:3, 3])[:, :2])


def _mesh(shape: XmlElement, mesh: ReadMesh) -> Matrix:
    """The points of a mesh [m], shape (n, 3)."""
    name, scale = shape.get("filename", ""), _numbers(shape, "scale", "1 1 1", 3)
    try:
        points = mesh(name) * scale
        farthest = np.abs(points).max()
    except ValueError as fault:
        reason = f"{plain(name)[:120]}: {fault}"
        raise _UnreadError(reason) from fault
    if farthest > _LONGEST_M:
        reason = f"{plain(name)[:120]}: it is {farthest:.0f} m large"
        raise _UnreadError(reason)
    return np.asarray(points)


def _box(shape: XmlElement) -> Matrix:
    half = np.array(_numbers(shape, "size", "", 3, 0.0)) / 2.0
    corners = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    return np.asarray(corners * half)


def _cylinder(shape: XmlElement) -> Matrix:
    (length,) = _numbers(shape, "length", "", 1, 0.0)
    ends = [np.add(_sphere(shape), (0.0, 0.0, end)) for end in (-length / 2, length / 2)]
    return np.concatenate(ends)


def _sphere(shape: XmlElement) -> Matrix:
    """The corners of a polygon around its equator; a sphere looks the same from all sides."""
    (radius,) = _numbers(shape, "radius", "", 1, 0.0)
    outside = radius / math.cos(math.pi / len(_RIM))
    return outside * np.stack([np.cos(_RIM), np.sin(_RIM), 0.0 * _RIM], axis=1)


_SHAPES: Final[Mapping[str, Callable[[XmlElement], Matrix]]] = {
    "box": _box,
    "cylinder": _cylinder,
    "sphere": _sphere,
}


def _corners(reach: Matrix) -> tuple[tuple[float, float], ...]:
    """The corners of a polygon with an edge in each direction of `_RIM`.

    Neighbours i and i + 1 of the edges `x cos a + y sin a = reach` meet at a corner.

    Args:
        reach: How far its shapes go in these directions [m], shape (MOST_CORNERS,).
    """
    following, ahead = np.roll(reach, -1), np.roll(_RIM, -1)
    between = math.sin(math.tau / MOST_CORNERS)
    x = (reach * np.sin(ahead) - following * np.sin(_RIM)) / between
    y = (following * np.cos(_RIM) - reach * np.cos(ahead)) / between
    rounded = [(round(float(a), 4), round(float(b), 4)) for a, b in zip(x, y, strict=True)]
    return tuple(dict.fromkeys(rounded))
