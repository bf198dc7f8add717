"""No module's handler fails at a message that passes the bounds, whatever it holds."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from hub.gcm.common import COMMON_COMMAND
from hub.gcm.navigation import STOP
from hub.ipc import roles
from hub.modules.autonomy.__main__ import Autonomy
from hub.modules.driver.__main__ import build as build_driver
from hub.modules.mapping.__main__ import Mapping
from hub.modules.navigation.__main__ import Navigation
from hub.modules.vision.__main__ import Vision
from hub.robomon.control_service import ControlService
from hub.robomon.policy import ModulePolicy
from hub.robomon.reporting import Reporting
from tests.hub.modules.extremes_bus import ExtremesBus
from tests.support.bodies import BODIES, robot_of

EACH = int(os.environ.get("RUNE_EXTREMES", "30"))


def control_desk(bus: Any, _: Any) -> None:
    def peer(number: int) -> Any:
        if number not in (2, 3):
            return None
        principal = SimpleNamespace(role=roles.Role.SUPERVISE)
        return SimpleNamespace(publisher=number, name=f"console-{number}", principal=principal)

    ControlService(bus, peer)


def reporting(bus: Any, robot: Any) -> None:
    supervisor = SimpleNamespace(policy=ModulePolicy(()), step=lambda: None)
    outputs = SimpleNamespace(lines=lambda *_: None, remembered=dict)
    Reporting(bus, supervisor, outputs, robot.body)  # type: ignore[arg-type]


MODULES: dict[str, Callable[[Any, Any], Any]] = {
    "driver": build_driver,
    "navigation": Navigation,
    "mapping": Mapping,
    "autonomy": Autonomy,
    "vision": Vision,
    "control": control_desk,
    "reporting": reporting,
}


OF_BODIES = "driver", "navigation", "mapping", "vision"
"""Modules that do something else for another body."""


@pytest.fixture
def steps(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A clock that makes steps, and no files of a user's own."""
    ticks = itertools.count(1000)
    monkeypatch.setattr(time, "monotonic", lambda: next(ticks) * 0.01)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))


@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")
@pytest.mark.usefixtures("steps")
@pytest.mark.timeout(3600 if EACH > 100 else 300)
@pytest.mark.parametrize(
    ("module", "body"),
    [
        *((module, "magellan") for module in MODULES),
        *itertools.product(OF_BODIES, [name for name in BODIES if name != "magellan"]),
    ],
)
def test_no_handler_fails_and_nothing_is_said_that_is_out_of_range(module: str, body: str) -> None:
    robot = robot_of(body)
    bus = ExtremesBus(time.monotonic, Random(7))
    MODULES[module](bus, robot)
    through = {}
    for name in sorted(bus.handlers):
        if name != COMMON_COMMAND.name:
            through[name] = bus.feed(name, EACH)
    assert through.get(STOP.name, EACH) == EACH
    assert sum(through.values()) > 0
    if EACH > 100:
        print(module, through, dict(bus.published))  # noqa: T201 - what `make soak` reports
