"""The other end of the link sends anything, at any rate: the hub lives, and drives nothing."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import psutil
import pytest

from hub.gcm.autopilot import AUTOPILOT_STATE
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.geometry import Twist
from hub.gcm.navigation import ROBOT_STATE
from tests.misbehaving.hostile_vehicle import ATTACKS, HostileVehicle
from tests.support.mavlink_relay import moves
from tests.system.autopilot_site import Operator, vehicle_tables
from tests.system.harness import HubProcess, Observer

QUICK_S, SOAK_S = 0.3, 20.0
QUICK = ("numbers", "mutated", "boots", "texts", "")
"""The attacks in `make test`; with none, the vehicle does not read."""
GROWN_MB = 20.0
CPU = 0.5
"""Most of a core that the driver takes while the link is flooded."""


class Site:
    """A hub whose vehicle is hostile, and an operator whose stick is deflected all the time."""

    def __init__(self, folder: Path) -> None:
        self.vehicle = HostileVehicle()
        tables = vehicle_tables("rover", self.vehicle.port)
        modules = ("driver", "navigation")
        self.hub = HubProcess(folder, kind="mavlink", modules=modules, tables=tables)
        definitions = (AUTOPILOT_STATE, ROBOT_STATE, DIAGNOSTICS)
        self.observer = Observer(self.hub.endpoint, *definitions)
        self.operator = Operator(self.hub.endpoint, "operator")
        self.operator.twist = Twist.planar(0.5, 0.2)
        self.driver = psutil.Process(self.hub.pids["driver"])

    def close(self) -> None:
        self.operator.client.close()
        self.observer.close()
        self.hub.close()
        self.vehicle.close()

    def wait(self, condition: Callable[[], object], why: str, seconds: float = 15.0) -> None:
        def both() -> bool:
            self.operator.client.listen(0.0)
            return bool(condition())

        self.observer.wait(both, seconds, lambda: f"{why}\n{self.hub.log.read_text()[-3000:]}")

    def reports_again(self) -> None:
        """The driver lives, and says so."""
        count = len(self.observer.seen[ROBOT_STATE.name])
        self.wait(lambda: len(self.observer.seen[ROBOT_STATE.name]) > count, "no report comes")

    def go_on(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        self.wait(lambda: time.monotonic() >= end, "time stands still", seconds + 15.0)

    def harm(self) -> list[str]:
        """What should not have happened."""
        found = [f"the hub sent {each}" for _, each in self.vehicle.frames if moves(each)]
        found += [
            f"the hub ordered {each}"
            for _, each in self.vehicle.frames
            if each.name in ("PARAM_SET", "SET_MODE")
            or (each.name == "COMMAND_LONG" and each["command"] in (176, 400))
        ]
        log = self.hub.log.read_text()
        found += [line for line in log.splitlines() if "Traceback" in line or "ERROR" in line]
        found += [f"{each!r} in the log" for each in "\x1b\x07" if each in log]
        return found if self.driver.is_running() else [*found, "the driver died"]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with closing(Site(tmp_path_factory.mktemp("hub"))) as site:
        site.wait(lambda: site.vehicle.frames, "the hub does not come")
        yield site


@pytest.mark.parametrize(
    ("attack", "seconds"),
    [
        *((attack, QUICK_S) for attack in QUICK),
        *(pytest.param(attack, SOAK_S, marks=pytest.mark.soak) for attack in [*ATTACKS, ""]),
    ],
)
def test_it_lives_and_drives_nothing(
    site: Site, attack: str, seconds: float, tell: Callable[..., None]
) -> None:
    memory, sent = site.driver.memory_info().rss, site.vehicle.sent
    begun, cpu = time.monotonic(), sum(site.driver.cpu_times()[:2])
    site.vehicle.attack, site.vehicle.reads = attack, bool(attack)
    site.go_on(seconds)
    took = sum(site.driver.cpu_times()[:2]) - cpu
    share = took / (time.monotonic() - begun)
    grown = (site.driver.memory_info().rss - memory) / 1e6
    rate = (site.vehicle.sent - sent) / (time.monotonic() - begun) / 1e6
    site.vehicle.attack, site.vehicle.reads = "", True
    site.reports_again()
    assert site.harm() == []
    if seconds == SOAK_S:
        figures = {"cpu": share, "grown_mb": grown, "mb_per_s": rate}
        bars = {"cpu": share < CPU, "memory": grown < GROWN_MB}
        tell(**{name: round(value, 3) for name, value in figures.items()}, bars=bars)
