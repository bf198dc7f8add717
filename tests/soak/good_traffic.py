"""Good traffic beside an attack: what it lost, how long it took, and what central cost."""

from __future__ import annotations

import time
from dataclasses import asdict
from typing import Any

from tests.soak.module_process import Row
from tests.soak.rig import PUBLISHER, SENT, Rig, Vitals, latency_ms, lost
from tests.support.waiting import until

P99_MS = 5.0
GROWTH_MB = 5.0
_BROADCASTS = ("S_Event", "S_Command")


class GoodTraffic:
    """A publisher and a subscriber, an asker and who answers; measured before and during.

    The attack starts after the making of it and ends before `bars`.
    """

    def __init__(self, rig: Rig, *, quiet_s: float, timed: bool) -> None:
        """Start and wait until it flows.

        Args:
            rig: Whose central.
            quiet_s: How long to measure before the attack [s].
            timed: Whether there are bars on times: not where other tests run beside this one.
        """
        self._rig = rig
        self._timed = timed
        self._publisher = rig.module(
            "publisher", publish=[("S_Event", 500.0, 200), ("S_Command", 100.0, 20)]
        )
        self._subscriber = rig.module("subscriber", subscribe=list(_BROADCASTS))
        self._responder = rig.module("responder", answer_s=0.0)
        self._asker = rig.module("asker", ask_hz=50.0)
        rig.wait_flowing(self._subscriber, *_BROADCASTS)
        until(lambda: len(self._asker.rows(Row.ANSWERED)), 20.0, "no query was answered")
        self._started_ns = time.monotonic_ns()
        enough = self._started_ns + int(quiet_s * 1e9)
        until(lambda: time.monotonic_ns() > enough, quiet_s + 10.0)
        self.before = rig.central.vitals()
        self._attacked_ns = time.monotonic_ns()
        self.figures: dict[str, Any] = {}

    def finish(self) -> dict[str, bool]:
        """End it when the attack has ended; the bars and whether they hold."""
        ended_ns = time.monotonic_ns()
        alive = self._rig.central.process.poll() is None
        after = self._settled() if alive else self.before
        self._rig.wait_drained(self._publisher, self._subscriber)
        modules = (self._asker, self._subscriber, self._responder)
        summaries = {
            module.plan.name: module.summary or module.finish()
            for module in (*modules, self._publisher)
        }
        losses, latencies = {}, {}
        # An attack may publish under the same names.
        number = self._publisher.rows(Row.CONNECTED)[-1, PUBLISHER]
        for name in _BROADCASTS:
            rows = self._subscriber.received(name)
            rows = rows[rows[:, PUBLISHER] == number]
            losses[name] = lost(rows, summaries["publisher"]["published"][name])
            latencies[name] = {
                "before": latency_ms(rows, self._started_ns, self._attacked_ns),
                "during": latency_ms(rows, self._attacked_ns, ended_ns),
            }
        failed = self._asker.rows(Row.FAILED)
        cut = {module.plan.name: len(module.rows(Row.LOST)) for module in modules}
        faults = {name: s["first faults"] for name, s in summaries.items() if s["faults"]}
        self.figures = {
            "good_published": summaries["publisher"]["published"],
            "good_lost": losses,
            "latencies": latencies,
            "queries_failed": int((failed[:, SENT] >= self._started_ns).sum()),
            "failures": summaries["asker"].get("failures", {}),
            "connections_lost": cut,
            "central_before": asdict(self.before),
            "central_after": asdict(after),
            "faults": faults,
        }
        # On a machine that is held up, commands pass their lifespan and must be dropped.
        late = summaries["subscriber"]["complaints"].get("too old", 0)
        log = self._rig.central.log.read_text()
        return {
            "central lives": alive,
            "no fault in central": "internal fault" not in log and "Traceback" not in log,
            "no fault in a module": not faults,
            "0 good messages lost": losses["S_Event"] == 0
            and 0 <= losses["S_Command"] <= (0 if self._timed else late),
            "no good query failed": self.figures["queries_failed"] == 0,
            "no good module lost central": not self._timed or not any(cut.values()),
            "p99 of good messages": not self._timed
            or all(each["during"]["typical_p99_ms"] <= P99_MS for each in latencies.values()),
            "descriptors and threads back": after.descriptors <= self.before.descriptors + 2
            and after.threads <= self.before.threads,
            "memory back": after.memory_mb - self.before.memory_mb <= GROWTH_MB,
        }

    def _settled(self) -> Vitals:
        """What central costs when handshakes have timed out and it has given memory back."""
        central, before = self._rig.central, self.before

        def settled(now: Vitals) -> bool:
            few = now.descriptors <= before.descriptors + 2
            return few and now.memory_mb - before.memory_mb <= GROWTH_MB

        end = time.monotonic() + 10.0
        until(lambda: settled(central.vitals()) or time.monotonic() > end, 20.0)
        return central.vitals()
