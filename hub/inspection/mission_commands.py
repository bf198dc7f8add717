"""`rune-hub mission`: the records of missions, and the running mission."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hub.command_line import login_name
from hub.command_output import print_error, put, put_json
from hub.errors import MissionError, NoHandlerError, QueryError, RobotFileError
from hub.gcm.common import COMMON_RESULT
from hub.gcm.mission import MISSION_COMMAND, MissionAction, MissionCommand
from hub.inspection.output import report, span, table
from hub.ipc.client import Client
from hub.missions.export import MissionPhase, facts_of_marks, mission_facts, moment
from hub.missions.export import export as export_files
from hub.missions.folder import MissionFolder
from hub.paths import as_file_name, for_missions
from hub.plain_text import plain
from hub.robots.robot_file import find_robot_file, read_description

_ANSWER_S = 5.0
_STATES = {
    MissionPhase.RUNS: "runs",
    MissionPhase.INTERRUPTED: "is interrupted; it goes on when the robot's hub starts",
    MissionPhase.NOT_ENDED: "was not ended",
    MissionPhase.ENDED: "is ended",
}


def list_all(robot: str, folder: str, *, as_json: bool) -> int:
    """Show all missions, the oldest first.

    Returns:
        The exit code: 1 where one cannot be read.

    Raises:
        MissionError: A folder is there and cannot be read.
    """
    rows = []
    found = [_facts(each, known) for each in _folders(robot, folder) for known in each.missions()]
    for facts in sorted(found, key=lambda facts: (facts["id"], facts["robot"])):
        if as_json:
            put_json(facts)
            continue
        ended = facts.get("ended") or 0.0
        lasted = span(ended - facts["begun"]) if ended else ""
        rows.append(
            (
                plain(facts["robot"]),
                facts["id"],
                plain(facts["name"]),
                lasted or facts["state"],
                *(
                    (str(facts["marks"]), f"{facts['size_bytes'] / 1e6:.1f} MB")
                    if facts["marks"] is not None
                    else ("?", "?")
                ),
            )
        )
    if rows:
        table(("robot", "mission", "name", "lasted", "marks", "size"), rows, words=4)
    elif not as_json:
        put("there are no missions here")
    return 1 if any(facts["marks"] is None for facts in found) else 0


def show(mission: str, robot: str, folder: str, *, as_json: bool) -> int:
    """Show one mission: its marks and events; without an id the newest.

    Raises:
        MissionError: There is none, or it cannot be read.
    """
    each, mission = chosen(mission, robot, folder)
    facts = mission_facts(each, mission)
    book, _ = each.read(mission)
    if as_json:
        events = [{"stamp": event.stamp, "text": event.text} for event in book.events]
        put_json({**facts, "marks": facts_of_marks(book), "events": events})
        return 1 if facts["damaged"] else 0
    state = _STATES[MissionPhase(facts["state"])]
    put(plain(f"mission {facts['name']} of {facts['robot']} ({mission}) {state}"))
    put(f"in {each.path / mission}")
    if facts["damaged"]:
        put(f"{facts['damaged']} records are damaged and left out")
    for mark in facts_of_marks(book):
        place = f"{mark['kind']} {mark['number']} at {mark['x']:.2f}, {mark['y']:.2f} m"
        sheet = f" on sheet {mark['sheet']}" if book.sheet > 1 else ""
        put(plain(f"{place}{sheet}, {mark['by']}, {moment(mark['stamp'])} {mark['note']}").rstrip())
    for event in book.events:
        put(plain(f"{moment(event.stamp)}  {event.text}"))
    return 1 if facts["damaged"] else 0


def export(mission: str, robot: str, folder: str, output: Path | None) -> int:
    """Write a mission into files that other programs read; without an id the newest.

    Raises:
        MissionError: There is none, it cannot be read, or the files cannot be written.
    """
    each, mission = chosen(mission, robot, folder)
    target = output or Path(mission)
    written = export_files(each, mission, target)
    put(f"{len(written)} files are in {target}")
    damaged = mission_facts(each, mission)["damaged"]
    if damaged:
        print_error(f"{damaged} records of the mission are damaged and left out")
    return 1 if damaged else 0


def order(client: Client, action: MissionAction, name: str) -> int:
    """Have the robot begin, name or end its mission."""
    command = MissionCommand(action=action, name=name, by=login_name())
    try:
        result = client.query_response(MISSION_COMMAND, command, COMMON_RESULT, timeout=_ANSWER_S)
    except NoHandlerError as error:
        text = "mapping, which keeps missions, does not run; `rune-hub start mapping` starts it"
        raise QueryError(text) from error
    return report(result)


def chosen(mission: str, robot: str, folder: str) -> tuple[MissionFolder, str]:
    """The one mission that is meant.

    Args:
        mission: Its id; empty: the newest.
        robot: Name in the list, or robot file; empty: any robot.
        folder: Folder of the missions; empty: the usual one.

    Raises:
        MissionError: There is none, or several robots have one of this id.
    """
    found = [(each, known) for each in _folders(robot, folder) for known in each.missions()]
    if mission:
        found = [(each, known) for each, known in found if known == mission]
    if not found:
        which = f"no mission {mission[:40]!r}" if mission else "no mission"
        text = f"there is {which} here; `rune-hub mission list` shows all"
        raise MissionError(text)
    newest = max(known for _, known in found)
    meant = [each for each, known in found if known == newest]
    if len(meant) > 1:
        text = f"several robots have a mission {newest}; say whose with --robot NAME"
        raise MissionError(text)
    return meant[0], newest


def _folders(robot: str, folder: str) -> list[MissionFolder]:
    """The folders of the robots that are meant."""
    kept = for_missions(folder)
    if robot and (kept / as_file_name(robot)).is_dir():
        return [MissionFolder(kept, robot)]
    if robot:
        try:
            described, problems = read_description(find_robot_file(robot))
        except RobotFileError as error:
            wanted = "a name of column 'robot' of `rune-hub mission list`, or a robot file"
            text = f"{error}; --robot wants {wanted}"
            raise MissionError(text) from error
        if problems:
            raise MissionError(problems[0])
        return [MissionFolder(for_missions(folder or described.mission_folder), described.name)]
    root = for_missions(folder)
    try:
        names = sorted(entry.name for entry in root.iterdir() if entry.is_dir())
    except OSError as fault:
        if isinstance(fault, FileNotFoundError) and not folder:
            return []  # no robot has kept a mission yet
        text = f"{root} cannot be read: {fault.strerror or fault}"
        raise MissionError(text) from fault
    return [MissionFolder.of(root / name) for name in names]


def _facts(folder: MissionFolder, mission: str) -> dict[str, Any]:
    """The row of a mission in a list, even of an unreadable one."""
    try:
        return mission_facts(folder, mission)
    except MissionError as error:
        return {
            "robot": folder.robot, "id": mission, "name": f"cannot be read: {error}",
            "begun": 0.0, "ended": None, "state": "not readable", "running": False, "marks": None,
            "size_bytes": None,
        }  # fmt: skip
