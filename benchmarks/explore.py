"""A robot explores the yellow arena by itself: contacts, how much it maps, how long it takes.

First the same parts without processes, several seeds, faster than a robot; then real processes: a
hub with a simulated Magellan, navigation, mapping and autonomy.
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path

from benchmarks.exploring import Exploration
from benchmarks.figures import report, say
from hub.sim.arena import load_arena
from tests.system.exploring_hub import Tour, mapped_share

LONGEST_S = 900.0
STILL = 0.005
SEEDS = (1, 2, 3)
LONGEST_SEED_S = 600.0
ENOUGH = 0.9


def seeds() -> None:
    """How often enough is mapped in time, in explorations without processes."""
    shares, contacts, notes = [], 0, []
    for seed in SEEDS:
        exploration = Exploration(seed)
        seconds = exploration.explore(LONGEST_SEED_S)
        shares.append(mapped_share(load_arena("yellow"), exploration.grid()))
        contacts += exploration.robot.ground_truth().contacts
        notes.append(f"seed {seed}: {shares[-1]:.2f} in {seconds:.0f} s")
        say(notes[-1])
    note = f"{', '.join(notes)}; {contacts} contacts"
    good = sum(share > ENOUGH for share in shares) / len(shares)
    report("explore.mapped_share_seeds", good, "", bar=0.8, better="higher", note=note)


def main() -> None:
    """All figures."""
    seeds()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        tour = Tour(stack, folder)
        seconds, asked = tour.explore(LONGEST_S, say), 1
        # On a machine that is too busy for its robot, somebody has to ask again, as in the field.
        while not tour.state.why.startswith("explored: ") and seconds < LONGEST_S:
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
