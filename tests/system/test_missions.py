"""A mission outlives whatever dies: mapping, the daemon, the last console."""

from __future__ import annotations

import os
import signal
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest

from hub.gcm import mapping, mission, navigation
from hub.gcm.common import COMMON_RESULT
from hub.gcm.mission import MissionAction, MissionCommand
from hub.gcm.supervision import CAPABILITY_WANTS, MODULE_REPORTS, CapabilityWants
from tests.system.harness import HubProcess, Observer
from tests.waiting import until

MAPPING = """
[modules.mapping]
run = "hub.modules.mapping"
start = "on demand"
linger_s = 0.0
capabilities = ["PRO_MAP", "PRO_POINTS"]
"""
SEEN = (
    navigation.GROUND_TRUTH,
    MODULE_REPORTS,
)


class Site:
    """A hub whose mapping runs on demand, and somebody who looks on without wanting it."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.start()

    def start(self) -> None:
        self.hub = HubProcess(
            self._folder, arena="yellow", modules=("driver", "navigation"), tables=MAPPING
        )
        self.watch = Observer(self.hub.endpoint, *SEEN)
        for definition in (mapping.INTEREST_POINTS, mission.MISSION_STATE):
            self.watch.seen[definition.name] = history = type(self.watch.history)(maxlen=1000)
            self.watch.client.subscribe(
                definition,
                lambda value, how, history=history: history.append((how.measured, value)),
                last=True,
            )

    def close(self) -> None:
        self.watch.close()
        self.hub.close()

    def kill(self) -> None:
        """Kill the daemon as the system does where memory ends."""
        self.watch.close()
        os.kill(self.hub.process.pid, signal.SIGKILL)
        self.hub.close()

    def newest(self, name: str) -> object:
        history = self.watch.seen[name]
        return history[-1][1] if history else None

    @property
    def points(self) -> dict[int, mapping.InterestPoint]:
        found = self.newest(mapping.INTEREST_POINTS.name)
        return {p.number: p for p in found.points} if found else {}  # type: ignore[attr-defined]

    @property
    def state(self) -> mission.MissionState:
        found = self.newest(mission.MISSION_STATE.name)
        return found if isinstance(found, mission.MissionState) else mission.MissionState()

    @property
    def mapping_pid(self) -> int:
        reports = self.newest(MODULE_REPORTS.name)
        pids = {m.name: m.pid for m in reports.modules}  # type: ignore[attr-defined]
        return pids["mapping"]

    def order(self, action: MissionAction, name: str = "") -> str:
        command = MissionCommand(action=action, name=name, by="Ada")
        result = self.watch.client.query_response(
            mission.MISSION_COMMAND, command, COMMON_RESULT, timeout=10.0
        )
        assert result.done, result.text
        return result.text

    def mark(self, x: float) -> None:
        point = mapping.InterestPoint(
            kind=mapping.PointKind.VICTIM, x=x, y=0.5, by="Ada", thumbnail=np.ones(50, np.uint8),
            length=50,
        )  # fmt: skip
        command = mapping.PointCommand(point=point)

        def kept() -> bool:
            # Again until it is confirmed, as consoles do: mapping may begin to listen just now.
            self.watch.client.publish(mapping.POINT_COMMAND, command)
            return any(p.x == x and p.kept for p in self.points.values())

        self.watch.wait(kept, 20.0, "not kept")

    def forget(self) -> None:
        """Of what was heard so far."""
        for name in (mapping.INTEREST_POINTS.name, mission.MISSION_STATE.name):
            self.watch.seen[name].clear()

    def begin(self) -> None:
        """Have mapping run for as long as it takes to begin a mission."""
        wants = CapabilityWants(holder="observer", capabilities="PRO_MAP", lease_s=2.0)

        def there() -> object:
            self.watch.client.publish(CAPABILITY_WANTS, wants)
            return self.newest(mission.MISSION_STATE.name)

        self.watch.wait(there, 20.0, "no mapping")
        self.order(MissionAction.BEGIN, "search one")


@pytest.fixture
def site(tmp_path: Path) -> Site:
    with ExitStack() as stack:
        made = Site(tmp_path)
        stack.callback(made.close)
        yield made


def known(site: Site) -> int:
    found = site.watch.client.query_response(
        mapping.MAP_REQUEST, mapping.MapRequest(x=float("nan")), mapping.MAP, timeout=10.0
    )
    return found.length


def test_marks_and_map_outlive_mapping_and_daemon(site: Site) -> None:
    site.begin()
    site.mark(1.5)
    site.mark(2.5)
    site.watch.wait(lambda: known(site) > 200, 10.0, "nothing is mapped")
    site.watch.wait(lambda: site.state.map_age_s < 60.0, 10.0, "the map is not saved")
    before = site.points
    for again in range(2):
        pid = site.mapping_pid
        os.kill(pid, signal.SIGKILL)
        # Nobody wants mapping but the mission.
        site.watch.wait(lambda pid=pid: site.mapping_pid not in (0, pid), 20.0, "no new process")
        site.forget()
        site.watch.wait(lambda: site.points, 20.0, "the marks do not come back")
        assert sorted(site.points) == sorted(before)
        assert known(site) > 200
        site.mark(3.5 + again)
        before = site.points
    site.kill()
    site.start()
    site.watch.wait(lambda: site.points, 20.0, "the marks do not come back")
    assert site.points.keys() == before.keys() == {1, 2, 3, 4}
    assert all(point.kept for point in site.points.values())
    assert (site.state.name, site.state.running, site.state.sheet) == ("search one", 1, 1)
    assert known(site) > 200
    site.order(MissionAction.END)
    # Nobody wants mapping any more.
    until(
        lambda: site.mapping_pid == 0, 20.0, "mapping goes on",
        meanwhile=lambda: site.watch.client.listen(0.05),
    )  # fmt: skip
