"""Writes the recordings of this folder with the libraries of others, and what those read in them.

It needs foxglove-sdk, foxglove-schemas-protobuf, mcap, mcap-protobuf-support, mcap-ros1-support,
numpy, pillow and rosbags, and is run by hand; tests read its files only.
"""

from __future__ import annotations

import base64
import io
import json
import math
from pathlib import Path
from typing import Any

import foxglove
import numpy as np
from foxglove import messages as fox
from google.protobuf import descriptor_pb2, json_format
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_ros1.decoder import DecoderFactory as Ros1Factory
from PIL import Image
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

HERE = Path(__file__).parent
START = 1_700_000_000_000_000_000
TICKS = 10
KINDS = [
    *("double", "float", "int64", "uint64", "int32", "fixed64", "fixed32", "bool", "string"),
    *("", "", "bytes", "uint32", "", "sfixed32", "sfixed64", "sint32", "sint64"),
]
EDGES: dict[str, list[Any]] = {
    "bool": [True, False],
    "string": ["", "ab ü€"],
    "bytes": [b"", b"\0\xff"],
    "double": [0.0, -1.5e300, math.pi],
    "float": [0.0, -0.5, 1024.25],
}


def jpeg() -> bytes:
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[:, :32, 0], pixels[:, 32:, 1] = 255, 255
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "JPEG", quality=90)
    return out.getvalue()


def foxglove_messages() -> list[tuple[str, int, Any]]:
    """A robot that drives 0.5 m/s along x."""
    made: list[tuple[str, int, Any]] = []
    unit = fox.Quaternion(x=0, y=0, z=0, w=1)
    cells = np.full((20, 40), 255, np.uint8)
    cells[2:18, 2:38], cells[2, :] = 0, 100
    origin = fox.Pose(position=fox.Vector3(x=-2, y=-2, z=0), orientation=unit)
    numeric = fox.PackedElementFieldNumericType
    for tick in range(TICKS):
        stamp = START + tick * 100_000_000
        x = 0.05 * tick
        time = fox.Timestamp(sec=stamp // 10**9, nsec=stamp % 10**9)
        place = fox.Vector3(x=x, y=1.0, z=0.0)
        moved = fox.FrameTransform(
            timestamp=time,
            parent_frame_id="map",
            child_frame_id="base_link",
            translation=place,
            rotation=unit,
        )
        fixed = fox.FrameTransform(
            timestamp=time,
            parent_frame_id="base_link",
            child_frame_id="laser",
            translation=fox.Vector3(x=0.2, y=0.0, z=0.0),
            rotation=unit,
        )
        made.append(("/tf", stamp, fox.FrameTransforms(transforms=[moved, fixed])))
        pose = fox.Pose(position=place, orientation=unit)
        made.append(("/pose", stamp, fox.PoseInFrame(timestamp=time, frame_id="map", pose=pose)))
        ranges = np.linspace(1, 3, 31).tolist()
        made.append(
            (
                "/scan",
                stamp,
                fox.LaserScan(
                    timestamp=time,
                    frame_id="laser",
                    pose=fox.Pose(position=fox.Vector3(), orientation=unit),
                    start_angle=-math.pi / 2,
                    end_angle=math.pi / 2,
                    ranges=ranges,
                    intensities=[],
                ),
            )
        )
        made.append(
            (
                "/camera/compressed",
                stamp,
                fox.CompressedImage(timestamp=time, frame_id="camera", data=jpeg(), format="jpeg"),
            )
        )
        if tick % 5:
            continue
        raw = np.full((4, 6, 3), (0, 0, 255), np.uint8)
        made.append(
            (
                "/raw",
                stamp,
                fox.RawImage(
                    timestamp=time,
                    frame_id="camera",
                    width=6,
                    height=4,
                    encoding="bgr8",
                    step=18,
                    data=raw.tobytes(),
                ),
            )
        )
        points = np.array([(1, 0, 0), (0, 1, 0.5), (-1, -1, 1)], "<f4")
        fields = [
            fox.PackedElementField(name=name, offset=4 * at, type=numeric.Float32)
            for at, name in enumerate("xyz")
        ]
        made.append(
            (
                "/points",
                stamp,
                fox.PointCloud(
                    timestamp=time,
                    frame_id="base_link",
                    pose=fox.Pose(position=fox.Vector3(), orientation=unit),
                    point_stride=12,
                    fields=fields,
                    data=points.tobytes(),
                ),
            )
        )
        made.append(
            (
                "/map",
                stamp,
                fox.Grid(
                    timestamp=time,
                    frame_id="map",
                    pose=origin,
                    column_count=40,
                    cell_size=fox.Vector2(x=0.25, y=0.25),
                    row_stride=40,
                    cell_stride=1,
                    fields=[fox.PackedElementField(name="occupancy", offset=0, type=numeric.Uint8)],
                    data=cells.tobytes(),
                ),
            )
        )
        made.append(
            ("/way", stamp, fox.PosesInFrame(timestamp=time, frame_id="map", poses=[pose, origin]))
        )
        made.append(
            (
                "/fix",
                stamp,
                fox.LocationFix(
                    timestamp=time, frame_id="gps", latitude=52.5, longitude=13.4, altitude=34.0
                ),
            )
        )
        made.append(
            (
                "/log",
                stamp,
                fox.Log(
                    timestamp=time,
                    level=fox.LogLevel.Error,
                    message="motor too hot",
                    name="base",
                    file="",
                    line=7,
                ),
            )
        )
        made.append(
            (
                "/calibration",
                stamp,
                fox.CameraCalibration(
                    timestamp=time,
                    frame_id="camera",
                    width=64,
                    height=48,
                    distortion_model="plumb_bob",
                    D=[],
                    K=[32.0, 0, 32, 0, 32, 24, 0, 0, 1],
                    R=[1.0, 0, 0, 0, 1, 0, 0, 0, 1],
                    P=[1.0] * 12,
                ),
            )
        )
        made.append(
            (
                "/video",
                stamp,
                fox.CompressedVideo(
                    timestamp=time, frame_id="camera", data=b"\0\0\0\1", format="h264"
                ),
            )
        )
    return made


def write_foxglove(path: Path) -> None:
    """By foxglove-sdk, in protobuf."""
    path.unlink(missing_ok=True)
    with foxglove.open_mcap(str(path)):
        for topic, stamp, message in foxglove_messages():
            foxglove.log(topic, message, log_time=stamp)


def write_json(source: Path, path: Path) -> None:
    """The messages of another file in JSON, with bytes as base64 and times as foxglove has them."""
    with source.open("rb") as file, path.open("wb") as out:
        writer = Writer(out, compression=CompressionType.ZSTD)
        writer.start()
        channels: dict[str, int] = {}
        reader = make_reader(file, decoder_factories=[ProtobufFactory()])
        for schema, channel, message, value in reader.iter_decoded_messages():
            if channel.topic not in channels:
                text = json.dumps({"title": schema.name, "type": "object"}).encode()
                number = writer.register_schema(schema.name, "jsonschema", text)
                channels[channel.topic] = writer.register_channel(channel.topic, "json", number)
            plain = with_times(value, as_dict(value))
            writer.add_message(
                channels[channel.topic],
                message.log_time,
                json.dumps(plain).encode(),
                message.log_time,
            )
        number = writer.register_channel("/bare", "json", 0)
        writer.add_message(
            number, START, b'{"deep": [[1, 2], [3]], "none": null, "speed": 1.5}', START
        )
        writer.finish()


def as_dict(value: Any) -> dict[str, Any]:
    found = json_format.MessageToDict(
        value,
        preserving_proto_field_name=True,
        always_print_fields_with_no_presence=True,
        use_integers_for_enums=True,
    )
    return {**found}


def with_times(value: Any, found: dict[str, Any]) -> dict[str, Any]:
    """Times as {sec, nsec}, as schemas of foxglove in JSON have them."""
    for field, inner in value.ListFields():
        if field.name == "timestamp":
            found["timestamp"] = {"sec": inner.seconds, "nsec": inner.nanos}
        elif field.message_type is not None and not isinstance(found[field.name], list | str):
            with_times(inner, found[field.name])
        elif field.message_type is not None and isinstance(found[field.name], list):
            for each, plain in zip(inner, found[field.name], strict=True):
                with_times(each, plain)
    return found


def all_kinds() -> Any:
    """A type with a field of each kind, alone, in a list, packed or not, in maps and rings."""
    file = descriptor_pb2.FileDescriptorProto(name="kinds.proto", package="a.b", syntax="proto3")
    outer = file.message_type.add(name="Outer")
    kinds = outer.nested_type.add(name="Kinds")
    enum = outer.enum_type.add(name="Colour")
    for at, name in enumerate(("RED", "GREEN", "BLUE")):
        enum.value.add(name=name, number=at if at < 2 else -7)
    for kind, name in enumerate(KINDS, start=1):
        if name:
            kinds.field.add(name=f"one_{name}", number=kind, type=kind, label=1)
            kinds.field.add(name=f"many_{name}", number=100 + kind, type=kind, label=3)
            if name not in ("string", "bytes"):
                loose = kinds.field.add(name=f"loose_{name}", number=200 + kind, type=kind, label=3)
                loose.options.packed = False
    kinds.field.add(name="colour", number=300, type=14, label=1, type_name=".a.b.Outer.Colour")
    kinds.field.add(name="colours", number=301, type=14, label=3, type_name=".a.b.Outer.Colour")
    outer.field.add(name="kinds", number=1, type=11, label=1, type_name=".a.b.Outer.Kinds")
    outer.field.add(name="more", number=536870911, type=11, label=3, type_name=".a.b.Outer.Kinds")
    outer.field.add(name="ring", number=3, type=11, label=1, type_name=".a.b.Outer")
    entry = outer.nested_type.add(name="NamesEntry")
    entry.options.map_entry = True
    entry.field.add(name="key", number=1, type=9, label=1)
    entry.field.add(name="value", number=2, type=17, label=1)
    outer.field.add(name="names", number=4, type=11, label=3, type_name=".a.b.Outer.NamesEntry")
    return file


def fill(kinds: Any) -> None:
    for kind, name in enumerate(KINDS, start=1):
        if not name:
            continue
        bits = 32 if name.endswith("32") else 64
        signed = name.startswith(("int", "sint", "sfixed"))
        whole = [0, 1, 300, 2 ** (bits - signed) - 1] + [-1, -(2 ** (bits - 1))] * signed
        values = EDGES.get(name, whole)
        setattr(kinds, f"one_{name}", values[-1])
        getattr(kinds, f"many_{name}").extend(values)
        if hasattr(kinds, f"loose_{name}"):
            getattr(kinds, f"loose_{name}").extend(values)
        assert kind
    kinds.colour = -7
    kinds.colours.extend([0, 1, -7])


def write_kinds(path: Path) -> None:
    """By the library protobuf."""
    file = all_kinds()
    pool = DescriptorPool()
    pool.Add(file)
    outer = GetMessageClass(pool.FindMessageTypeByName("a.b.Outer"))
    full = outer()
    fill(full.kinds)
    fill(full.more.add())
    full.more.add()
    full.ring.ring.kinds.one_int32 = 5
    full.names["a"], full.names["b"] = -3, 4
    with path.open("wb") as out:
        writer = Writer(out, compression=CompressionType.LZ4)
        writer.start()
        files = descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString()
        schema = writer.register_schema("a.b.Outer", "protobuf", files)
        channel = writer.register_channel("/kinds", "protobuf", schema)
        for at, message in enumerate((outer(), full)):
            writer.add_message(channel, START + at, message.SerializeToString(), START + at)
        writer.finish()


def write_ros1(path: Path) -> None:
    """By rosbags, in the encoding of ROS 1."""
    store = get_typestore(Stores.ROS1_NOETIC)
    frames = "geometry_msgs/TransformStamped[] transforms"
    store.register(get_types_from_msg(frames, "tf2_msgs/msg/TFMessage"))
    types = store.types

    def made(name: str, /, **given: Any) -> Any:
        values = []
        for field, (kind, inner) in store.fielddefs[name][1]:
            if field in given:
                values.append(given.pop(field))
            elif kind == 2:
                values.append(made(inner))
            elif kind == 1:
                values.append("" if inner[0] == "string" else 0)
            else:
                element, count = (*inner,)
                values.append(np.zeros(count if kind == 3 else 0, element[1][0]))
        assert not given, given
        return types[name](*values)

    with path.open("wb") as out:
        writer = Writer(out, compression=CompressionType.LZ4)
        writer.start(profile="ros1")
        channels: dict[str, int] = {}
        for tick in range(TICKS):
            stamp = START + tick * 100_000_000
            time = made("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9)

            def header(frame: str, time: Any = time, tick: int = tick) -> Any:
                return made("std_msgs/msg/Header", seq=tick, stamp=time, frame_id=frame)

            x = 0.05 * tick
            turn = made("geometry_msgs/msg/Quaternion", w=1.0)
            moved = made(
                "geometry_msgs/msg/Transform",
                translation=made("geometry_msgs/msg/Vector3", x=x),
                rotation=turn,
            )
            frame = made(
                "geometry_msgs/msg/TransformStamped",
                header=header("odom"),
                child_frame_id="base_link",
                transform=moved,
            )
            pose = made(
                "geometry_msgs/msg/Pose",
                position=made("geometry_msgs/msg/Point", x=x),
                orientation=turn,
            )
            covariance = np.zeros(36)
            twist = made("geometry_msgs/msg/Twist", linear=made("geometry_msgs/msg/Vector3", x=0.5))
            status = [
                made(
                    "diagnostic_msgs/msg/DiagnosticStatus",
                    level=2,
                    name="motors",
                    message="too hot",
                    values=[made("diagnostic_msgs/msg/KeyValue", key="°C", value="91")],
                )
            ]
            cells = np.zeros((12, 20), np.int8)
            cells[0] = 100
            info = made(
                "nav_msgs/msg/MapMetaData",
                resolution=0.25,
                width=20,
                height=12,
                origin=made(
                    "geometry_msgs/msg/Pose",
                    position=made("geometry_msgs/msg/Point", x=-1.0, y=-1.5),
                    orientation=turn,
                ),
            )
            pixels = np.zeros((6, 8, 3), np.uint8)
            pixels[..., 1] = 255
            messages = {
                "/tf": made("tf2_msgs/msg/TFMessage", transforms=[frame]),
                "/odom": made(
                    "nav_msgs/msg/Odometry",
                    header=header("odom"),
                    child_frame_id="base_link",
                    pose=made(
                        "geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance
                    ),
                    twist=made(
                        "geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=covariance
                    ),
                ),
                "/scan": made(
                    "sensor_msgs/msg/LaserScan",
                    header=header("base_link"),
                    angle_min=-1.0,
                    angle_max=1.0,
                    angle_increment=0.1,
                    range_min=0.1,
                    range_max=8.0,
                    ranges=np.linspace(1, 3, 21, dtype="f4"),
                    intensities=np.zeros(0, "f4"),
                ),
                "/image_raw": made(
                    "sensor_msgs/msg/Image",
                    header=header("camera"),
                    height=6,
                    width=8,
                    encoding="rgb8",
                    step=24,
                    data=pixels.reshape(-1),
                ),
                "/map": made(
                    "nav_msgs/msg/OccupancyGrid",
                    header=header("odom"),
                    info=info,
                    data=cells.reshape(-1),
                ),
                "/diagnostics": made(
                    "diagnostic_msgs/msg/DiagnosticArray", header=header(""), status=status
                ),
                "/battery": made(
                    "sensor_msgs/msg/BatteryState",
                    header=header(""),
                    voltage=12.5,
                    percentage=0.5,
                    present=True,
                    cell_voltage=np.array([4.1, 4.2], "f4"),
                    cell_temperature=np.zeros(0, "f4"),
                ),
                "/empty": made("std_msgs/msg/Empty"),
            }
            for topic, message in messages.items():
                name = message.__msgtype__
                if topic not in channels:
                    text = store.generate_msgdef(name, ros_version=1)[0]
                    schema = writer.register_schema(
                        name.replace("/msg/", "/"), "ros1msg", text.encode()
                    )
                    channels[topic] = writer.register_channel(topic, "ros1", schema)
                raw = bytes(store.serialize_ros1(message, name))
                writer.add_message(channels[topic], stamp, raw, stamp)
        writer.finish()


def read_by_others(path: Path) -> dict[str, list[Any]]:
    """All messages as their own libraries read them, by topic."""
    found: dict[str, list[Any]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[ProtobufFactory(), Ros1Factory()])
        for _, channel, _, value in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(plain(value))
    return found


def plain(value: Any) -> Any:
    """A value of their libraries for JSON; bytes become base64."""
    if isinstance(value, bytes | bytearray):
        return base64.b64encode(value).decode()
    if isinstance(value, bool | int | float | str):
        return value
    if hasattr(value, "DESCRIPTOR"):
        names = [each.name for each in value.DESCRIPTOR.fields]
        return {
            name: None
            if name == "ring" and not value.HasField(name)
            else plain(getattr(value, name))
            for name in names
        }
    if hasattr(value, "__slots__") and not isinstance(value, list | tuple):
        return {each: plain(getattr(value, each)) for each in value.__slots__}
    if isinstance(value, dict) or hasattr(value, "items"):
        return [{"key": key, "value": plain(each)} for key, each in sorted(value.items())]
    return [plain(each) for each in value]


if __name__ == "__main__":
    write_foxglove(HERE / "foxglove.mcap")
    write_json(HERE / "foxglove.mcap", HERE / "foxglove-json.mcap")
    write_kinds(HERE / "kinds.mcap")
    write_ros1(HERE / "ros1.mcap")
    readable = {
        name: {topic: messages[:2] for topic, messages in read_by_others(HERE / name).items()}
        for name in ("foxglove.mcap", "kinds.mcap", "ros1.mcap")
    }
    (HERE / "read-by-others.json").write_text(json.dumps(readable, indent=1), "utf-8")
