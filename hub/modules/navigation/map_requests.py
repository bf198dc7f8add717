"""Asks mapping for the part of the map that the task needs; one question at a time."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Final

from hub.errors import CodecError, HubError
from hub.gcm import mapping
from hub.grids.grid import grid_of
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.modules.navigation.path_follower import PathFollower

_logger = logging.getLogger(__name__)

_PERIOD_S: Final = 1.5
_TIMEOUT_S: Final = 1.0


class MapRequests:
    """The questions of one path follower."""

    def __init__(self, client: Client, pilot: PathFollower, clock: Callable[[], float]) -> None:
        """Begin to ask again and again.

        Args:
            client: Navigation's connection.
            pilot: Says which part it needs, and takes the map.
            clock: The monotonic clock [s].
        """
        self._client, self._pilot, self._clock = client, pilot, clock
        self._asking = False
        client.every(_PERIOD_S, self.ask)

    def ask(self) -> None:
        """Ask now, unless nothing is needed or an answer is on its way."""
        window = self._pilot.window
        if self._asking or window is None:
            return
        self._asking = True
        self._client.query_notify(
            mapping.MAP_REQUEST,
            window,
            mapping.MAP,
            timeout=_TIMEOUT_S,
            answered=self._mapped,
            failed=self._no_map,
        )

    def _mapped(self, message: mapping.Map, _reception: MessageInfo) -> None:
        self._asking = False
        try:
            grid = grid_of(message)
        except CodecError as error:
            _logger.warning("cannot read the map: %s", error)
            return
        self._pilot.mapped(grid, self._clock())

    def _no_map(self, error: HubError) -> None:
        self._asking = False
        _logger.debug("goes on without a map: %s", error)
