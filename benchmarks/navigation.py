"""Navigation: worlds full of cylinders, times of a choice and a scan, and pushes towards walls.

The worlds run as a kinematic simulation with the very functions of the navigation module. They
are easier than the Gazebo runs that are recorded beside them. Sensing is perfect within 1.5 m, the
map is known, the body is a disc of 0.25 m, and nothing slips.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks.barn import BODY, Outcome, World, drive, load, ours
from benchmarks.figures import median_ms, report, say
from benchmarks.peers.reference_window import ReferenceWindow
from hub.gcm.beam_scans import BeamScan, ScanReader
from hub.gcm.body import BodyFrame, RangeGroup, RangeKind, RobotBody
from hub.gcm.ranges import RangeReadings, scan_of
from hub.ipc.transport import heap
from hub.modules.navigation.beam_rules import BeamRules
from hub.modules.navigation.dynamic_window import DynamicWindow
from hub.modules.navigation.ground_memory import GroundMemory
from hub.modules.navigation.obstacle_memory import ObstacleMemory
from hub.modules.navigation.path_follower import GOAL_REACH
from hub.modules.navigation.sweeps import Sweep
from hub.pose import Pose
from hub.robots.robot_file import find_robot_file, read_description
from hub.sim.arena import load_arena
from tests.hub.modules.navigation.drives import Drive, random_start
from tests.support.messages import drive_state

STARTS = 1000
PUSH_S = 15.0
POINTS = 300
PROCESSES = 2
LONG = np.array(((0.3, -0.15), (0.3, 0.15), (-0.3, 0.15), (-0.3, -0.15)))
_AROUND = np.arange(32) * (math.tau / 32)
ROUNDED = np.stack((0.3 * np.cos(_AROUND), 0.2 * np.sin(_AROUND)), axis=1)
TRACKED = read_description(find_robot_file("tracked"))[0].body
MAGELLAN = read_description(find_robot_file("magellan"))[0].body
_NOTE = "25 worlds, kinematic, perfect sensing within 1.5 m; the recorded runs are Gazebo's"


def run(job: tuple[str, World]) -> tuple[str, Outcome]:
    """One drive through one world, in a process of its own."""
    kind, world = job
    if kind == "reference":
        return kind, drive(world, ReferenceWindow(world))
    return kind, drive(world, ours(world, with_plan=kind == "plan"))


def push(seed: int) -> tuple[int, int, float]:
    """Whether the robot touched something from this start: seed, contacts, way [m]."""
    arena = load_arena("yellow")
    start = random_start(arena, seed)
    robot = Drive(arena, start, seed)
    robot.push(0.5, 0.0, PUSH_S)
    truth = robot.truth
    return seed, int(truth.contacts > 0), math.dist((truth.x, truth.y), (start.x, start.y))


def worlds() -> None:
    """Success and collisions, Rune's and others'."""
    known, recorded = load()
    results: dict[str, list[Outcome]] = {"plan": [], "straight": [], "reference": []}
    jobs = [(kind, world) for kind in results for world in known]
    with ProcessPoolExecutor(PROCESSES) as pool:
        for number, (kind, outcome) in enumerate(pool.map(run, jobs)):
            results[kind].append(outcome)
            say(f"world {number + 1} of {len(jobs)}: {kind} {outcome.how} {outcome.seconds:.1f} s")
    runs = [run for world in known for run in recorded[world.name]]
    gazebo = [sum(run[place] for run in runs) / len(runs) for place in (0, 1)]
    reference = results["reference"]
    peers = {
        "PythonRobotics' window (written anew, no plan)": share(reference, "reached"),
        "move_base DWA (Gazebo, recorded)": round(gazebo[0], 3),
    }
    report(
        "nav.barn_success",
        share(results["plan"], "reached"),
        "share",
        bar=0.95,
        better="higher",
        peers=peers,
        note=_NOTE + "; planned on the known map",
    )
    report(
        "nav.barn_success_without_planner",
        share(results["straight"], "reached"),
        "share",
        better="higher",
        peers=peers,
        note=_NOTE,
    )
    collisions = sum(
        outcome.how == "collided" for outcome in (*results["plan"], *results["straight"])
    )
    report(
        "nav.barn_collisions",
        collisions,
        "drives",
        bar=0,
        peers={
            "PythonRobotics' window (of 25)": sum(o.how == "collided" for o in reference),
            "move_base DWA (of 25, recorded share)": round(25 * gazebo[1], 2),
        },
        note=_NOTE + "; of 50 drives, half of them without a plan",
    )
    taken = [outcome.seconds for outcome in results["plan"] if outcome.how == "reached"]
    report(
        "nav.barn_seconds",
        sum(taken) / max(len(taken), 1),
        "s",
        peers={
            "move_base DWA (Gazebo, recorded)": round(
                sum(run[3] for run in runs if run[0]) / sum(run[0] for run in runs), 2
            )
        },
        note="mean of the drives that reached the goal",
    )


def share(outcomes: Iterable[Outcome], how: str) -> float:
    """Which part of the drives ended like this."""
    ends = [outcome.how == how for outcome in outcomes]
    return round(sum(ends) / len(ends), 3)


def cycle() -> None:
    """Time of one choice among 8 by 31 velocities, obstacles on all sides."""
    heap.keep_heap()  # as every module process does
    random = np.random.default_rng(1997)
    window = DynamicWindow(BODY)
    away = random.uniform(0.4, 1.5, POINTS)
    bearing = random.uniform(-math.pi, math.pi, POINTS)
    points = away * np.cos(bearing), away * np.sin(bearing)
    note = f"8 by 31 velocities, {POINTS} points on all sides within 1.5 m"
    shapes = {
        "": window,
        "_long": DynamicWindow(dataclasses.replace(BODY, outline=Sweep(LONG))),
        "_rounded": DynamicWindow(dataclasses.replace(BODY, outline=Sweep(ROUNDED))),
    }
    bodies = {"": "a disc", "_long": "a box of 0.6 by 0.3 m", "_rounded": "an ellipse"}
    for name, shape in shapes.items():
        shown = f"{note}, {bodies[name]}"
        to_goal = median_ms(
            lambda _, shape=shape: shape.to_goal((0.3, 0.1), (0.5, 0.1), 0.5, points), 300
        )
        report(f"nav.cycle{name}_ms", to_goal, "ms", bar=3.0, note=shown + ", to a goal")
        teleop = median_ms(
            lambda _, shape=shape: shape.towards((0.3, 0.1), (0.5, 0.1), points), 300
        )
        shown += ", nearest to the operator's"
        report(f"nav.teleop_cycle{name}_ms", teleop, "ms", bar=3.0, note=shown)


def scans() -> None:
    """Time of taking one scan of a laser in a room, and of a Magellan's rings."""
    heap.keep_heap()
    for beams, bar in ((360, 0.5), (1080, None)):
        laser = RangeGroup(
            name="laser", kind=RangeKind.LASER, beams=beams, step=math.tau / beams, farthest=8.0
        )
        body = RobotBody(
            name="laser", kind="", radius=0.25, frames=(BodyFrame(name="laser"),), ranges=(laser,)
        )
        note = f"{beams} beams in a room of 2.4 by 5 m, from a robot that drives a circle"
        report(f"nav.scan_{beams}_ms", _scan_ms(body), "ms", bar=bar, note=note)
    report("nav.scan_magellan_ms", _scan_ms(MAGELLAN), "ms", note="16 sonars and 16 infrareds")


def ground() -> None:
    """Time of taking the tracked robot's two scans of the ground, half of them over an edge."""
    heap.keep_heap()
    reader = ScanReader(TRACKED)
    memory = GroundMemory(TRACKED, reader.beams, 0.15)
    floor = reader.beams.to_floor()
    random = np.random.default_rng(7)

    def take(number: int) -> None:
        along = floor * random.normal(1.0, 0.01, len(floor))
        if number % 2:
            along[number % 31 :: 2] = np.inf
        pose = Pose(x=0.05 * number, theta=0.01 * number)
        memory.scanned(BeamScan(pose=pose, ranges=along, fresh=along > 0.0, along=along), number)

    beams = int((reader.beams.elevation < 0.0).sum())
    note = f"{beams} beams to the ground, half of the scans with an edge"
    report("nav.ground_scan_ms", median_ms(take, 300), "ms", note=note)


def _scan_ms(body: RobotBody) -> float:
    """Median time to read a scan and to remember its points [ms]; without scan matching."""
    reader = ScanReader(body)
    rules = BeamRules(body, reader.beams)
    memory = ObstacleMemory(body, rules, body.radius + GOAL_REACH)
    readings, drives = [], []
    for number in range(300):
        drive = drive_state(
            x=0.3 * math.cos(number / 50), y=0.3 * math.sin(number / 50), theta=number / 30
        )
        bearing = reader.beams.bearing + drive.theta
        ahead, left = np.cos(bearing), np.sin(bearing)
        with np.errstate(divide="ignore"):
            side = (np.copysign(1.2, ahead) - drive.x) / ahead
            end = (np.copysign(2.5, left) - drive.y) / left
        away = np.minimum(side, end).astype(np.float32)
        away[away > np.float32(reader.beams.farthest)] = np.inf
        scans = (
            scan_of(group, away[place], 1.0 + number / 10)
            for group, place in zip(body.ranges, reader.beams.groups.values(), strict=True)
        )
        readings.append(RangeReadings(scans=tuple(scans)))
        drives.append(drive)

    def take(number: int) -> None:
        now = number / 10
        reader.moved(drives[number], now)
        memory.moved(drives[number], now)
        scan = reader.read(readings[number], now)
        if scan is not None:
            memory.scanned(scan, now)

    return median_ms(take, len(readings))


def pushes() -> None:
    """Full speed straight ahead from random starts in the yellow arena, with its real sensors."""
    results = []
    with ProcessPoolExecutor(PROCESSES) as pool:
        for result in pool.map(push, range(STARTS), chunksize=10):
            results.append(result)
            touched = [seed for seed, contacts, _ in results if contacts]
            if len(results) % 50 == 0:
                say(f"{len(results)} starts, contacts from {touched}")
    say(f"starts that ended in a contact: {touched}")
    way = sum(way for _, _, way in results) / len(results)
    note = f"of {STARTS} starts in the yellow arena with its sonars and infrared; "
    note += f"{way:.2f} m driven on average"
    report("nav.teleop_contacts", len(touched), "starts", bar=0, note=note)


def main() -> None:
    parts = {"worlds": worlds, "cycle": cycle, "scans": scans, "ground": ground, "pushes": pushes}
    for name in sys.argv[1:] or parts:
        parts[name]()


if __name__ == "__main__":
    main()
