"""A robot explores the yellow arena by itself: contacts, how much it maps, how far off it is.

First the same parts without processes, several seeds, faster than a robot; then real processes: a
hub with a simulated Magellan, navigation, mapping and autonomy.
"""

from __future__ import annotations

import math
import statistics
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

from benchmarks.exploring import Exploration
from benchmarks.figures import report, say
from hub.plane import Pose
from hub.sim.arena import load_arena
from tests.hub.modules.mapping.touring import from_start
from tests.system.exploring_hub import Tour, mapped_share

LONGEST_S = 900.0
STILL = 0.005
SEEDS = (1, 2, 3)
LONGEST_SEED_S = 900.0
ENOUGH = 0.9


def seeds() -> None:
    """How much is mapped and how far off the pose is, in explorations without processes."""
    arena = load_arena("yellow")
    shares, offs, contacts, notes = [], [], 0, []
    for seed in SEEDS:
        exploration = Exploration(seed)
        errors: list[float] = []

        def watch(here: Exploration = exploration, to: list[float] = errors) -> None:
            to.append(pose_error(here, arena.start))

        seconds = exploration.explore(LONGEST_SEED_S, watch)
        shares.append(mapped_share(arena, exploration.grid()))
        offs.append(statistics.mean(errors))
        contacts += exploration.robot.ground_truth().contacts
        ended = exploration.autonomy.state(exploration.now).why.startswith("explored: ")
        notes.append(
            f"seed {seed}: {shares[-1]:.2f} in {seconds:.0f} s, {offs[-1]:.2f} m off,"
            f" {'ended by itself' if ended else 'did not end'}"
        )
        say(notes[-1])
    note = f"{'; '.join(notes)}; {contacts} contacts"
    good = sum(share > ENOUGH for share in shares) / len(shares)
    report("explore.mapped_share_seeds", good, "", bar=0.8, better="higher", note=note)
    report("explore.pose_error_m", statistics.mean(offs), "m", note="mean over time and seeds")


def pose_error(exploration: Exploration, start: Pose) -> float:
    """How far the robot is from where navigation thinks it is [m]."""
    true, told = from_start(exploration.robot.ground_truth(), start), exploration.navigator.pose
    return math.hypot(told.x - true.x, told.y - true.y)


def hub() -> None:
    """What real processes map, and whether they touch anything."""
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


def main() -> None:
    """All figures, or those of the parts that are named."""
    parts = {"seeds": seeds, "hub": hub}
    for name in sys.argv[1:] or parts:
        parts[name]()


if __name__ == "__main__":
    main()
