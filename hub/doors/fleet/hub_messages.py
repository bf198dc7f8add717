"""The messages of the robot's hub, as they are defined: those that a fleet may subscribe to."""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable
from typing import Any

from hub.doors.definitions import definitions_of
from hub.errors import HubError
from hub.gcm.catalog import BY_NAME
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.wire import control
from hub.ipc.wire.control import Change
from hub.ipc.wire.definition_listing import from_listing, to_listing

_logger = logging.getLogger(__name__)

_LIST_S = 5.0


class HubMessages:
    """The definitions at the hub.

    Attributes:
        known: By name.
    """

    def __init__(self, client: Client, learnt: Callable[[MessageDefinition[Any]], None]) -> None:
        """Begin to look.

        Args:
            client: The gateway's.
            learnt: Gets each definition once.
        """
        self._client, self._learnt = client, learnt
        self.known: dict[str, MessageDefinition[Any]] = {}
        self._unusable: set[str] = set()
        self._asked = False
        client.directory.watch(self._on_presence)
        client.directory.follow(client.name, lambda number: self._ask() if number else None)
        client.every(_LIST_S, self._ask)

    def as_json(self) -> bytes:
        """All definitions, for other hubs."""
        return json.dumps([_facts(each) for each in self.known.values()]).encode()

    def _on_presence(self, presence: control.Presence) -> None:
        if presence.change is Change.DEFINED and presence.message not in self.known:
            self._ask()

    def _ask(self) -> None:
        """Look soon; several reports need one look."""
        if not self._asked:
            self._asked = True
            self._client.post(self._look)

    def _look(self) -> None:
        self._asked = False
        for entry in definitions_of(self._client):
            if entry.name not in self.known and entry.name not in self._unusable:
                self._learn(entry)

    def _learn(self, entry: control.Define) -> None:
        try:
            own = BY_NAME.get(entry.name)
            same = own is not None and own.wire_format == entry.format
            definition = own if own is not None and same else from_listing(entry)
        except HubError as error:
            self._unusable.add(entry.name)
            _logger.warning("the fleet does not get %s: %s", entry.name[:80], error)
            return
        self.known[entry.name] = definition
        self._learnt(definition)


def _facts(definition: MessageDefinition[Any]) -> dict[str, object]:
    entry = to_listing(definition)
    facts: dict[str, object] = {
        "name": entry.name,
        "format": entry.format,
        "fields": entry.fields,
        "keep": entry.keep,
        "plane": entry.plane,
        "rate_hz": entry.rate_hz,
        "fingerprint": f"{definition.fingerprint:016x}",
    }
    if math.isfinite(entry.lifespan_s):
        facts["lifespan_s"] = entry.lifespan_s
    return facts
