"""What coding costs: messages to bytes and back, pictures and maps to run lengths and back.

rosbags makes the same bytes from an object of its own. protobuf makes others, of a type that is
described at run time; its fields are set from the values and read again.
"""

from __future__ import annotations

import operator
import struct
import timeit
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.figures import median_ms, report
from hub.gcm import map_coding, navigation, rle, vision
from hub.gcm.geometry import Twist, TwistStamped
from hub.ipc import ros_schema
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import grammar as formats
from hub.modules.driver.reports import drive_state
from hub.robots.interfaces import Sensors


def robot_state() -> navigation.RobotState:
    return navigation.RobotState(
        stamp=1e9,
        x=1.0,
        y=2.0,
        theta=0.5,
        linear=0.3,
        angular=0.1,
        commanded_linear=0.3,
        commanded_angular=0.1,
        bumpers=0,
        battery_voltage=24.0,
        battery_fraction=0.8,
        motion=navigation.MotionState.MOVING,
        refused=0,
    )


def image(data: npt.NDArray[np.uint8]) -> vision.Image:
    camera = vision.CameraState(
        stamp=1e9,
        pan=0.0,
        tilt=0.0,
        zoom=0.0,
        horizontal_fov=0.8,
        vertical_fov=0.6,
        mount_forward=0.1,
        mount_height=0.4,
        pan_limit=1.7,
        tilt_limit=0.4,
        slewing=0,
    )
    return vision.Image(
        camera=camera,
        coding=vision.ImageCoding.RLE,
        width_px=160,
        height_px=120,
        channels=3,
        data=data,
    )


def natural_picture() -> npt.NDArray[np.uint8]:
    """A room as a camera sees it, with a rough poster and the sensor's noise; (120, 160, 3)."""
    random = np.random.default_rng(5)
    rows, columns = np.mgrid[0:120, 0:160]
    floor = rows > 55
    shade = np.where(floor, 60 + rows, 190 - np.abs(columns - 80) * 0.5)
    picture = shade[..., None] * np.where(floor[..., None], (0.9, 0.8, 0.6), (0.8, 0.85, 0.9))
    for left, top, width, height, colour in (
        (20, 40, 30, 40, (150, 60, 40)),
        (90, 50, 24, 22, (40, 90, 150)),
        (120, 30, 8, 60, (70, 70, 70)),
    ):
        picture[top : top + height, left : left + width] = colour
    picture[10:40, 60:90] += random.normal(0.0, 8.0, (30, 30, 1))
    picture += random.normal(0.0, 0.3, picture.shape)
    return np.clip(picture, 0, 255).astype(np.uint8)


def building_map() -> npt.NDArray[np.int8]:
    """Rooms with walls in unknown space, as a finished map has them; (400, 400), three levels."""
    random = np.random.default_rng(7)
    cells = np.full((400, 400), -1, np.int8)
    for _ in range(14):
        top, left = random.integers(20, 300, 2)
        height, width = random.integers(30, 90, 2)
        cells[top : top + height, left : left + width] = 0
        cells[top : top + height, [left, left + width]] = 100
        cells[[top, top + height], left : left + width] = 100
    return cells


Work = Callable[[], object]


def microseconds(*works: Work, calls: int = 2000) -> list[float]:
    """Median for each, over runs of many calls of one after the other [us]."""
    times = [[timeit.timeit(work, number=calls) for work in works] for _ in range(15)]
    return [sorted(each)[len(each) // 2] / calls * 1e6 for each in zip(*times, strict=True)]


def rosbags_work(definition: MessageDefinition[Any], value: object) -> tuple[Work, Work]:
    """What rosbags does to write a message and to read it."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    name, store = ros_schema.ros_type(definition), get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(ros_schema.ros2msg(definition), name))
    payload = b"".join(definition.encode(value))
    theirs = store.deserialize_cdr(payload, name)
    if bytes(store.serialize_cdr(theirs, name)) != payload:
        raise AssertionError(name)
    return (
        lambda: store.serialize_cdr(theirs, name),
        lambda: store.deserialize_cdr(payload, name),
    )


def protobuf_work(definition: MessageDefinition[Any], value: object) -> tuple[Work, Work]:
    """What protobuf does to write a message with the same fields and to read it."""
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

    field = descriptor_pb2.FieldDescriptorProto
    kinds = {"double": field.TYPE_DOUBLE, "float": field.TYPE_FLOAT, "string": field.TYPE_STRING}
    file = descriptor_pb2.FileDescriptorProto(name="peer.proto", syntax="proto3")
    message, given = file.message_type.add(name="Peer"), {}
    for number, (name, node, item) in enumerate(leaves(definition.tree, value), 1):
        element = str(getattr(node, "element", node))
        label, kind = field.LABEL_OPTIONAL, kinds.get(element, field.TYPE_INT32)
        given[f"{name}_{number}"] = item
        if element == "ubyte" and isinstance(item, np.ndarray):
            kind, given[f"{name}_{number}"] = field.TYPE_BYTES, item.tobytes()
        elif isinstance(item, np.ndarray):
            label = field.LABEL_REPEATED
        message.field.add(name=f"{name}_{number}", number=number, type=kind, label=label)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    peer = message_factory.GetMessageClass(pool.FindMessageTypeByName("Peer"))
    payload = peer(**given).SerializeToString()
    read = operator.attrgetter(*given)
    return lambda: peer(**given).SerializeToString(), lambda: read(peer.FromString(payload))


def leaves(node: formats.Format, value: object) -> Iterator[tuple[str, formats.Format, Any]]:
    """Name, format and value of each member, and of those of inner structs."""
    for name, member in zip(vars(type(value))["__dataclass_fields__"], node.members, strict=True):
        item = getattr(value, name)
        if isinstance(member, formats.Struct):
            yield from leaves(member, item)
        else:
            yield name, member, item


def coding(name: str, definition: MessageDefinition[Any], value: object, bar: float) -> None:
    """One message to bytes and back, by us and by others in turns."""
    payload = b"".join(definition.encode(value))
    works = [lambda: b"".join(definition.encode(value)), lambda: definition.decode(payload)]
    peers, notes = [], []
    for peer, prepare in (("rosbags", rosbags_work), ("protobuf", protobuf_work)):
        try:
            works += prepare(definition, value)
        except ImportError:
            notes.append(f"{peer} is not installed")
        else:
            peers.append(peer)
    there, back, *others = microseconds(*works, calls=500)
    notes.insert(0, f"encode {there:.2f}, decode {back:.2f}; {len(payload)} bytes")
    pairs = zip(others[::2], others[1::2], strict=True)
    beside = dict(zip(peers, (round(sum(pair), 2) for pair in pairs), strict=True))
    report(name, there + back, "us", bar=bar, peers=beside, note="; ".join(notes))


def flat_coding() -> None:
    """A message of numbers only as one struct, the way a client packs it."""
    command, definition = navigation.TurnCommand(angle=0.5), navigation.TURN_COMMAND
    packer = struct.Struct(f"<4x{definition.flat_letters}")
    take, make = definition.flat_values, definition.receive_flat
    payload = packer.pack(*take(command))
    there, back = microseconds(
        lambda: packer.pack(*take(command)), lambda: make(packer.unpack(payload))
    )
    note = f"encode {there:.2f}, decode {back:.2f}; {len(payload)} bytes"
    report("codec.flat_us", there + back, "us", note=note)


def main() -> None:
    coding("codec.state_us", navigation.ROBOT_STATE, robot_state(), bar=3)
    picture = natural_picture()
    coding("codec.image_us", vision.IMAGE, image(picture.reshape(-1)), bar=15)
    sensors = Sensors(
        x=1.0, y=2.0, z=0.3, theta=0.5, roll=0.1, pitch=0.05, velocity=Twist.planar(0.3, 0.1)
    )
    coding("codec.drive_state_us", navigation.DRIVE_STATE, drive_state(sensors, 1e9), bar=20)
    (made,) = microseconds(lambda: drive_state(sensors, 1e9))
    report("codec.drive_state_made_us", made, "us", note="by the driver, 50 times a second")
    command = TwistStamped.planar(0.5, 0.2)
    coding("codec.command_us", navigation.VELOCITY_COMMAND, command, bar=6)
    flat_coding()

    for quality, which in ((60, ""), (100, "_exact")):
        coded = rle.encode(picture, quality=quality)
        note = f"quality {quality}: {len(coded)} of {picture.size} bytes"
        value = median_ms(lambda _, q=quality: rle.encode(picture, quality=q), 300)
        report(f"rle.image{which}_encode_ms", value, "ms", bar=0.4, note=note)
        value = median_ms(lambda _, c=coded: rle.decode(c, 120, 160, 3), 300)
        report(f"rle.image{which}_decode_ms", value, "ms", bar=0.3, note=note)

    cells = building_map()
    coded = map_coding.encode(cells)
    note = f"{len(coded)} of {cells.size} bytes"
    value = median_ms(lambda _: map_coding.encode(cells), 300)
    report("rle.map_encode_ms", value, "ms", bar=0.2, note=note)
    value = median_ms(lambda _: map_coding.decode(coded, 400, 400), 300)
    report("rle.map_decode_ms", value, "ms", bar=0.2, note=note)
    report("rle.map_bytes", len(coded), "bytes", bar=1000)


if __name__ == "__main__":
    main()
