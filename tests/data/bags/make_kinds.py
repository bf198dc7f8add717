"""A message of protobuf with a field of each kind."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from google.protobuf import descriptor_pb2
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.writer import CompressionType, Writer

from tests.data.bags.moments import START

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
    for name in filter(None, KINDS):
        bits = 32 if name.endswith("32") else 64
        signed = name.startswith(("int", "sint", "sfixed"))
        whole = [0, 1, 300, 2 ** (bits - signed) - 1] + [-1, -(2 ** (bits - 1))] * signed
        values = EDGES.get(name, whole)
        setattr(kinds, f"one_{name}", values[-1])
        getattr(kinds, f"many_{name}").extend(values)
        if hasattr(kinds, f"loose_{name}"):
            getattr(kinds, f"loose_{name}").extend(values)
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
            writer.add_message(
                channel, START + at, message.SerializeToString(deterministic=True), START + at
            )
        writer.finish()
