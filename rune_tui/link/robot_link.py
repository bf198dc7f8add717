"""The connection to one robot's hub: a thread of its own, newest values in, messages out.

Nobody is called from here: the console reads `state` when it wants to, and hands in what to send.
"""

from __future__ import annotations

import dataclasses
import logging
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from hub.errors import CodecError, HubError, NoHandlerError, QueryError
from hub.gcm import navigation, rle, vision
from hub.gcm.capability import Capability
from hub.gcm.supervision import CAPABILITY_WANTS, LEASE_S, CapabilityWants
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.keys import read_client_keys
from hub.ipc.reception import Reception
from hub.ipc.security import Action, may
from rune_tui.layout.spec import RobotSpec
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState

_logger = logging.getLogger(__name__)

T = TypeVar("T")

_LISTEN_S = 0.2
_REQUEST_CHECK_S = 0.01
_REQUEST_TIMEOUT_S = 1.0
_RETRY_S = 0.25
_WANT_S = LEASE_S / 3
"""Pause after a request that failed [s]."""


class RobotLink:
    """A thread that keeps a `RobotState` up to date; it mends the connection by itself."""

    def __init__(
        self,
        spec: RobotSpec,
        hub: str = "",
        *,
        keys: Path | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare the connection.

        Args:
            spec: The robot.
            hub: Endpoint instead of the one in the layout.
            keys: File of the operator's key, for a hub on another machine.
            clock: Monotonic time [s].

        Raises:
            EndpointError: The endpoint is not one, or on another machine and there are no keys.
            KeyFileError: The keys cannot be used.
        """
        self._clock = clock
        wanted = {capability.name: capability for capability in spec.capabilities}
        self._wanted = " ".join(sorted(wanted))
        self._interval = (
            wanted[Capability.VIS_VID].interval_s if Capability.VIS_VID in wanted else 0
        )
        self._pictures_wanted = Capability.VIS_VID in wanted
        self._picture_size: tuple[int, int] | None = None
        self._shown = 0
        self._asked_number = 0
        self._in_flight = False
        self._ask_at = 0.0
        self._numbers = 0
        self._stopping = threading.Event()
        own_keys = read_client_keys(keys) if keys else None
        self._client = Client(
            f"rune-{os.getpid()}-{spec.name}", hub or spec.hub, clock=clock, keys=own_keys
        )
        link = LinkState(
            phase=LinkPhase.CONNECTING,
            since=clock(),
            endpoint=self._client.endpoint,
            may_command=own_keys is None or may(own_keys.role, Action.PUBLISH_COMMAND),
        )
        self._state = RobotState(name=spec.name, link=link)
        self._subscribe(set(wanted))
        self._thread = threading.Thread(target=self._run, name=f"link-{spec.name}", daemon=True)

    @property
    def state(self) -> RobotState:
        """What is known of the robot now; any thread may read it."""
        return self._state

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End the thread; what was sent before still goes out."""
        self._stopping.set()
        self._client.post(lambda: None)
        self._thread.join()

    def send(self, definition: MessageDefinition[T], value: T) -> None:
        """Publish a command to the robot, if the operator's key allows that.

        It is lost while there is no connection, so that nothing old arrives.
        """
        if self._state.link.may_command:
            measured = self._clock()
            self._client.post(lambda: self._client.publish(definition, value, measured=measured))

    def want_pictures(self, size: tuple[int, int] | None) -> None:
        """Ask for pictures of this width and height [pixels]; None: for none."""
        self._picture_size = size

    def shown(self, number: int) -> None:
        """The picture of this number is on the screen; only now the next one is asked for."""
        self._shown = number

    def _subscribe(self, wanted: set[str]) -> None:
        client = self._client
        if Capability.NAV_STATE in wanted:
            client.subscribe(navigation.ROBOT_STATE, self._store("navigation"))
        if wanted & {Capability.VIS_PTZ, Capability.VIS_VID}:
            client.subscribe(vision.CAMERA_STATE, self._store("camera"))
        if self._state.link.may_command:
            # Defined before they are used, so that a stop is on its way as soon as it is wanted.
            client.define(navigation.VELOCITY_COMMAND, navigation.STOP, vision.CAMERA_COMMAND)
            client.define(CAPABILITY_WANTS)
            client.every(_WANT_S, self._want)
        if self._pictures_wanted:
            client.every(_REQUEST_CHECK_S, self._ask_for_picture)

    def _want(self) -> None:
        """Have the robot run what the layout wants; it holds for a few seconds only."""
        if self._client.connected and self._wanted:
            wants = CapabilityWants(holder=self._client.name, capabilities=self._wanted)
            self._client.publish(CAPABILITY_WANTS, wants)

    def _store(self, field: str) -> Callable[[Any, Reception], None]:
        def store(value: object, reception: Reception) -> None:
            self._state = self._state.with_(**{field: self._received(value, reception)})

        return store

    def _received(self, value: T, reception: Reception) -> Received[T]:
        self._numbers += 1
        return Received(value=value, measured=reception.measured, number=self._numbers)

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self._client.listen(_LISTEN_S)
            except Exception:  # one bad message must not end the link
                _logger.exception("the link to %s goes on after a fault", self._state.name)
            self._note_phase()
        try:
            self._client.listen(0.0)
        except HubError as error:
            _logger.warning("the last messages to %s were not sent: %s", self._state.name, error)
        self._client.close()

    def _note_phase(self) -> None:
        link = self._state.link
        if self._client.connected:
            # What a failed request said holds until one succeeds, what a lost link said ends here.
            known = link.detail if link.phase is LinkPhase.CONNECTED else ""
            phase, detail = LinkPhase.CONNECTED, known
            if link.phase is not LinkPhase.CONNECTED and link.may_command:
                self._want()
        elif link.phase is LinkPhase.CONNECTING:
            phase, detail = LinkPhase.CONNECTING, str(self._client.refusal or "")
        else:
            closed = f"closed by {self._client.closed_by}" if self._client.closed_by else ""
            phase, detail = LinkPhase.LOST, closed or str(self._client.refusal or "")
        self._set_link(phase, detail)

    def _set_link(self, phase: LinkPhase, detail: str) -> None:
        link = self._state.link
        if (phase, detail) != (link.phase, link.detail):
            since = link.since if phase is link.phase else self._clock()
            changed = dataclasses.replace(link, phase=phase, since=since, detail=detail)
            self._state = self._state.with_(link=changed)

    def _ask_for_picture(self) -> None:
        size, now = self._picture_size, self._clock()
        handled = not self._in_flight and self._shown >= self._asked_number
        if size is None or not handled or now < self._ask_at or not self._client.connected:
            return
        self._in_flight = True
        self._ask_at = now + self._interval
        self._client.query_notify(
            vision.IMAGE_REQUEST,
            vision.ImageRequest(width_px=size[0], height_px=size[1]),
            vision.IMAGE,
            timeout=_REQUEST_TIMEOUT_S,
            answered=self._take_picture,
            failed=self._no_picture,
        )

    def _take_picture(self, image: vision.Image, reception: Reception) -> None:
        self._in_flight = False
        try:
            pixels = rle.decode(image.data, image.height_px, image.width_px, image.channels)
        except CodecError as error:
            self._no_picture(QueryError(str(error)))
            return
        if image.channels == 1:
            pixels = pixels.repeat(3, axis=2)
        received = self._received(Picture(pixels=pixels[:, :, :3], camera=image.camera), reception)
        self._asked_number = received.number
        self._state = self._state.with_(picture=received)
        self._set_link(self._state.link.phase, "")

    def _no_picture(self, error: QueryError) -> None:
        self._in_flight = False
        self._ask_at = self._clock() + _RETRY_S
        detail = "the robot sends no pictures" if isinstance(error, NoHandlerError) else str(error)
        self._set_link(self._state.link.phase, detail)
