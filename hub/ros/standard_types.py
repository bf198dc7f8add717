"""Types of ROS 2 that messages of Rune are translated into, field for field."""

from __future__ import annotations

import enum
from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt

from hub.gcm.body import Metres32
from hub.gcm.fields import Name, Number, Sentence
from hub.gcm.geometry import Point3D, Pose3D
from hub.gcm.map_coding import MAX_CELLS
from hub.gcm.standard import Header, Time
from hub.gcm.transforms import Translation
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import FLOAT32, Sequence, Uint32, Wire
from hub.values import dataclass

_MOST_MARKERS = 3000
_Part: TypeAlias = Annotated[float, Range(0.0, 1.0), FLOAT32]
_Octets: TypeAlias = Annotated[npt.NDArray[np.uint8], Sequence(), Most(1 << 26)]
_NONE = np.empty(0, np.uint8)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CompressedImage:
    """sensor_msgs/CompressedImage.

    Attributes:
        header: Its time, and the optical frame of the camera.
        format: "jpeg" or "webp".
        data: The file, shape (n,).
    """

    ros_type = "sensor_msgs/msg/CompressedImage"

    header: Header = Header()
    format: Name = ""
    data: _Octets


@dataclass(frozen=True, slots=True, kw_only=True)
class MapMetaData:
    """nav_msgs/MapMetaData.

    Attributes:
        map_load_time: When the map was loaded; 0: not known.
        resolution: Edge of a cell [m].
        width: Cells along x.
        height: Cells along y.
        origin: Pose of the corner of cell (0, 0).
    """

    ros_type = "nav_msgs/msg/MapMetaData"

    map_load_time: Time = Time()
    resolution: Metres32
    width: Number
    height: Number
    origin: Pose3D


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GridOfMap:
    """nav_msgs/OccupancyGrid.

    Attributes:
        header: Time of its newest measurement, and its frame.
        info: Its size and place.
        data: -1 unknown, 0 free to 100 occupied, row by row from the least y, shape (n,).
    """

    ros_type = "nav_msgs/msg/OccupancyGrid"

    header: Header
    info: MapMetaData
    data: Annotated[npt.NDArray[np.int8], Sequence(), Most(MAX_CELLS)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourRgba:
    """std_msgs/ColorRGBA.

    Attributes:
        r: Red, 0 to 1.
        g: Green.
        b: Blue.
        a: 0: not seen, 1: not transparent.
    """

    ros_type = "std_msgs/msg/ColorRGBA"

    r: _Part = 0.0
    g: _Part = 0.0
    b: _Part = 0.0
    a: _Part = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Lifetime:
    """builtin_interfaces/Duration; 0: without an end.

    Attributes:
        sec: Whole seconds.
        nanosec: The rest [ns].
    """

    ros_type = "builtin_interfaces/msg/Duration"

    sec: int = 0
    nanosec: Uint32 = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class UvCoordinate:
    """visualization_msgs/UVCoordinate: a place on a texture.

    Attributes:
        u: 0 to 1.
        v: 0 to 1.
    """

    ros_type = "visualization_msgs/msg/UVCoordinate"

    u: _Part = 0.0
    v: _Part = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshFile:
    """visualization_msgs/MeshFile; empty: none.

    Attributes:
        filename: Its name.
        data: The file, shape (n,).
    """

    ros_type = "visualization_msgs/msg/MeshFile"

    filename: Name = ""
    data: _Octets


class MarkerKind(enum.IntEnum):
    """What a marker is drawn as, of ROS's kinds those that are used."""

    SPHERE = 2
    TEXT = 9


class MarkerAction(enum.IntEnum):
    """What happens with a marker."""

    ADD = 0
    DELETE_ALL = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Marker:
    """visualization_msgs/Marker.

    Attributes:
        header: Its time and frame.
        ns: With `id`, its name.
        id: With `ns`, its name.
        type: What it is drawn as.
        action: What happens with it.
        pose: Its place.
        scale: Its size along each axis [m]; of a text, z.
        color: Its colour.
        lifetime: When it vanishes.
        frame_locked: Whether it moves with its frame.
        points: Of lines, none here.
        colors: Of `points`.
        texture_resource: Name of a texture.
        texture: The texture.
        uv_coordinates: Where the texture lies on `points`.
        text: What is written.
        mesh_resource: Name of a mesh.
        mesh_file: The mesh.
        mesh_use_embedded_materials: Whether the mesh brings its colours.
    """

    ros_type = "visualization_msgs/msg/Marker"

    header: Header = Header()
    ns: Name = ""
    id: int = 0
    type: Annotated[MarkerKind, Wire("int")] = MarkerKind.SPHERE
    action: Annotated[MarkerAction, Wire("int")] = MarkerAction.ADD
    pose: Pose3D = Pose3D()
    scale: Translation = Translation()
    color: ColourRgba = ColourRgba()
    lifetime: Lifetime = Lifetime()
    frame_locked: bool = False
    points: Annotated[tuple[Point3D, ...], Sequence(), Most(0)] = ()
    colors: Annotated[tuple[ColourRgba, ...], Sequence(), Most(0)] = ()
    texture_resource: Name = ""
    texture: CompressedImage = CompressedImage(data=_NONE)
    uv_coordinates: Annotated[tuple[UvCoordinate, ...], Sequence(), Most(0)] = ()
    text: Sentence = ""
    mesh_resource: Name = ""
    mesh_file: MeshFile = MeshFile(data=_NONE)
    mesh_use_embedded_materials: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MarkerArray:
    """visualization_msgs/MarkerArray.

    Attributes:
        markers: The markers.
    """

    ros_type = "visualization_msgs/msg/MarkerArray"

    markers: Annotated[tuple[Marker, ...], Sequence(), Most(_MOST_MARKERS)] = ()


class LogSeverity(enum.IntEnum):
    """The levels of `LogEntry`, as ROS numbers them."""

    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


@dataclass(frozen=True, slots=True, kw_only=True)
class LogEntry:
    """rcl_interfaces/Log.

    Attributes:
        stamp: When it was said.
        level: How bad it is.
        name: Who says it.
        msg: What.
        file: Of the program; empty.
        function: Of the program; empty.
        line: Of the program; 0.
    """

    ros_type = "rcl_interfaces/msg/Log"

    stamp: Time
    level: Annotated[LogSeverity, Wire("ubyte")]
    name: Name
    msg: Sentence
    file: Name = ""
    function: Name = ""
    line: Number = 0
