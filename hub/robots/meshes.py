"""The points of mesh files: STL, OBJ and COLLADA (DAE); only where they are counts."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.files import read_regular
from hub.robots.xml_text import XmlElement, xml_root

Points = npt.NDArray[np.float64]
"""Places in the frame of the mesh, in its own unit, shape (n, 3)."""
FetchedFiles = Mapping[str, bytes | str]
"""Files of a robot: content, or why there is none, by the names in its URDF."""

_MOST_BYTES: Final = 50_000_000
_MOST_TEXT_BYTES: Final = 20_000_000
_STL_HEAD: Final = 84
_STL_TRIANGLE: Final = np.dtype([("points", "<f4", (4, 3)), ("rest", "<u2")])
"""A triangle of a binary STL: its normal and three corners."""
_NUMBERS: Final = rb"[ \t]+([^ \t\r\n]+)" * 3
_STL_VERTEX: Final = re.compile(rb"^[ \t]*vertex" + _NUMBERS, re.MULTILINE)
_OBJ_VERTEX: Final = re.compile(rb"^[ \t]*v" + _NUMBERS, re.MULTILINE)
_DEEPEST: Final = 100
_MOST_NODES: Final = 10_000
_MOST_POINTS: Final = 2_000_000
_LARGEST: Final = 1e6


def mesh_file(name: str, beside: Path | None) -> Path:
    """The file that a URDF names.

    A package is looked for in the folders above the URDF, and in those of ROS on this machine.

    Args:
        name: Such as "package://carrier/meshes/base.stl", or a path.
        beside: The URDF file; None: it came from a robot, and may name packages only.

    Raises:
        ValueError: It is not there; the text says why.
    """
    scheme, found, rest = name.rpartition("://")
    if found and scheme == "package":
        package, _, inner = rest.partition("/")
        if not package or not inner or ".." in PurePosixPath(rest).parts:
            reason = "it is no file of a package"
            raise ValueError(reason)
        for folder in _package_folders(package, beside):
            if (folder / inner).is_file():
                return folder / inner
        reason = f"the package {package!r} is not on this machine"
        raise ValueError(reason)
    if beside is None or (found and scheme != "file"):
        reason = "it is on the robot" if beside is None else f"{scheme[:20]}:// is not read"
        raise ValueError(reason)
    return beside.parent / rest


def _package_folders(package: str, beside: Path | None) -> Iterator[Path]:
    """Where a package may be."""
    for above in beside.resolve().parents if beside is not None else ():
        if above.name == package:
            yield above
        yield above / package
    for variable, inner in (("AMENT_PREFIX_PATH", "share"), ("ROS_PACKAGE_PATH", "")):
        for place in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            yield Path(place) / inner / package


def mesh_points(path: Path) -> Points:
    """The points of a file.

    Raises:
        ValueError: It cannot be read; the text says why.
    """
    try:
        raw = read_regular(path, _MOST_BYTES)
    except OSError as fault:
        reason = f"it cannot be read: {fault.strerror}"
        raise ValueError(reason) from fault
    return _points_in(path.name, raw)


def mesh_in(files: FetchedFiles, name: str) -> Points:
    """The points of a file of a robot; of one on this machine where the robot gives none.

    Raises:
        ValueError: It cannot be read; the text says why.
    """
    found = files.get(name, "it is not fetched")
    if isinstance(found, bytes):
        return _points_in(name, found)
    try:
        return mesh_points(mesh_file(name, None))
    except ValueError as fault:
        reason = f"{fault}; the robot does not give it: {found}"
        raise ValueError(reason) from fault


def _points_in(name: str, raw: bytes) -> Points:
    """The points in the content of a file.

    Raises:
        ValueError: It cannot be read; the text says why.
    """
    kind = PurePosixPath(name).suffix.lower()
    reader = _READERS.get(kind)
    if reader is None:
        reason = f"files {kind[:20] or 'without a suffix'} are not read, but .stl, .obj and .dae"
        raise ValueError(reason)
    try:
        points = reader(raw)
    except (IndexError, TypeError, np.linalg.LinAlgError) as fault:
        reason = "its numbers make no sense"
        raise ValueError(reason) from fault
    if not len(points) or not np.isfinite(points).all() or np.abs(points).max() > _LARGEST:
        reason = "it has no points, or some that are no places"
        raise ValueError(reason)
    return points


def _stl(raw: bytes) -> Points:
    count = int.from_bytes(raw[_STL_HEAD - 4 : _STL_HEAD], "little")
    if len(raw) >= _STL_HEAD and len(raw) - _STL_HEAD == count * _STL_TRIANGLE.itemsize:
        triangles = np.frombuffer(raw, _STL_TRIANGLE, offset=_STL_HEAD)
        return np.asarray(triangles["points"][:, 1:].reshape(-1, 3), np.float64)
    if not raw.lstrip().startswith(b"solid"):
        reason = "it is no STL, or was cut off"
        raise ValueError(reason)
    return _in_lines(raw, _STL_VERTEX)


def _obj(raw: bytes) -> Points:
    return _in_lines(raw, _OBJ_VERTEX)


def _in_lines(raw: bytes, vertex: re.Pattern[bytes]) -> Points:
    _check_text(raw)
    return np.array(vertex.findall(raw), np.float64).reshape(-1, 3)


def _check_text(raw: bytes) -> None:
    """Refuse a text that would take much memory."""
    if len(raw) > _MOST_TEXT_BYTES:
        reason = f"it is larger than {_MOST_TEXT_BYTES} bytes"
        raise ValueError(reason)


def _dae(raw: bytes) -> Points:
    """All geometries in their places in the scene; [m]."""
    _check_text(raw)
    root = xml_root(raw)
    scenes = _Scenes(root)
    found = [
        points
        for scene in root.iterfind("{*}library_visual_scenes/{*}visual_scene")
        for points in scenes.node(scene, np.eye(4), _DEEPEST)
    ]
    points = np.concatenate([np.empty((0, 3)), *found])
    unit, axis = root.find("{*}asset/{*}unit"), root.findtext("{*}asset/{*}up_axis", "Y_UP")
    points *= float(unit.get("meter", "1")) if unit is not None else 1.0
    # Programs do not agree whether to turn a mesh whose z does not point up: both ways count.
    turned = points[:, (0, 2, 1)] * (1.0, -1.0, 1.0)
    return points if axis.strip() == "Z_UP" else np.concatenate([points, turned])


class _Scenes:
    """The scenes of a COLLADA file; a part may occur in many places of them."""

    def __init__(self, root: XmlElement) -> None:
        parts = root.iter("{*}geometry", "{*}node")
        self._named = {each.get("id"): each for each in parts if each.get("id")}
        self._nodes = self._points = 0

    def node(self, node: XmlElement, outer: Points, depth: int) -> Iterator[Points]:
        """The points of a node and of those within, in the frame of the scene.

        Args:
            node: The node.
            outer: The pose of its parent, shape (4, 4).
            depth: Most nodes within each other.
        """
        self._nodes += 1
        if not depth or self._nodes > _MOST_NODES:
            reason = "it has too many nodes, or some stand in a circle"
            raise ValueError(reason)
        pose = outer
        for each in node.iterchildren("{*}*"):
            tag = each.tag.rpartition("}")[2]
            if tag in _MOVES:
                pose = pose @ _MOVES[tag](np.array((each.text or "").split(), np.float64))
            elif tag == "node":
                yield from self.node(each, pose, depth - 1)
            elif tag == "instance_node":
                yield from self.node(self._of(each), pose, depth - 1)
            elif tag == "instance_geometry":
                points = _geometry(self._of(each))
                self._points += len(points)
                if self._points > _MOST_POINTS:
                    reason = f"it has more than {_MOST_POINTS} points"
                    raise ValueError(reason)
                yield points @ pose[:3, :3].T + pose[:3, 3]
            elif tag in ("instance_controller", "lookat", "skew"):
                reason = f"its <{tag}> is not read"
                raise ValueError(reason)

    def _of(self, instance: XmlElement) -> XmlElement:
        """The part of an instance."""
        part = self._named.get(instance.get("url", "").removeprefix("#"))
        if part is None:
            reason = "it names a part that it does not have"
            raise ValueError(reason)
        return part


def _geometry(element: XmlElement) -> Points:
    """The points of a geometry."""
    sources = {f"#{each.get('id')}": each for each in element.iterfind("{*}mesh/{*}source")}
    found = [np.empty((0, 3))]
    for each in element.iterfind("{*}mesh/{*}vertices/{*}input"):
        source = sources.get(each.get("source", ""))
        if each.get("semantic") == "POSITION" and source is not None:
            numbers = np.array(source.findtext("{*}float_array", "").split(), np.float64)
            accessor = source.find("{*}technique_common/{*}accessor")
            stride = int(accessor.get("stride", "3")) if accessor is not None else 3
            found.append(numbers.reshape(-1, max(3, stride))[:, :3])
    return np.concatenate(found)


def _turn(numbers: Points) -> Points:
    """A turn about an axis by an angle [deg], by Rodrigues' formula."""
    x, y, z = numbers[:3] / np.linalg.norm(numbers[:3])
    cross = np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])
    angle = math.radians(numbers[3])
    made = np.eye(4)
    made[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return made


def _shift(numbers: Points) -> Points:
    made = np.eye(4)
    made[:3, 3] = numbers
    return made


_MOVES: Final[Mapping[str, Callable[[Points], Points]]] = {
    "matrix": lambda numbers: numbers.reshape(4, 4),
    "translate": _shift,
    "rotate": _turn,
    "scale": lambda numbers: np.diag([*numbers, 1.0]),
}
_READERS: Final[Mapping[str, Callable[[bytes], Points]]] = {
    ".stl": _stl,
    ".obj": _obj,
    ".dae": _dae,
}
