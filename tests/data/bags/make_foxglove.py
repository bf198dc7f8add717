"""A robot that drives 0.5 m/s along x, in messages of Foxglove: in protobuf and in JSON."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import foxglove
import numpy as np
from foxglove import messages as fox
from google.protobuf import json_format
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from PIL import Image

from tests.data.bags.moments import STAMPS, START

Message = tuple[str, Any]
"""A topic and what is published there."""
_LEVEL = fox.Quaternion(x=0, y=0, z=0, w=1)
_ORIGIN = fox.Pose(position=fox.Vector3(x=-2, y=-2, z=0), orientation=_LEVEL)
_HERE = fox.Pose(position=fox.Vector3(), orientation=_LEVEL)
_NUMERIC = fox.PackedElementFieldNumericType


def write_foxglove(path: Path) -> None:
    """By foxglove-sdk, in protobuf."""
    path.unlink(missing_ok=True)
    with foxglove.open_mcap(str(path)):
        for tick, stamp in enumerate(STAMPS):
            time = fox.Timestamp(sec=stamp // 10**9, nsec=stamp % 10**9)
            x = 0.05 * tick
            for topic, message in often(time, x):
                foxglove.log(topic, message, log_time=stamp)
            if tick % 5 == 0:
                for topic, message in (*seen(time), *known(time, x), *said(time)):
                    foxglove.log(topic, message, log_time=stamp)


def often(time: fox.Timestamp, x: float) -> Iterator[Message]:
    """The messages of each tick; `x` is how far the robot is [m]."""
    moved = fox.FrameTransform(
        timestamp=time,
        parent_frame_id="map",
        child_frame_id="base_link",
        translation=fox.Vector3(x=x, y=1.0, z=0.0),
        rotation=_LEVEL,
    )
    fixed = fox.FrameTransform(
        timestamp=time,
        parent_frame_id="base_link",
        child_frame_id="laser",
        translation=fox.Vector3(x=0.2, y=0.0, z=0.0),
        rotation=_LEVEL,
    )
    yield "/tf", fox.FrameTransforms(transforms=[moved, fixed])
    yield "/pose", fox.PoseInFrame(timestamp=time, frame_id="map", pose=pose_at(x))
    yield (
        "/scan",
        fox.LaserScan(
            timestamp=time,
            frame_id="laser",
            pose=_HERE,
            start_angle=-math.pi / 2,
            end_angle=math.pi / 2,
            ranges=np.linspace(1, 3, 31).tolist(),
            intensities=[],
        ),
    )
    yield (
        "/camera/compressed",
        fox.CompressedImage(timestamp=time, frame_id="camera", data=jpeg(), format="jpeg"),
    )


def seen(time: fox.Timestamp) -> Iterator[Message]:
    """A picture without compression, and a cloud of points."""
    raw = np.full((4, 6, 3), (0, 0, 255), np.uint8)
    yield (
        "/raw",
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
    points = np.array([(1, 0, 0), (0, 1, 0.5), (-1, -1, 1)], "<f4")
    yield (
        "/points",
        fox.PointCloud(
            timestamp=time,
            frame_id="base_link",
            pose=_HERE,
            point_stride=12,
            fields=[
                fox.PackedElementField(name=name, offset=4 * at, type=_NUMERIC.Float32)
                for at, name in enumerate("xyz")
            ],
            data=points.tobytes(),
        ),
    )


def known(time: fox.Timestamp, x: float) -> Iterator[Message]:
    """The map, the way ahead, and the place on the earth."""
    cells = np.full((20, 40), 255, np.uint8)
    cells[2:18, 2:38], cells[2, :] = 0, 100
    yield (
        "/map",
        fox.Grid(
            timestamp=time,
            frame_id="map",
            pose=_ORIGIN,
            column_count=40,
            cell_size=fox.Vector2(x=0.25, y=0.25),
            row_stride=40,
            cell_stride=1,
            fields=[fox.PackedElementField(name="occupancy", offset=0, type=_NUMERIC.Uint8)],
            data=cells.tobytes(),
        ),
    )
    yield "/way", fox.PosesInFrame(timestamp=time, frame_id="map", poses=[pose_at(x), _ORIGIN])
    yield (
        "/fix",
        fox.LocationFix(
            timestamp=time, frame_id="gps", latitude=52.5, longitude=13.4, altitude=34.0
        ),
    )


def said(time: fox.Timestamp) -> Iterator[Message]:
    """A log, the data of the camera, and a video."""
    yield (
        "/log",
        fox.Log(
            timestamp=time,
            level=fox.LogLevel.Error,
            message="motor too hot",
            name="base",
            file="",
            line=7,
        ),
    )
    yield (
        "/calibration",
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
    yield (
        "/video",
        fox.CompressedVideo(timestamp=time, frame_id="camera", data=b"\0\0\0\1", format="h264"),
    )


def pose_at(x: float) -> fox.Pose:
    return fox.Pose(position=fox.Vector3(x=x, y=1.0, z=0.0), orientation=_LEVEL)


def jpeg() -> bytes:
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[:, :32, 0], pixels[:, 32:, 1] = 255, 255
    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "JPEG", quality=90)
    return out.getvalue()


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
