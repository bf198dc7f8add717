"""What ROS 2 Jazzy makes of payloads: reads lines of JSON, a type and bytes in hexadecimal each.

Run by the Python of `.venv-ros2`. Writes for each line the hash of the type, and the bytes that
rclpy writes of the message that it has read; the first line is written once it can begin.
"""

from __future__ import annotations

import importlib
import json
import sys
from typing import Any

import rclpy
from rclpy.serialization import deserialize_message, serialize_message


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("types")
    hashes: dict[str, str] = {}

    def hash_of(name: str, kind: Any) -> str:
        if name not in hashes:
            topic = f"/of_{len(hashes)}"
            publisher = node.create_publisher(kind, topic, 1)
            (end,) = node.get_publishers_info_by_topic(topic)
            hashes[name] = str(end.topic_type_hash)
            node.destroy_publisher(publisher)
        return hashes[name]

    for line in sys.stdin:
        asked = json.loads(line)
        package, _, last = asked["type"].split("/")
        try:
            kind = getattr(importlib.import_module(f"{package}.msg"), last)
        except ImportError:
            answer: dict[str, Any] = {"missing": True}
        else:
            answer = {"hash": hash_of(asked["type"], kind)}
            if "payload" in asked:
                message = deserialize_message(bytes.fromhex(asked["payload"]), kind)
                answer["payload"] = serialize_message(message).hex()
                answer["text"] = str(message)[:200]
        sys.stdout.write(json.dumps(answer) + "\n")
        sys.stdout.flush()


main()
