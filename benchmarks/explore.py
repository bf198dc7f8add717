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


def main() -> None:
    """All figures."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        tour = Tour(stack, folder)
        seconds = tour.explore(LONGEST_S, say)
        note = f"simulated Magellan, yellow arena, real sonars; at the end: {tour.state.why}"
        report("explore.contacts", tour.truth.contacts, "", bar=0, note=note)
        share = tour.mapped_share()
        report("explore.mapped_share", share, "", bar=0.9, better="higher", note=note)
        report("explore.time_s", seconds, "s", bar=600, note=note)


if __name__ == "__main__":
    main()
