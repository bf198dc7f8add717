"""One message of the robot's hub for its fleet: subscribed to while the fleet has subscribers."""

from __future__ import annotations

import functools
import math
from typing import Any

from hub.ipc.client import Client
from hub.ipc.definition import Keep, MessageDefinition, Plane
from hub.ipc.formats.codegen import Buffer
from hub.ipc.message_info import MessageInfo
from hub.zenoh.attachment import Attachment, has_twin, lifespan
from hub.zenoh.fleet_keys import FleetKey, KeyKind
from hub.zenoh.fleet_line import ZenohFleetLine

_LONGEST_WAIT_S = 2.0
"""Longest wait of a message for the line, where its lifespan allows more [s]."""
_ROOM = {
    Plane.COMMAND: KeyKind.STATE,
    Plane.STATE: KeyKind.STATE,
    Plane.PICTURE: KeyKind.PICTURE,
}


class FleetBroadcast:
    """A message for the fleet, with its twin at a low rate where it has one."""

    def __init__(
        self,
        client: Client,
        line: ZenohFleetLine,
        definition: MessageDefinition[Any],
        *,
        fleet: str,
        robot: str,
        thin_hz: float,
    ) -> None:
        """Wait for subscribers in the fleet.

        Args:
            client: The gateway's.
            line: To the fleet.
            definition: The message.
            fleet: Name of the fleet.
            robot: Name of the robot in it.
            thin_hz: Rate of the twin [Hz].
        """
        self._client, self._line, self._definition = client, line, definition
        self._pause = 1.0 / thin_hz
        self._wait = min(lifespan(definition), _LONGEST_WAIT_S)
        self._wanted: dict[KeyKind, bool] = {}
        self._thin_due = -math.inf
        kinds = [_ROOM[definition.plane]]
        if has_twin(definition):
            kinds.append(KeyKind.THIN)
        self._keys = {
            kind: FleetKey(kind=kind, robot=robot, message=definition.name).under(fleet)
            for kind in kinds
        }
        self._watches = [
            line.watch_subscribers(key, functools.partial(self._want, kind))
            for kind, key in self._keys.items()
        ]

    def close(self) -> None:
        """Withdraw it."""
        for watch in self._watches:
            watch.withdraw()
        self._wanted.clear()
        self._client.unsubscribe(self._definition, self._came)

    def _want(self, kind: KeyKind, wanted: bool) -> None:  # noqa: FBT001 - as the line calls it
        before = any(self._wanted.values())
        self._wanted[kind] = wanted
        now = any(self._wanted.values())
        if now and not before:
            self._client.subscribe_payload(self._definition, self._came)
        elif before and not now:
            self._client.unsubscribe(self._definition, self._came)

    def _came(self, payload: Buffer, info: MessageInfo) -> None:
        if info.age > self._wait and math.isfinite(self._definition.lifespan_s):
            return
        whole = bytes(payload)
        header = Attachment(
            publisher=info.publisher,
            fingerprint=self._definition.fingerprint,
            sequence=info.sequence,
            stamp_ns=int(info.measured * 1e9),
        ).pack()
        now = self._client.loop.clock()
        for kind, key in self._keys.items():
            if not self._wanted.get(kind):
                continue
            if kind is KeyKind.THIN:
                if now < self._thin_due:
                    continue
                self._thin_due = max(now, self._thin_due + self._pause)
            newest = self._definition.keep is Keep.NEWEST
            self._line.put(
                key,
                whole,
                header,
                self._definition.plane,
                until=now + self._wait,
                name=(key, info.publisher) if newest else None,
            )
