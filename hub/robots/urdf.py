"""The frames and the outline in a URDF file; everything else in it is ignored.

Joints stand at zero. The outline is a polygon around the collision shapes, seen from above;
where there are none, around the visual ones. Poses count from `base_footprint`, else from
`base_link`, else from the link without a parent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hub.errors import RobotFileError
from hub.files import read_regular
from hub.gcm.body import MOST_CORNERS, BodyFrame
from hub.gcm.orientation import angles, rotation
from hub.gcm.standard import BASE_LINK
from hub.plain_text import is_plain
from hub.robots.footprint import footprint_fault
from hub.values import dataclass

Matrix = npt.NDArray[np.float64]
"""A pose as a matrix, shape (4, 4)."""

_MOST_BYTES = 10_000_000
_MOST_LINKS = 1000
_LONGEST_M = 100.0
_ROOTS = ("base_footprint", BASE_LINK)
_RIM = math.tau * np.arange(MOST_CORNERS) / MOST_CORNERS
"""Angles at which a round shape is sampled: those of the edges of the outline [rad]."""
_EDGES = np.stack([np.cos(_RIM), np.sin(_RIM)])
"""Directions of the edges, shape (2, MOST_CORNERS)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class UrdfModel:
    """The part of a URDF file that the hub uses.

    Attributes:
        frames: The frame of each link but the root, by name.
        footprint: Corners of the outline on the ground [m], counter-clockwise, shape (n, 2).
    """

    frames: Mapping[str, BodyFrame]
    footprint: tuple[tuple[float, float], ...]


def read_urdf(path: Path) -> UrdfModel:
    """Read a file.

    Raises:
        RobotFileError: It cannot be read, is no URDF, or has no outline.
    """
    try:
        raw = read_regular(path, _MOST_BYTES)
    except (OSError, ValueError) as fault:
        reason = f"cannot be read: {fault.strerror}" if isinstance(fault, OSError) else str(fault)
        raise RobotFileError(str(path), [reason]) from fault
    return _model_in(raw, str(path))


def urdf_model(text: str, name: str) -> UrdfModel:
    """The model in the text of a file; errors name it by `name`.

    Raises:
        RobotFileError: It is no URDF, or has no outline.
    """
    raw = text.encode(errors="replace")
    if len(raw) > _MOST_BYTES:
        raise RobotFileError(name, [f"has {len(raw)} bytes, more than {_MOST_BYTES}"])
    return _model_in(raw, name)


def _model_in(raw: bytes, name: str) -> UrdfModel:
    try:
        return _model(_parsed(raw))
    except ValueError as error:
        raise RobotFileError(name, [str(error)]) from error


def _parsed(raw: bytes) -> Any:  # noqa: ANN401 - an element of lxml
    try:
        from lxml import etree  # noqa: TID251 - the only XML of the hub, read if it is asked for
    except ImportError as error:
        reason = "lxml is not installed, which reads URDF files; pip install lxml"
        raise ValueError(reason) from error
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False
    )
    try:
        root = etree.fromstring(raw, parser)
    except etree.XMLSyntaxError as fault:
        reason = f"is not XML: {fault}"
        raise ValueError(reason) from fault
    if root.tag != "robot":
        reason = f"line {root.sourceline}: its first element is <{root.tag}>, not <robot>"
        raise ValueError(reason)
    return root


def _model(root: Any) -> UrdfModel:  # noqa: ANN401 - an element of lxml
    links: dict[str, Any] = {}
    for link in root.iterfind("link"):
        name = _name(link)
        if name in links:
            reason = f"line {link.sourceline}: {name!r} is the name of another link"
            raise ValueError(reason)
        links[name] = link
    if not 0 < len(links) <= _MOST_LINKS:
        reason = f"it has {len(links)} links; 1 to {_MOST_LINKS} are allowed"
        raise ValueError(reason)
    joints: dict[str, tuple[str, Matrix]] = {}
    for joint in root.iterfind("joint"):
        parent, child = _linked(joint, "parent", links), _linked(joint, "child", links)
        if child in joints:
            reason = f"line {joint.sourceline}: link {child!r} has two parents"
            raise ValueError(reason)
        joints[child] = parent, _origin(joint)
    poses = {name: _pose(name, joints) for name in links}
    base = next((name for name in _ROOTS if name in links), _only_root(links, joints))
    inverse = np.linalg.inv(poses[base])
    placed = {name: inverse @ pose for name, pose in poses.items()}
    frames = {
        name: _frame(name, pose)
        for name, pose in placed.items()
        if name not in {base, BASE_LINK} and len(name) <= 64 and is_plain(name)
    }
    return UrdfModel(frames=frames, footprint=_footprint(links, placed))


def _name(element: Any) -> str:  # noqa: ANN401 - an element of lxml
    name = element.get("name")
    if not name:
        reason = f"line {element.sourceline}: <{element.tag}> has no name"
        raise ValueError(reason)
    return str(name)


def _linked(joint: Any, end: str, links: Mapping[str, Any]) -> str:  # noqa: ANN401 - of lxml
    element = joint.find(end)
    name = "" if element is None else str(element.get("link", ""))
    if name not in links:
        reason = f"line {joint.sourceline}: the {end} of joint {_name(joint)!r} is no link"
        raise ValueError(reason)
    return name


def _only_root(links: Mapping[str, Any], joints: Mapping[str, Any]) -> str:
    roots = [name for name in links if name not in joints]
    if len(roots) != 1:
        reason = f"{len(roots)} links have no parent, so none is the base"
        raise ValueError(reason)
    return roots[0]


def _pose(name: str, joints: Mapping[str, tuple[str, Matrix]]) -> Matrix:
    """The pose of a link in its tree's root."""
    pose: Matrix = np.eye(4)
    for _ in range(_MOST_LINKS):
        if name not in joints:
            return pose
        name, own = joints[name]
        pose = own @ pose
    reason = f"link {name!r} stands in a circle of joints"
    raise ValueError(reason)


def _numbers(
    element: Any,  # noqa: ANN401 - an element of lxml
    attribute: str,
    usual: str,
    count: int,
    least: float = -_LONGEST_M,
) -> list[float]:
    text = str(element.get(attribute, usual))
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


def _origin(element: Any) -> Matrix:  # noqa: ANN401 - an element of lxml
    """The pose in <origin>: fixed axes, roll first, then pitch, then yaw."""
    pose: Matrix = np.eye(4)
    origin = element.find("origin")
    if origin is not None:
        pose[:3, 3] = _numbers(origin, "xyz", "0 0 0", 3)
        roll, pitch, yaw = _numbers(origin, "rpy", "0 0 0", 3)
        pose[:3, :3] = rotation(roll, pitch, yaw)
    return pose


def _frame(name: str, pose: Matrix) -> BodyFrame:
    (roll, pitch, yaw), (x, y, z) = angles(pose[:3, :3]), pose[:3, 3].tolist()
    return BodyFrame(name=name, x=x, y=y, z=z, roll=roll, pitch=pitch, yaw=yaw)


def _footprint(
    links: Mapping[str, Any], placed: Mapping[str, Matrix]
) -> tuple[tuple[float, float], ...]:
    for kind in ("collision", "visual"):
        reach = np.full(MOST_CORNERS, -np.inf)
        for name, link in links.items():
            for body in link.iterfind(kind):
                for shape in body.iterfind("geometry/*"):
                    if shape.tag in _SHAPES:
                        points = _seen_from_above(shape, placed[name] @ _origin(body))
                        np.maximum(reach, (points @ _EDGES).max(axis=0), out=reach)
        if np.isfinite(reach).all():
            return _hull(reach)
    reason = "no link has a box, cylinder or sphere; give [body], key 'footprint' or 'radius'"
    raise ValueError(reason)


def _seen_from_above(shape: Any, pose: Matrix) -> Matrix:  # noqa: ANN401 - an element of lxml
    """Points whose hull encloses a shape at a pose, seen from above [m], shape (n, 2)."""
    turn = np.eye(3) if shape.tag == "sphere" else pose[:3, :3]
    return np.asarray((_SHAPES[shape.tag](shape) @ turn.T + pose[:3, 3])[:, :2])


def _box(shape: Any) -> Matrix:  # noqa: ANN401 - an element of lxml
    half = np.array(_numbers(shape, "size", "", 3, 0.0)) / 2.0
    corners = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, -1).T
    return np.asarray(corners * half)


def _cylinder(shape: Any) -> Matrix:  # noqa: ANN401 - an element of lxml
    (length,) = _numbers(shape, "length", "", 1, 0.0)
    ends = [np.add(_sphere(shape), (0.0, 0.0, end)) for end in (-length / 2, length / 2)]
    return np.concatenate(ends)


def _sphere(shape: Any) -> Matrix:  # noqa: ANN401 - an element of lxml
    """The corners of a polygon around its equator; a sphere looks the same from all sides."""
    (radius,) = _numbers(shape, "radius", "", 1, 0.0)
    outside = radius / math.cos(math.pi / len(_RIM))
    return outside * np.stack([np.cos(_RIM), np.sin(_RIM), 0.0 * _RIM], axis=1)


_SHAPES = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}


def _hull(reach: Matrix) -> tuple[tuple[float, float], ...]:
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
    corners = tuple(dict.fromkeys(rounded))
    fault = footprint_fault(corners)
    if fault:
        reason = f"the outline of its shapes {fault}"
        raise ValueError(reason)
    return corners
