"""A subscriber is stopped (SIGSTOP) amid pictures: nobody else notices, every loss is known."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable

import pytest

from tests.soak.rig import AT, MISSED, SENT, SEQUENCE, ModuleProcess, Rig, latency_ms
from tests.support.waiting import until

STUCK_S = float(os.environ.get("RUNE_SOAK_STUCK_S", "60"))
GROWTH_MB = 5.0
SECOND_PICTURE_MS = 250.0
NOISE_MS = 2.5
"""Below this a 99th percentile is the scheduler's of a busy machine."""
_PICTURES_HZ = 100.0
_BEFORE_S = 10.0


def _wait(seconds: float, meanwhile: Callable[[], object]) -> None:
    end = time.monotonic() + seconds

    def look() -> None:
        meanwhile()
        time.sleep(0.2)

    until(lambda: time.monotonic() > end, seconds + 30.0, meanwhile=look)


def _counted(subscriber: ModuleProcess, name: str) -> dict[str, int]:
    """What was published in the time the subscriber saw, what it received, and what it counted."""
    rows = subscriber.received(name)
    return {
        "published": int(rows[-1, SEQUENCE] - rows[0, SEQUENCE]) + 1,
        "received": len(rows),
        "missed": int(rows[1:, MISSED].sum()),
    }


def _check(
    make_rig: Callable[..., Rig], tell: Callable[..., None], stuck_s: float, transport: str
) -> None:
    rig = make_rig(transport=transport)
    publisher = rig.module(
        "publisher", publish=[("S_Picture", _PICTURES_HZ, 57_600), ("S_Event", 200.0, 200)]
    )
    names = ["S_Picture", "S_Event"]
    healthy, stuck = (rig.module(name, subscribe=names) for name in ("healthy", "stuck"))
    for subscriber in (healthy, stuck):
        rig.wait_flowing(subscriber, *names)
    started_ns = time.monotonic_ns()
    _wait(min(_BEFORE_S, 3 * stuck_s), lambda: None)

    memory = [rig.central.vitals().memory_mb]
    stopped_ns = time.monotonic_ns()
    os.kill(stuck.pid, signal.SIGSTOP)
    _wait(stuck_s, lambda: memory.append(rig.central.vitals().memory_mb))
    resumed_ns = time.monotonic_ns()
    os.kill(stuck.pid, signal.SIGCONT)
    until(
        lambda: (stuck.received("S_Picture")[:, SENT] > resumed_ns + 500_000_000).sum() > 10,
        20.0,
        "pictures do not come again",
    )
    rig.wait_drained(publisher, healthy, stuck)
    summaries = {module.plan.name: module.finish() for module in (healthy, stuck)}

    latencies = {
        name: {
            "before": latency_ms(healthy.received(name), started_ns, stopped_ns),
            "during": latency_ms(healthy.received(name), stopped_ns, resumed_ns),
        }
        for name in names
    }
    pictures = stuck.received("S_Picture")
    resumed = pictures[pictures[:, AT] > resumed_ns]
    ages_ms = (resumed[:, AT] - resumed[:, SENT]) / 1e6
    counted = {name: _counted(stuck, name) for name in names}
    tell(
        stuck_s=stuck_s,
        transport=transport,
        latencies=latencies,
        central_mb=[memory[0], max(memory)],
        picture_ages_after_resume_ms=[round(float(age), 1) for age in ages_ms[:4]],
        stale_pictures_after_resume=int((ages_ms > SECOND_PICTURE_MS).sum()),
        stale_until_ms=round(
            float(resumed[ages_ms > SECOND_PICTURE_MS, AT].max(initial=resumed_ns) - resumed_ns)
            / 1e6,
            1,
        ),
        counted=counted,
        healthy_missed=summaries["healthy"].get("missed"),
        complaints=summaries["stuck"]["complaints"],
        bars={
            "no fault in a module": not any(s["faults"] for s in summaries.values()),
            "the healthy one loses no event": summaries["healthy"]["missed"]["S_Event"] == 0,
            "central grows less than 5 MB": max(memory) - memory[0] < GROWTH_MB,
            "the healthy one's p99 at most doubles": all(
                figures["during"]["typical_p99_ms"]
                <= max(2.0 * figures["before"]["typical_p99_ms"], NOISE_MS)
                for figures in latencies.values()
            ),
            "the second picture is fresh": bool(ages_ms[1] < SECOND_PICTURE_MS),
            "every loss is counted": all(
                each["missed"] == each["published"] - each["received"] for each in counted.values()
            ),
        },
    )


@pytest.mark.soak
@pytest.mark.timeout(400)
@pytest.mark.parametrize("transport", ["tcp", "ipc"])
@pytest.mark.parametrize("stuck_s", [1.0, 5.0, STUCK_S])
def test_stuck_subscriber_costs_nobody_else_anything(
    make_rig: Callable[..., Rig], tell: Callable[..., None], stuck_s: float, transport: str
) -> None:
    _check(make_rig, tell, stuck_s, transport)


@pytest.mark.soak
@pytest.mark.timeout(120)
@pytest.mark.parametrize("pause_s", [1.0, 3.0])
@pytest.mark.parametrize("transport", ["tcp", "ipc"])
def test_module_that_is_busy_for_seconds_again_and_again_lives(
    make_rig: Callable[..., Rig], tell: Callable[..., None], pause_s: float, transport: str
) -> None:
    """Its queues are full when its connections end, and it reads on."""
    rig = make_rig(transport=transport)
    publisher = rig.module(
        "publisher", publish=[("S_Event", 2000.0, 1000), ("S_Picture", 60.0, 57_600)]
    )
    names = ["S_Event", "S_Picture"]
    busy = rig.module("busy", subscribe=names, pause_s=pause_s)
    healthy = rig.module("healthy", subscribe=names)
    for subscriber in (busy, healthy):
        rig.wait_flowing(subscriber, *names)
    memory = [rig.central.vitals().memory_mb]
    _wait(8.0 * pause_s, lambda: memory.append(rig.central.vitals().memory_mb))
    alive = busy.process.poll() is None
    rig.wait_drained(publisher, healthy)
    summary = busy.finish() if alive else {}
    counted = {name: _counted(busy, name) for name in names}
    tell(
        pause_s=pause_s,
        transport=transport,
        counted=counted,
        central_mb=[memory[0], max(memory)],
        complaints=summary.get("complaints"),
        log=busy.log.read_text()[-200:],
        bars={
            "it lives": alive,
            "no fault in it": not summary.get("faults"),
            "the healthy one loses no event": healthy.finish()["missed"]["S_Event"] == 0,
            "every loss is counted": all(
                each["missed"] == each["published"] - each["received"] for each in counted.values()
            ),
        },
    )
