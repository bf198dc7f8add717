"""The frames and the outline in a URDF file; everything else in it is ignored.

Joints stand at zero. The outline is a polygon around the collision shapes of each link, seen from
above; where a link has none that can be read, around its visual ones. Poses count from
`base_footprint`, else from `base_link`, else from the link without a parent.
"""

from __future__ import annotations

import functools
from collections.abc import Container, Mapping
from pathlib import Path

import numpy as np

from hub.errors import RobotFileError
from hub.files import read_regular
from hub.gcm.body import BodyFrame
from hub.gcm.orientation import angles
from hub.gcm.standard import BASE_LINK
from hub.plain_text import is_plain
from hub.robots.meshes import FetchedFiles, mesh_file, mesh_in, mesh_points
from hub.robots.urdf_outline import Matrix, ReadMesh, mesh_names, origin_of, outline_of
from hub.robots.xml_text import XmlElement, xml_root
from hub.values import dataclass

_MOST_BYTES = 10_000_000
_MOST_LINKS = 1000
_LIMITED = ("revolute", "prismatic")
_ROOTS = ("base_footprint", BASE_LINK)


@dataclass(frozen=True, slots=True, kw_only=True)
class UrdfModel:
    """The part of a URDF file that the hub uses.

    Attributes:
        frames: The frame of each link but the root, by name.
        footprint: Corners of the outline on the ground [m], counter-clockwise, shape (n, 2); none:
            no shape could be read.
        fault: Why the outline is not known, or may be too small, in words; empty: it is whole.
        reach: Radius of a circle around all that is known of it [m]; of a link that cannot be
            read, only its place is.
        moved_by: Joints that turn or shift a shape, wheels excepted; they count as at zero.
    """

    frames: Mapping[str, BodyFrame]
    footprint: tuple[tuple[float, float], ...]
    fault: str
    reach: float
    moved_by: tuple[str, ...]


def read_urdf(path: Path) -> UrdfModel:
    """Read a file.

    Raises:
        RobotFileError: It cannot be read, or is no URDF.
    """
    try:
        raw = read_regular(path, _MOST_BYTES)
    except (OSError, ValueError) as fault:
        reason = f"cannot be read: {fault.strerror}" if isinstance(fault, OSError) else str(fault)
        raise RobotFileError(str(path), [reason]) from fault
    return _model_in(raw, str(path), lambda name: mesh_points(mesh_file(name, path)))


def urdf_model(text: str, name: str, files: FetchedFiles) -> UrdfModel:
    """The model in the text of a robot.

    Args:
        text: Its URDF.
        name: Names it in errors.
        files: The files of its meshes.

    Raises:
        RobotFileError: It is no URDF.
    """
    raw = text.encode(errors="replace")
    if len(raw) > _MOST_BYTES:
        raise RobotFileError(name, [f"has {len(raw)} bytes, more than {_MOST_BYTES}"])
    return _model_in(raw, name, functools.partial(mesh_in, files))


def meshes_named(text: str) -> tuple[str, ...]:
    """The files of meshes that the outline of a URDF needs, each once; empty if it is no URDF."""
    try:
        root = _parsed(text.encode(errors="replace")[:_MOST_BYTES])
    except ValueError:
        return ()
    return tuple(dict.fromkeys(mesh_names(root.iterfind("link"))))


def _model_in(raw: bytes, name: str, mesh: ReadMesh) -> UrdfModel:
    try:
        return _model(_parsed(raw), mesh)
    except ValueError as error:
        raise RobotFileError(name, [str(error)]) from error


def _parsed(raw: bytes) -> XmlElement:
    root = xml_root(raw)
    if root.tag != "robot":
        reason = f"line {root.sourceline}: its first element is <{root.tag}>, not <robot>"
        raise ValueError(reason)
    return root


def _model(root: XmlElement, mesh: ReadMesh) -> UrdfModel:
    links: dict[str, XmlElement] = {}
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
        joints[child] = parent, origin_of(joint)
    poses = {name: _pose(name, joints) for name in links}
    base = next((name for name in _ROOTS if name in links), _only_root(links, joints))
    inverse = np.linalg.inv(poses[base])
    placed = {name: inverse @ pose for name, pose in poses.items()}
    frames = {
        name: _frame(name, pose)
        for name, pose in placed.items()
        if name not in {base, BASE_LINK} and len(name) <= 64 and is_plain(name)
    }
    outline = outline_of(links, placed, mesh)
    return UrdfModel(
        frames=frames,
        footprint=outline.corners,
        fault=outline.fault,
        reach=outline.reach,
        moved_by=_moved_by(root, links, {child: parent for child, (parent, _) in joints.items()}),
    )


def _moved_by(
    root: XmlElement, links: Mapping[str, XmlElement], parents: Mapping[str, str]
) -> tuple[str, ...]:
    """The joints with limits that shapes hang on, in the order of the file."""
    limited = {
        _linked(joint, "child", links): _name(joint)
        for joint in root.iterfind("joint")
        if joint.get("type") in _LIMITED
    }
    found = set()
    for name, link in links.items():
        if link.find("collision") is not None or link.find("visual") is not None:
            part = name
            while part in parents:
                found.add(limited.get(part))
                part = parents[part]
    return tuple(each for each in limited.values() if each in found)


def _name(element: XmlElement) -> str:
    name = element.get("name")
    if not name:
        reason = f"line {element.sourceline}: <{element.tag}> has no name"
        raise ValueError(reason)
    return name


def _linked(joint: XmlElement, end: str, links: Mapping[str, XmlElement]) -> str:
    element = joint.find(end)
    name = "" if element is None else element.get("link", "")
    if name not in links:
        reason = f"line {joint.sourceline}: the {end} of joint {_name(joint)!r} is no link"
        raise ValueError(reason)
    return name


def _only_root(links: Mapping[str, XmlElement], joints: Container[str]) -> str:
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


def _frame(name: str, pose: Matrix) -> BodyFrame:
    (roll, pitch, yaw), (x, y, z) = angles(pose[:3, :3]), pose[:3, 3].tolist()
    return BodyFrame(name=name, x=x, y=y, z=z, roll=roll, pitch=pitch, yaw=yaw)
