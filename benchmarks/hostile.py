"""What ten hostile observers cost the others, who drive and stop a robot meanwhile.

Real processes: a hub with a simulated robot and a gateway, and an operator who comes through it.
Ten clients with keys to observe flood the hub, each in its own way.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

import psutil

from benchmarks.figures import report, say
from tests.misbehaving.hostile_observer import ATTACKS
from tests.system.attacked_hub import DOWN, LOCAL, MIX, UP, AttackedHub, Seen

QUIET_S = 20.0
STOP_S = 0.35
TWICE = 2.0
LEAST_S = 0.005
"""Ages below this count as this: twice nothing is nothing [s]."""


def _ratio(way: str, quiet: Seen, attacked: Seen) -> None:
    before, during = quiet.p99(way), attacked.p99(way)
    note = f"p99 {before * 1e3:.1f} ms in quiet, {during * 1e3:.1f} ms attacked"
    ratio = max(during, LEAST_S) / max(before, LEAST_S)
    report(f"hostile.p99_vs_quiet_{way}", ratio, "", bar=TWICE, note=note)


def measure(attacks: tuple[str, ...], seconds: float) -> None:
    """Everything, once in quiet and once with these attacks."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        attacked_hub = AttackedHub(stack, folder)
        daemon = psutil.Process(attacked_hub.hub.process.pid)
        say(f"quiet, for {QUIET_S:.0f} s")
        quiet = attacked_hub.measure(QUIET_S)
        memory = daemon.memory_info().rss
        say(f"{Counter(attacks)}, for {seconds:.0f} s")
        with attacked_hub.attackers(attacks, seconds + 20.0):
            attacked = attacked_hub.measure(seconds)
            for reason, count in attacked_hub.refused().items():
                say(f"refused: {reason}: {count}")
        for line in attacked.gone:
            say(line)
        stops = sorted(quiet.stops)
        note = f"{len(attacked.stops)} stops; in quiet {stops[-1] * 1e3:.0f} ms at most"
        report("hostile.stop_p100_ms", max(attacked.stops) * 1e3, "ms", bar=STOP_S * 1e3, note=note)
        report("hostile.lost_hub", len(attacked.gone), "", bar=0)
        for way in (LOCAL, UP, DOWN):
            _ratio(way, quiet, attacked)
        pictures = len(attacked.queries), attacked.unanswered
        note = f"{pictures[0]} pictures; in quiet {quiet.unanswered} of {len(quiet.queries)} failed"
        report("hostile.pictures_failed", pictures[1], "", bar=0, note=note)
        grown = (daemon.memory_info().rss - memory) / 1e6
        report("hostile.hub_grown_MB", grown, "MB", bar=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0, help="how long (%(default)s)")
    parser.add_argument("--only", choices=ATTACKS, help="ten of this kind, not one of each")
    options = parser.parse_args()
    measure((options.only,) * 10 if options.only else MIX, options.seconds)


if __name__ == "__main__":
    main()
