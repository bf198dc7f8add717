"""`rune-hub mission score`: the marks of a mission beside the victims of its arena."""

from __future__ import annotations

import math
from collections.abc import Iterator

from hub.command_output import put, put_json
from hub.errors import ArenaError
from hub.inspection.mission_commands import chosen
from hub.inspection.output import table
from hub.missions.export import marks_of
from hub.missions.scoring import Score, Victim, VictimScore, score
from hub.nearest import did_you_mean
from hub.plain_text import plain
from hub.pose import Pose
from hub.sim.arena import arena_path
from hub.sim.arena_file import read_arena_file
from hub.sim.arena_specs import ArenaSpec


def show(
    mission: str,
    robot: str,
    folder: str,
    *,
    arena: str,
    berth: str,
    operators: int,
    as_json: bool,
) -> int:
    """Show the score of a mission; without an id that of the newest.

    Args:
        mission: Its id; empty: the newest.
        robot: Robot file or name; empty: any robot.
        folder: Folder of the missions; empty: the usual one.
        arena: A shipped arena, or an arena file.
        berth: The berth at which the robot started; empty: the rover's start.
        operators: Number of operators.
        as_json: Whether to write one line of JSON.

    Raises:
        MissionError: There is no such mission, or it cannot be read.
        ArenaError: There is no such arena or berth, or its file has mistakes.
    """
    each, mission = chosen(mission, robot, folder)
    book, _ = each.read(mission)
    spec = read_arena_file(arena_path(arena))
    start = _start(spec, berth)
    victims = [_seen(spec_of.name, spec_of.at, start) for spec_of in spec.victims]
    marks = [mark for _, mark in marks_of(book)]
    made = score(victims, marks, spec.scoring.weight, operators)
    if as_json:
        put_json({"robot": each.robot, "mission": mission, "arena": spec.name, **facts(made)})
        return 0
    put(plain(f"mission {book.name} of {each.robot}, compared with arena {spec.name}"))
    table(("VICTIM", "MARK", "OFF [m]", "POINTS"), list(map(_row, made.findings)))
    for line in _sums(made):
        put(line)
    return 0


def facts(made: Score) -> dict[str, object]:
    """A score as JSON has it."""
    return {
        "victims": [
            {
                "name": finding.victim.name,
                "mark": finding.mark or None,
                "error": None if math.isnan(finding.error) else round(finding.error, 3),
                "points": round(finding.points, 2),
            }
            for finding in made.findings
        ],
        "found": made.found,
        "missed": len(made.findings) - made.found,
        "false": list(made.false),
        "repeated": list(made.repeated),
        "weight": made.weight,
        "operators": made.operators,
        "score": round(made.total, 2),
    }


def _start(spec: ArenaSpec, berth: str) -> Pose:
    """Where `map` has its origin in the arena."""
    if not berth:
        return Pose(x=spec.start.at[0], y=spec.start.at[1], theta=spec.start.heading)
    for each in spec.berths:
        if each.robot == berth:
            return Pose(x=each.at[0], y=each.at[1], theta=each.heading)
    known = [each.robot for each in spec.berths]
    text = f"it has no berth {berth!r}{did_you_mean(berth, known)}"
    raise ArenaError(spec.name, [text])


def _seen(name: str, at: tuple[float, float], start: Pose) -> Victim:
    x, y = start.inward(*at)
    return Victim(name=name, x=x, y=y)


def _row(finding: VictimScore) -> tuple[str, str, str, str]:
    if not finding.mark:
        return plain(finding.victim.name), "missed", "", "0"
    return (
        plain(finding.victim.name),
        str(finding.mark),
        f"{finding.error:.2f}",
        f"{finding.points:.1f}",
    )


def _sums(made: Score) -> Iterator[str]:
    yield f"{made.found} of {len(made.findings)} found"
    if made.false:
        yield f"marks without a victim: {', '.join(map(str, made.false))}"
    if made.repeated:
        yield f"further marks of a victim: {', '.join(map(str, made.repeated))}"
    by = "1 operator" if made.operators == 1 else f"{made.operators} operators"
    yield f"score {made.total:.1f}, with weight {made.weight:g} and {by}"
