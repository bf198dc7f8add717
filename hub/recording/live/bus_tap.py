"""Passes on every message at a hub as it comes, also those that modules define later.

The messages of `_ON_DEMAND` make their publisher work as long as they have subscribers. They are
subscribed to only while another client wants them, so that a recording wakes nothing.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from typing import Any

from hub.errors import HubError
from hub.gcm.catalog import BY_NAME
from hub.gcm.vision import CAMERA_STATE
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import Gathered
from hub.ipc.wire import control
from hub.ipc.wire.control import Change
from hub.ipc.wire.definition_listing import from_listing, to_listing

_logger = logging.getLogger(__name__)

DEFINITION = "rune_definition"
"""The key of a topic's metadata with the definition of a message that is none of GCM, as JSON."""
LIST_S = 5.0
"""Time between two looks at all definitions, if no report was missed [s]."""
_ANSWER_S = 2.0
_ON_DEMAND = frozenset({CAMERA_STATE.name})


def described(definition: MessageDefinition[Any]) -> dict[str, str]:
    """The metadata of a message's topic: a player defines it again; none for those of GCM."""
    if BY_NAME.get(definition.name) is definition:
        return {}
    entry = to_listing(definition)
    facts = {
        "name": entry.name, "format": entry.format, "fields": entry.fields,
        "keep": entry.keep, "plane": entry.plane, "rate_hz": entry.rate_hz,
    }  # fmt: skip
    return {DEFINITION: json.dumps(facts)}


class BusTap:
    """Subscribes to all messages of a hub.

    Attributes:
        names: The messages that it is subscribed to.
        unusable: Why a definition cannot be used, by its name.
    """

    def __init__(
        self,
        client: Client,
        take: Callable[[list[Gathered]], None],
        label: Callable[[MessageDefinition[Any]], object],
        wanted: Callable[[str], bool],
        *,
        wake: bool = False,
    ) -> None:
        """Subscribe; the client's loop does the rest.

        Args:
            client: A client that has no other subscriptions.
            take: Gets the messages as they came, many at once.
            label: What `take` knows a message by.
            wanted: Whether a message of this name is taken.
            wake: Whether messages that others do not want are taken too.
        """
        self._client, self._label, self._wanted, self._wake = client, label, wanted, wake
        client.gather(take)
        self.names: set[str] = set()
        self.unusable: dict[str, str] = {}
        self._known: dict[str, MessageDefinition[Any]] = {}
        self._asked = False
        client.directory.watch(self._on_presence)
        client.directory.follow(client.name, self._on_connection)
        client.every(LIST_S, self._ask)

    def close(self) -> None:
        """Disconnect from the hub."""
        self._client.close()

    @property
    def lost(self) -> dict[str, int]:
        """Number of messages that did not arrive, by name."""
        return self._client.lost_by_message

    def look(self) -> None:
        """Subscribe to what is defined now.

        Raises:
            HubError: The hub does not answer.
        """
        self._asked = False
        listing = self._client.directory.listing(_ANSWER_S)
        for entry in listing.definitions:
            if entry.name not in self._known and self._wanted(entry.name):
                self._learn(entry)
        self._follow_demand(listing)

    def _on_connection(self, number: int) -> None:
        """Look at once after each connection: what others defined before is not reported."""
        if number:
            self._ask()

    def _ask(self) -> None:
        """Look soon; several reports need one look."""
        if not self._asked:
            self._asked = True
            self._client.post(self._look_again)

    def _look_again(self) -> None:
        if not self._client.connected:
            self._asked = False
            return
        try:
            self.look()
        except HubError as error:
            _logger.warning("the messages of the hub are not known: %s", error)

    def _on_presence(self, presence: control.Presence) -> None:
        new = presence.change is Change.DEFINED and presence.message not in self._known
        if new or presence.message in _ON_DEMAND or presence.change is Change.CONNECTED:
            self._ask()

    def _learn(self, entry: control.Define) -> None:
        """Subscribe to a message; a robot of another version may define one of GCM otherwise."""
        try:
            own = BY_NAME.get(entry.name)
            same = own is not None and own.wire_format == entry.format
            definition = own if own is not None and same else from_listing(entry)
            self._known[entry.name] = definition
            if entry.name not in _ON_DEMAND or self._wake:
                self._subscribe(definition)
        except HubError as error:
            if entry.name not in self.unusable:
                _logger.warning("%s is not recorded: %s", entry.name, error)
            self.unusable[entry.name] = str(error)

    def _subscribe(self, definition: MessageDefinition[Any]) -> None:
        self._client.subscribe_gathered(definition, self._label(definition), last=True)
        self.names.add(definition.name)

    def _follow_demand(self, listing: control.Listing) -> None:
        """Subscribe to what others want, and end what they do not want any more."""
        if self._wake:
            return
        demanded = {
            name
            for peer in listing.peers
            if peer.publisher != self._client.number
            for name in peer.subscribes.split()
        }
        for name in _ON_DEMAND & self._known.keys():
            definition = self._known[name]
            if name in demanded and name not in self.names:
                self._subscribe(definition)
            elif name in self.names and name not in demanded:
                self._client.unsubscribe(definition)
                self.names.discard(name)
