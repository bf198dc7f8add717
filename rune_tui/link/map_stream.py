"""Requests a robot's map while the layout shows it; used by the link's thread."""

from __future__ import annotations

import math
from collections.abc import Callable

from hub.gcm.capability import Capability
from hub.gcm.mapping import MAP, MAP_REQUEST, Map, MapRequest
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from rune_tui.layout.spec import RobotSpec
from rune_tui.link.requests import Requester


class MapStream:
    """Requests the whole map at the layout's rate."""

    def __init__(
        self,
        client: Client,
        take: Callable[[Map, MessageInfo], int],
        clock: Callable[[], float],
    ) -> None:
        """Ask for nothing yet.

        Args:
            client: The link's.
            take: Gets each map.
            clock: The time [s].
        """
        self._wanted = False
        self._requests = Requester(
            client,
            MAP_REQUEST,
            MAP,
            ask=lambda: MapRequest(x=math.nan) if self._wanted else None,
            take=take,
            fail=lambda _: None,
            clock=clock,
        )
        self.step = self._requests.step

    def follow(self, spec: RobotSpec) -> None:
        """Set the layout's maps."""
        self._wanted = MAP.name in spec.messages
        for capability in spec.capabilities:
            if capability.name == Capability.PRO_MAP:
                self._requests.follow(capability.interval_s)
