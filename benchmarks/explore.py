"""A robot explores the yellow arena by itself: contacts, how much it maps, how long it takes.

Real processes: a hub with a simulated Magellan, navigation, mapping and autonomy.
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path

from benchmarks.figures import report, say
from tests.system.exploring_hub import Tour

LONGEST_S = 900.0
STILL = 0.005


def main() -> None:
    """All figures."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        tour = Tour(stack, folder)
        seconds, asked = tour.explore(LONGEST_S, say), 1
        # On a machine that is too busy for its robot, somebody has to ask again, as in the field.
        while not tour.state.why.startswith("all is explored") and seconds < LONGEST_S:
            say(f"asked again: {tour.state.why}")
            tour.observer.wait(lambda: abs(tour.truth.linear) < STILL, 10.0)
            seconds, asked = seconds + tour.explore(LONGEST_S - seconds, say), asked + 1
        note = f"yellow arena, real sonars, asked {asked} times; at the end: {tour.state.why}"
        report("explore.contacts", tour.truth.contacts, "", bar=0, note=note)
        share = tour.mapped_share()
        report("explore.mapped_share", share, "", bar=0.9, better="higher", note=note)
        report("explore.time_s", seconds, "s", bar=600, note=note)


if __name__ == "__main__":
    main()
