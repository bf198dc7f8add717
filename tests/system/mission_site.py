"""A robot whose hub, mapping and consoles are killed while somebody marks what is found."""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hub.gcm import mapping, mission, navigation
from hub.gcm.common import COMMON_RESULT, REQUEST_DATA, RequestData
from hub.gcm.mission import MissionAction, MissionCommand
from hub.gcm.supervision import CAPABILITY_WANTS, MODULE_REPORTS, CapabilityWants
from tests.support import warm_start
from tests.system.harness import HubProcess, Observer

_STARTS = 4
_CONSOLE = "tests.misbehaving.marking_console"

MAPPING = """
[modules.mapping]
run = "hub.modules.mapping"
start = "on demand"
linger_s = 0.0
restart_limit = 1000
capabilities = ["PRO_MAP", "PRO_POINTS"]
"""
SEEN = (
    navigation.GROUND_TRUTH,
    MODULE_REPORTS,
)


class Site:
    """A hub whose mapping runs on demand, and somebody who looks on without wanting it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.start()

    def start(self) -> None:
        for attempt in range(1, _STARTS + 1):
            with contextlib.suppress(AssertionError):  # a machine that is busy with other tests
                self.hub = HubProcess(
                    self.folder, arena="yellow", modules=("driver", "navigation"), tables=MAPPING
                )
                break
            assert attempt < _STARTS, "no hub starts"
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

    def ask(self) -> None:
        """Ask for the mission and its points until they come."""
        names = (mapping.INTEREST_POINTS.name, mission.MISSION_STATE.name)

        def come() -> object:
            for name in names:
                self.watch.client.publish(REQUEST_DATA, RequestData(message=name))
            return self.points and self.newest(mission.MISSION_STATE.name)

        self.watch.wait(come, 20.0, "the marks do not come back")

    def begin(self) -> None:
        """Have mapping run for as long as it takes to begin a mission."""
        wants = CapabilityWants(holder="observer", capabilities="PRO_MAP", lease_s=2.0)

        def there() -> object:
            self.watch.client.publish(CAPABILITY_WANTS, wants)
            return self.newest(mission.MISSION_STATE.name)

        self.watch.wait(there, 20.0, "no mapping")
        self.order(MissionAction.BEGIN, "search one")


class Marker:
    """The console that marks, as a process that can be killed."""

    def __init__(self, site: Site, first: int) -> None:
        self._lines = site.folder / f"confirmed-{first}.jsonl"
        with self._lines.open("wb") as out:
            self.process = warm_start.start(
                [sys.executable, "-m", _CONSOLE, site.hub.endpoint, str(first)],
                environment=os.environ,
                stdout=out.fileno(),
            )

    def wait_for_more(self, site: Site) -> None:
        """Until the robot has confirmed something more."""
        size = self._lines.stat().st_size
        site.watch.wait(
            lambda: self._lines.stat().st_size > size, 30.0, "nothing is confirmed any more"
        )

    def kill(self) -> dict[int, tuple[float, str]]:
        """Kill it; what it was told to be kept, by number."""
        self.process.kill()
        self.process.wait()
        found: dict[int, tuple[float, str]] = {}
        for line in self._lines.read_text().splitlines(keepends=True):
            if line.endswith("\n"):
                number, x, note = json.loads(line)
                found[number] = max(found.get(number, (x, "")), (x, note))
        return found


def killed_often(site: Site, victims: Sequence[str], seed: int) -> dict[str, int]:
    """Kill mapping, the console and the daemon at random moments while marks are set.

    Returns:
        How often each was killed, how much was confirmed, and how much of it was lost.
    """
    chance = random.Random(seed)
    site.begin()
    confirmed: dict[int, tuple[float, str]] = {}
    counts = {"mapping": 0, "console": 0, "daemon": 0, "confirmed": 0, "lost": 0}
    marker = Marker(site, 1)
    for kill, whom in enumerate(victims, 1):
        marker.wait_for_more(site)
        until_s = time.monotonic() + chance.uniform(0.0, 0.6)
        while time.monotonic() < until_s:
            site.watch.client.listen(0.05)
        counts[whom] += 1
        if whom == "mapping":
            pid = site.mapping_pid
            if pid:
                os.kill(pid, signal.SIGKILL)
        if whom == "daemon":
            site.kill()
        if whom != "mapping":
            confirmed = _merged(confirmed, marker.kill())
        if whom == "daemon":
            site.start()
        if whom != "mapping":
            marker = Marker(site, 1000 * kill)
    marker.wait_for_more(site)
    confirmed = _merged(confirmed, marker.kill())
    site.forget()
    site.watch.wait(lambda: len(site.points) >= len(confirmed) > 0, 30.0, "marks are lost")
    now = site.points
    counts["confirmed"] = len(confirmed)
    counts["lost"] = sum(
        number not in now or now[number].x != x or now[number].note < note
        for number, (x, note) in confirmed.items()
    )
    return counts


def _merged(
    known: dict[int, tuple[float, str]], heard: dict[int, tuple[float, str]]
) -> dict[int, tuple[float, str]]:
    """What was confirmed by either; the same number never is another mark."""
    for number, (x, note) in heard.items():
        assert known.get(number, (x, ""))[0] == x, "a number was given twice"
        known[number] = max(known.get(number, (x, "")), (x, note))
    return known
