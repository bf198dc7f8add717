"""A node of ROS 2 with rmw_zenoh, made of eclipse-zenoh and rosbags alone.

It knows nothing of Rune: what both understand is what rmw_zenoh's source says.
"""

from __future__ import annotations

import os
import struct
import threading
import time
from collections.abc import Callable
from typing import Any

import zenoh
from rosbags.typesys import Stores, get_typestore
from zenoh import ext

STORE = get_typestore(Stores.ROS2_JAZZY)
DAY_NS = 86_400 * 10**9


def dds(name: str) -> str:
    package, kind, bare = name.split("/")
    return f"{package}::{kind}::dds_::{bare}_"


class RosNode:
    """One node with its session.

    Attributes:
        clock_ahead_ns: How far its wall clock is ahead [ns].
    """

    def __init__(self, endpoint: str, name: str = "robot", *, domain: int = 0) -> None:
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", f'["{endpoint}"]')
        config.insert_json5("scouting/multicast/enabled", "false")
        config.insert_json5("timestamping/enabled", "true")
        self.session = zenoh.open(config)
        self.clock_ahead_ns = 0
        self._domain, self._name, self._count = domain, name, 0
        self._kept: list[Any] = []
        self._token("NN")

    def _token(self, kind: str, *rest: str) -> None:
        number, self._count = self._count, self._count + 1
        parts = ["@ros2_lv", str(self._domain), str(self.session.zid()), "0", str(number)]
        key = "/".join([*parts, kind, "%", "%", self._name, *rest])
        self._kept.append(self.session.liveliness().declare_token(key))

    def _key(self, topic: str, kind: str, hashed: str) -> str:
        return f"{self._domain}/{topic.strip('/')}/{dds(kind)}/{hashed}"

    def _announce(self, what: str, topic: str, kind: str, hashed: str, quality: str) -> None:
        self._token(what, topic.replace("/", "%"), dds(kind), hashed, quality)

    def publisher(
        self, topic: str, kind: str, *, latched: bool = False, hashed: str = "", old: bool = False
    ) -> Callable[[bytes], None]:
        hashed = hashed or STORE.hash_rihs01(kind)
        self._announce("MP", topic, kind, hashed, f":{'1' if latched else ''}:,10:,:,:,,")
        key = self._key(topic, kind, hashed)
        made: Any
        if latched:
            made = ext.declare_advanced_publisher(
                self.session, key, cache=ext.CacheConfig(max_samples=1), publisher_detection=True
            )
        else:
            block = zenoh.CongestionControl.BLOCK  # as a reliable one has it
            made = self.session.declare_publisher(key, congestion_control=block)
        gid, count = os.urandom(16), 0

        def publish(payload: bytes) -> None:
            nonlocal count
            count += 1
            stamp = time.time_ns() + self.clock_ahead_ns
            attached = struct.pack("<qqB16s", count, stamp, 16, gid)
            if old:
                attached = b"\x0fsequence_number%b\x10source_timestamp%b\x0asource_gid%b" % (
                    *(attached[:8], attached[8:16]),
                    attached[16:],
                )
            made.put(payload, attachment=attached)

        return publish

    def subscribe(
        self,
        topic: str,
        kind: str,
        take: Callable[[bytes, bytes], None],
        *,
        latched: bool = False,
        hashed: str = "",
    ) -> None:
        hashed = hashed or STORE.hash_rihs01(kind)
        self._announce("MS", topic, kind, hashed, f":{'1' if latched else ''}:,10:,:,:,,")
        key = self._key(topic, kind, hashed)

        def came(sample: zenoh.Sample) -> None:
            if sample.attachment is not None:  # rmw_zenoh drops the others
                take(sample.payload.to_bytes(), sample.attachment.to_bytes())

        if latched:
            history = ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
            self._kept.append(
                ext.declare_advanced_subscriber(self.session, key, came, history=history)
            )
        else:
            self._kept.append(self.session.declare_subscriber(key, came))

    def serve(self, name: str, kind: str, answer: Callable[[bytes], bytes | None]) -> None:
        hashed = f"RIHS01_{'ab' * 32}"
        self._announce("SS", name, kind, hashed, "::,10:,:,:,,")

        def asked(query: zenoh.Query) -> None:
            with query:
                assert query.attachment is not None
                assert len(query.attachment.to_bytes()) == 33
                said = answer(query.payload.to_bytes() if query.payload is not None else b"")
                if said is not None:
                    query.reply(query.key_expr, said, attachment=query.attachment)

        key = self._key(name, kind, hashed)
        self._kept.append(self.session.declare_queryable(key, asked, complete=True))

    def put(self, key: str, payload: bytes, attachment: bytes | None) -> None:
        """Anything, as anyone on the network can."""
        self.session.put(key, payload, attachment=attachment)

    def announce(self, key: str) -> None:
        self._kept.append(self.session.liveliness().declare_token(key))

    def leave(self) -> None:
        self.session.close()


def encoded(kind: str, message: Any) -> bytes:
    return bytes(STORE.serialize_cdr(message, kind))


class Paced:
    """Calls something at a rate until it is left, from a thread of its own."""

    def __init__(self, work: Callable[[], None], rate_hz: float) -> None:
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(work, 1.0 / rate_hz))
        self._thread.start()

    def _run(self, work: Callable[[], None], pause: float) -> None:
        while not self._end.wait(pause):
            work()

    def leave(self) -> None:
        self._end.set()
        self._thread.join()
