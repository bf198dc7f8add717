"""A robot explores the yellow arena by itself: contacts, how much it maps, the error of its pose.

First the same parts without processes, several seeds, faster than a robot; then real processes: a
hub with a simulated Magellan, navigation, mapping and autonomy.
"""

from __future__ import annotations

import math
import statistics
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from benchmarks.exploring import Exploration
from benchmarks.figures import report, say
from hub.pose import Pose
from hub.sim.arena import load_arena
from tests.hub.modules.mapping.touring import from_start
from tests.system.exploring_hub import Tour, mapped_share

LONGEST_S = 900.0
STILL = 0.005
SEEDS = tuple(range(1, 11))
LONGEST_GOOD_S = 600.0
ENOUGH = 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """How an exploration without processes went.

    Attributes:
        seed: Of everything that is drawn by lot.
        share: How much of the ground is mapped, 0 to 1.
        seconds: Until it was back, or the time was over [s].
        contacts: How often the robot touched anything.
        off: Error of the pose, mean over the time [m].
        why: How it ended.
    """

    seed: int
    share: float
    seconds: float
    contacts: int
    off: float
    why: str

    @property
    def ended(self) -> bool:
        """Whether it ended by itself."""
        return self.why.startswith("explored: ")


def run(seed: int) -> Run:
    """Explore with one seed; runs of several processes do not disturb each other."""
    arena = load_arena("yellow")
    exploration = Exploration(seed)
    errors: list[float] = []
    seconds = exploration.explore(
        LONGEST_S, lambda: errors.append(pose_error(exploration, arena.start))
    )
    return Run(
        seed=seed,
        share=mapped_share(arena, exploration.grid()),
        seconds=seconds,
        contacts=exploration.robot.ground_truth().contacts,
        off=statistics.mean(errors),
        why=exploration.autonomy.state(exploration.now).why,
    )


def seeds(numbers: Sequence[int] = SEEDS) -> None:
    """How much is mapped, how long it takes and the error of the pose, without processes."""
    runs = []
    for seed in numbers:
        runs.append(each := run(seed))
        say(
            f"seed {seed}: {each.share:.2f} in {each.seconds:.0f} s, {each.off:.2f} m off,"
            f" {each.contacts} contacts, {each.why if each.ended else 'did not end'}"
        )
    good = sum(
        each.ended and each.share >= ENOUGH and each.seconds <= LONGEST_GOOD_S for each in runs
    )
    note = f"ended by itself with {ENOUGH} mapped in {LONGEST_GOOD_S:.0f} s, of {len(runs)} seeds"
    report("explore.good_seeds", good, "", bar=len(runs), better="higher", note=note)
    ended = sum(each.ended for each in runs)
    report("explore.ended_seeds", ended, "", bar=len(runs), better="higher", note="by itself")
    shares, times = [each.share for each in runs], [each.seconds for each in runs]
    note = f"mean {statistics.mean(shares):.2f}"
    report("explore.least_share", min(shares), "", bar=ENOUGH, better="higher", note=note)
    note = f"with the way home; mean {statistics.mean(times):.0f} s"
    report("explore.longest_s", max(times), "s", bar=LONGEST_GOOD_S, note=note)
    report("explore.seed_contacts", sum(each.contacts for each in runs), "", bar=0)
    off = statistics.mean(each.off for each in runs)
    report("explore.pose_error_m", off, "m", bar=0.25, note="mean over time and seeds")


def pose_error(exploration: Exploration, start: Pose) -> float:
    """How far the robot is from where navigation thinks it is [m]."""
    true, estimate = from_start(exploration.robot.ground_truth(), start), exploration.navigator.pose
    return math.hypot(estimate.x - true.x, estimate.y - true.y)


def hub() -> None:
    """What real processes map, and whether they touch anything."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        tour = Tour(stack, folder)
        seconds, asked = tour.explore(LONGEST_S, say), 1
        # Where it was given up before the end, an operator asks again, as in the field.
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
    """All figures, or those of the parts that are named: `hub`, `seeds`, or numbers of seeds."""
    names = sys.argv[1:] or ["seeds", "hub"]
    numbers = [int(name) for name in names if name.isdigit()]
    if numbers or "seeds" in names:
        seeds(numbers or SEEDS)
    if "hub" in names:
        hub()


if __name__ == "__main__":
    main()
