"""One operator finds and marks a victim with a rover, a blimp and an underwater robot."""

from __future__ import annotations

import math
from pathlib import Path

from hub.gcm.mapping import POINT_COMMAND, PointKind
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.gcm.vision import CAMERA_COMMAND
from tests.system.team_operator import TEAM, Member, Operator, run_team

LARGE_PX = 80
"""The large picture is wider, the small ones are not."""
MOVED_M, SLOW_M_S = 0.05, 0.1
NEAR_M = 0.5
"""A mark is on the near side of a victim, which is half a metre long [m]."""


async def search(operator: Operator, member: Member) -> None:
    """Choose a robot, drive it, look down to the victim, and mark it."""
    name, console = member.role, operator.console
    await operator.press(member.key)
    await operator.until(lambda: console.state.chosen == name, "not chosen")
    await operator.until(lambda: operator.picture_width(name) > LARGE_PX, "no large picture")
    start = operator.truth(name)
    await operator.hold_until(
        "w",
        lambda: (
            math.dist((start.x, start.y), (operator.truth(name).x, operator.truth(name).y))
            > MOVED_M
        ),
    )
    await operator.until(lambda: abs(operator.truth(name).linear) < SLOW_M_S, "it does not stop")
    if not operator.in_picture(member):
        await operator.hold_until("k", lambda: operator.in_picture(member))
    operator.click_on_victim(member)
    await operator.until(lambda: name in console.state.ghosts, "no place there")
    operator.click_on_victim(member)
    await operator.until(lambda: operator.witnesses[name].marks, "not marked")
    (mark,) = operator.witnesses[name].marks
    found = operator.place_in_arena(name, mark)
    assert math.dist(found, member.victim) < NEAR_M, (name, found, member.victim)
    assert (mark.kind, mark.by) == (PointKind.VICTIM, "jane")
    assert mark.thumbnail.size


def test_commands_pictures_and_marks_of_each_robot_reach_no_other(tmp_path: Path) -> None:
    async def script(operator: Operator) -> None:
        for witness in operator.witnesses.values():
            witness.received()
        for member in TEAM:
            await search(operator, member)
            for name, witness in operator.witnesses.items():
                received = witness.received()
                if name != member.role:
                    assert not received, f"{name} received {received} of {member.role}"
                else:
                    own = {VELOCITY_COMMAND.name, POINT_COMMAND.name}
                    assert own <= received <= own | {CAMERA_COMMAND.name}
        for member in TEAM:
            assert len(operator.witnesses[member.role].marks) == 1
            assert {*operator.seen[member.role]} <= {
                member.degrees - 1,
                member.degrees,
                member.degrees + 1,
            }

    run_team(tmp_path, script)
