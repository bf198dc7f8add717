"""Half an hour of ordinary work: nothing is lost that was not counted, and memory stays flat."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import pytest

from tests.soak.rig import ModuleProcess, Rig, Vitals, latency_ms
from tests.support.waiting import until

MINUTES = float(os.environ.get("RUNE_SOAK_MINUTES", "30"))
GROWTH_MB = 2.0
_SETTLED_S = 60.0
_NAMES = ("S_Event", "S_Picture")


def _work(make_rig: Callable[..., Rig], tell: Callable[..., None], seconds: float) -> None:
    rig = make_rig(transport="ipc")
    publisher = rig.module("publisher", publish=[("S_Event", 5000.0, 24)])
    camera = rig.module("camera", publish=[("S_Picture", 30.0, 57_600)])
    subscriber = rig.module("subscriber", subscribe=list(_NAMES), every=50)
    rig.wait_flowing(subscriber, *_NAMES)
    started = time.monotonic()
    processes = {
        "central": rig.central.pid,
        **{name: module.pid for name, module in rig.modules.items()},
    }
    seen: list[dict[str, Vitals]] = []

    def look() -> None:
        if time.monotonic() - started > seconds / 5.0:
            seen.append({name: Vitals.of(pid) for name, pid in processes.items()})
        time.sleep(min(1.0, seconds / 20.0))

    until(lambda: time.monotonic() - started > seconds, seconds + 60.0, meanwhile=look)
    rig.wait_drained(publisher)
    rig.wait_drained(camera, subscriber)
    summary = subscriber.finish()
    counted = {
        name: {
            "published": source.summary["published"][name],
            "first": summary["first"][name],
            "last": summary["last"][name],
            "received": summary["received"][name],
            "missed": summary["missed"][name],
            "not_sent": source.summary["complaints"].get("not sent", 0),
        }
        for name, source in _sources(publisher, camera)
    }
    growth = {
        name: round(seen[-1][name].memory_mb - seen[0][name].memory_mb, 2) for name in processes
    }
    tell(
        seconds=seconds,
        counted=counted,
        latencies={name: latency_ms(subscriber.received(name)) for name in _NAMES},
        memory_mb={name: seen[-1][name].memory_mb for name in processes},
        growth_mb=growth,
        held={
            name: [(look[name].descriptors, look[name].threads) for look in (seen[0], seen[-1])]
            for name in processes
        },
        dropped=rig.dropped(),
        bars={
            "no fault in a module": not summary["faults"],
            "nothing lost that was not counted": all(
                each["last"] == each["published"]
                # What was not sent before the first that came counts neither way.
                and 0
                <= each["last"] - each["first"] + 1 - each["received"] - each["missed"]
                <= each["not_sent"]
                for each in counted.values()
            ),
            # What is made when first needed may come after the first seconds of a short run.
            "memory is flat": seconds < _SETTLED_S
            or all(each <= GROWTH_MB for each in growth.values()),
            "descriptors are the same": seconds < _SETTLED_S
            or all(seen[-1][name].descriptors == seen[0][name].descriptors for name in processes),
            # A thread that sends what waits begins with the first burst, for good: the camera's is
            # two pictures of which one was held up, and that may be after many minutes.
            "no threads but the one for bursts": seconds < _SETTLED_S
            or all(seen[-1][name].threads <= seen[0][name].threads + 1 for name in processes),
        },
    )


def _sources(
    publisher: ModuleProcess, camera: ModuleProcess
) -> tuple[tuple[str, ModuleProcess], ...]:
    return (("S_Event", publisher), ("S_Picture", camera))


@pytest.mark.soak
@pytest.mark.timeout(int(MINUTES * 60) + 300)
def test_half_an_hour_of_work(make_rig: Callable[..., Rig], tell: Callable[..., None]) -> None:
    _work(make_rig, tell, MINUTES * 60.0)


def test_two_seconds_of_work(make_rig: Callable[..., Rig], tell: Callable[..., None]) -> None:
    _work(make_rig, tell, 2.0)
