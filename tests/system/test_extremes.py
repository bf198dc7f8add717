"""Extreme messages of all definitions at real modules: they go on, and log no fault."""

from __future__ import annotations

import contextlib
import itertools
import os
from collections.abc import Callable
from contextlib import closing
from random import Random
from typing import Any

import pytest

from hub.errors import NotAllowedError
from hub.gcm.catalog import MESSAGES
from hub.gcm.common import COMMON_COMMAND
from hub.gcm.supervision import MODULE_COMMAND, MODULE_INFO
from hub.ipc.client import Client
from tests.support import extremes
from tests.support.waiting import until
from tests.system.harness import HubProcess

EACH = int(os.environ.get("RUNE_EXTREMES_SENT", "1000"))
_ENDING = {COMMON_COMMAND.name, MODULE_COMMAND.name}
"""Messages that rightly end modules."""
_AT_ONCE = 50


@pytest.mark.soak
@pytest.mark.timeout(1700)
def test_modules_go_on_whatever_comes(start_hub: Callable[..., HubProcess]) -> None:
    modules = ("driver", "navigation", "vision", "mapping", "autonomy")
    hub = start_hub(modules=modules, arena="yellow")
    errors: dict[str, int] = {}
    with closing(Client("extremes", hub.endpoint)) as client:

        def heard(info: Any, how: Any) -> None:
            if how.publisher != client.number:
                errors[info.name] = info.errors

        client.subscribe(MODULE_INFO, heard)
        client.wait_connected(10.0)
        for definition in MESSAGES:
            if definition.name in _ENDING:
                continue
            client.define(definition)
            client.wait_defined(10.0)
            payloads = extremes.payloads(definition, Random(11))
            with contextlib.suppress(NotAllowedError):  # one module's own
                for number, payload in enumerate(itertools.islice(payloads, EACH)):
                    client.publish_payload(definition, payload)
                    if number % _AT_ONCE == 0:
                        client.listen(0.01)
            client.listen(0.1)
        errors.clear()
        until(lambda: errors.keys() >= {*modules}, 20.0, meanwhile=lambda: client.listen(0.05))
    assert {name: errors[name] for name in modules} == dict.fromkeys(modules, 0)
    assert "Traceback" not in hub.log.read_text()
