"""Writes the recordings of this folder with the libraries of others, and what those read in them.

It needs foxglove-sdk, foxglove-schemas-protobuf, mcap, mcap-protobuf-support, mcap-ros1-support,
numpy, pillow and rosbags. It is run by hand, `python -m tests.data.bags.make_foreign`; tests read
its files only.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_ros1.decoder import DecoderFactory as Ros1Factory

from tests.data.bags.make_foxglove import write_foxglove, write_json
from tests.data.bags.make_kinds import write_kinds
from tests.data.bags.make_ros1 import write_ros1

HERE = Path(__file__).parent


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
