"""The open door: a hub on one side, panels on the other, one loop between."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Final

from hub.doors.panels.hub_topics import HubTopics, PictureWishes
from hub.doors.panels.panel_drive import PanelDrive
from hub.doors.panels.parameters import parameters_of
from hub.doors.panels.wishes import SenderKind, TopicServer
from hub.errors import HubError
from hub.gcm.body import RobotBody
from hub.gcm.capability import Capability
from hub.gcm.supervision import CAPABILITY_WANTS, LEASE_S, CapabilityWants
from hub.ipc.client import Client
from hub.ipc.security.client_keys import read_client_keys

_WANT_EVERY_S: Final = LEASE_S / 3.0
_LAST_WORDS_S: Final = 0.5
_CONNECT_S: Final = 5.0


class PanelDoor:
    """Passes messages to panels, and their commands to the robot."""

    def __init__(
        self,
        client: Client,
        open_server: Callable[[Callable[[], None]], TopicServer],
        pictures: PictureWishes,
        *,
        sender: SenderKind | None = None,
        keys: Path | None = None,
    ) -> None:
        """Open it.

        Args:
            client: A connected client for this alone.
            open_server: Opens the server; it calls its argument when panels want something else.
            pictures: What they get of cameras.
            sender: What drives; None: no panel does.
            keys: File of the key of `client`.

        Raises:
            HubError: The server cannot be opened, or the hub does not answer.
        """
        self._client, self._drives = client, sender is not None
        self._driven = False
        self._linked = True
        self._wanted: frozenset[str] = frozenset()
        self._server = open_server(lambda: client.post(self._follow))
        self._topics = HubTopics(client, self._server, pictures, self._described)
        self._driver: Client | None = None
        self._drive: PanelDrive | None = None
        if sender is not None:
            # Control belongs to a client; this one subscribes to its state.
            found = read_client_keys(keys) if keys else None
            driver = Client(f"{client.name}-drive", client.endpoint, loop=client.loop, keys=found)
            self._driver, self._drive = driver, PanelDrive(driver, sender, self._server.say)
            driver.wait_connected(_CONNECT_S)
        client.define(CAPABILITY_WANTS)
        client.every(_WANT_EVERY_S, self._want)
        client.post(self._topics.look_for_others)

    def listen(self, timeout: float) -> None:
        """Wait for up to `timeout` [s], and serve both sides."""
        self._client.listen(timeout)
        if self._client.connected is not self._linked:
            self._linked = not self._linked
            lost = f"the hub at {self._client.endpoint} answers no more: what is shown is old"
            self._server.say("" if self._linked else lost)

    def close(self) -> None:
        """Stop the robot if a panel drives it, and disconnect all."""
        self._server.close()
        if self._drive is not None and self._driver is not None:
            self._drive.close()
            with contextlib.suppress(HubError):
                self._driver.wait_published(_LAST_WORDS_S)
            self._driver.close()

    def _follow(self) -> None:
        """Do what panels want now."""
        wishes = self._server.take_wishes()
        self._topics.follow(wishes)
        if self._drive is not None:
            self._driven = bool(wishes.panels)
            self._drive.follow(wishes.panels)
            for command in wishes.commands:
                self._drive.obey(command)
        if self._now_wanted() != self._wanted:
            self._want()

    def _now_wanted(self) -> frozenset[str]:
        return self._topics.wanted | ({Capability.NAV_MOVE.value} if self._driven else set())

    def _want(self) -> None:
        """Keep what is watched running; once nothing is, say so."""
        before, self._wanted = self._wanted, self._now_wanted()
        if self._wanted or before:
            wants = CapabilityWants(
                holder=self._client.name, capabilities=" ".join(sorted(self._wanted))
            )
            self._client.publish(CAPABILITY_WANTS, wants)

    def _described(self, body: RobotBody) -> None:
        self._server.set_parameters(parameters_of(body, drive=self._drives))
