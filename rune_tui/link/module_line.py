"""The console as a module of a robot's hub: its announcement, and common commands to it.

| common command | what the console does |
| --- | --- |
| STATUS, CAPABILITIES | announces itself |
| LOG_LEVEL | sets the level of its log |
| STOP, RESTART, by its name | reports that to the operator, who alone ends it |
| START, and STOP or RESTART of all modules | nothing |

With a key to observe, operate or supervise, a console announces nothing: central would refuse it.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable

from hub.bucket import Bucket
from hub.gcm.capability import Capability
from hub.gcm.common import COMMON_COMMAND, REQUEST_DATA, CommonCommand, RequestData
from hub.gcm.common import CommonCommandKind as Kind
from hub.gcm.supervision import MODULE_INFO, ModuleInfo
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.ipc.security.client_keys import ClientKeys
from hub.ipc.security.publish_rights import may_publish
from hub.nonblocking_logging import LEVELS

_MOST_PER_S = 5.0
"""Most announcements, however often a hub asks for them [1/s]."""


def begin_as_module(client: Client, keys: ClientKeys | None, say: Callable[[str], None]) -> None:
    """Have a console announce itself, if its key allows that; None: it needs no key."""
    if keys is None or may_publish(keys.role, MODULE_INFO.name, MODULE_INFO.plane.value):
        ModuleLine(client, say)


class ModuleLine:
    """Used by the link's thread alone."""

    def __init__(self, client: Client, say: Callable[[str], None]) -> None:
        """Begin.

        Args:
            client: The link's.
            say: Gets what the operator must read, in words.
        """
        self._client, self._say = client, say
        self._answers = Bucket(_MOST_PER_S, _MOST_PER_S)
        client.define(MODULE_INFO)
        client.subscribe(COMMON_COMMAND, self._obey)
        client.subscribe(REQUEST_DATA, self._requested)
        client.every(1.0 / MODULE_INFO.rate_hz, self._announce)

    def _announce(self) -> None:
        if self._client.connected and self._answers.take(1.0, self._client.loop.clock()):
            info = ModuleInfo(
                name=self._client.name,
                pid=os.getpid(),
                state="running",
                capabilities=Capability.CON_REAL,
            )
            self._client.publish(MODULE_INFO, info)

    def _requested(self, request: RequestData, _reception: MessageInfo) -> None:
        if request.message == MODULE_INFO.name:
            self._announce()

    def _obey(self, command: CommonCommand, _reception: MessageInfo) -> None:
        if command.module not in ("", self._client.name):
            return
        if command.command in (Kind.STATUS, Kind.CAPABILITIES):
            self._announce()
        elif command.command is Kind.LOG_LEVEL and command.argument in LEVELS:
            logging.getLogger().setLevel(command.argument.upper())
        elif command.command in (Kind.STOP, Kind.RESTART) and command.module:
            self._say("the hub asks this console to end; only its operator ends it")
