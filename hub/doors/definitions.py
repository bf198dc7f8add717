"""The messages that a hub has, as a door asks for them."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import Final

from hub.errors import HubError
from hub.ipc.client import Client
from hub.ipc.wire.control import Define

_logger = logging.getLogger(__name__)

MOST_OTHERS: Final = 200
"""Most messages of a hub that are not of GCM and that a door offers."""
_ANSWER_S = 2.0


def definitions_of(client: Client) -> Sequence[Define]:
    """All messages that are defined at the hub; none while it does not answer."""
    if not client.connected:
        return ()
    try:
        return client.directory.listing(_ANSWER_S).definitions
    except HubError as error:
        _logger.warning("the hub did not say which messages it has: %s", error)
        return ()
