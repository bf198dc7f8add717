"""`rune-hub fleet list` and `status`: the robots that are there, and who drives them."""

from __future__ import annotations

import time
from typing import Any

from hub.command_output import print_error, put, put_json
from hub.errors import CodecError, FleetKeyError, FrameError
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.ipc.roles import Principal
from hub.plain_text import counted, plain
from hub.table_text import json_text
from hub.zenoh.attachment import CLOCK, unpack
from hub.zenoh.fleet_keys import FleetKey, KeyKind, parse_key, pattern
from hub.zenoh.fleet_session import FleetSession, FleetWay
from hub.zenoh.settings import UNLISTED, RouterPlace

_ANSWER_S = 2.0
_ALL_S = 30.0
"""Time after which no further robot is asked for its status [s]."""
MOST_LISTED = 1000
"""Most robots that are listed."""


def list_robots(session: FleetSession, fleet: str, place: RouterPlace, *, as_json: bool) -> int:
    """Show the robots that are there."""
    robots = _robots(session, fleet)
    for robot in robots:
        put(json_text({"robot": robot}) if as_json else robot)
    if not robots:
        _say_none(fleet, place)
    return 0


def show_status(
    session: FleetSession, fleet: str, place: RouterPlace, asker: Principal, *, as_json: bool
) -> int:
    """Show who drives each robot, how far it is away, and the link of this program."""
    robots = _robots(session, fleet)
    if not as_json:
        number = counted(len(robots), "robot")
        put(f"fleet {fleet} at {place}, as {asker}: {number}")
    began = time.monotonic()
    for number_asked, robot in enumerate(robots):
        if time.monotonic() - began > _ALL_S:
            left = counted(len(robots) - number_asked, "robot")
            print_error(f"{left} not asked, as the answers took more than {_ALL_S:g} s")
            break
        facts = _facts(session, fleet, robot)
        if as_json:
            put_json(facts)
        else:
            put(f"  {robot:<20} {_words(facts)}")
    if not robots and place.scheme == "tls":
        _say_none(fleet, place)
    return 0


def _say_none(fleet: str, place: RouterPlace) -> None:
    """Say why nothing is shown; a router says nothing to a refused program."""
    unlisted = f", or {UNLISTED}" if place.scheme == "tls" else ""
    print_error(f"no robot is in the fleet {fleet} now{unlisted}")


def _robots(session: FleetSession, fleet: str) -> list[str]:
    """The robots that are there; says how many tokens are not shown."""
    names, wrong = set(), 0
    for token in session.tokens(pattern(fleet, KeyKind.ALIVE), timeout=_ANSWER_S):
        try:
            names.add(parse_key(fleet, token).robot)
        except FleetKeyError:
            wrong += 1
    if wrong:
        print_error(f"{counted(wrong, 'token')} left out, which cannot be the name of a robot")
    if len(names) > MOST_LISTED:
        left = counted(len(names) - MOST_LISTED, "robot")
        print_error(f"{left} left out, as at most {MOST_LISTED} are listed")
    return sorted(names)[:MOST_LISTED]


def _facts(session: FleetSession, fleet: str, robot: str) -> dict[str, Any]:
    facts: dict[str, Any] = {"robot": robot}
    clock = FleetKey(kind=KeyKind.CLOCK, robot=robot).under(fleet)
    sent = time.monotonic()
    answers = session.answers(clock, way=FleetWay.COMMAND, timeout=_ANSWER_S)
    facts["round_trip_ms"] = round((time.monotonic() - sent) * 1e3, 1) if answers else None
    key = FleetKey(kind=KeyKind.LAST, robot=robot, message=CONTROL_STATE.name).under(fleet)
    now_ns = CLOCK.unpack(answers[0].payload)[0] if answers and len(answers[0].payload) == 8 else 0
    for answer in session.answers(key, way=FleetWay.COMMAND, timeout=_ANSWER_S):
        try:
            state: ControlState = CONTROL_STATE.decode(answer.payload)
            age = unpack(answer.attachment).age(now_ns)
        except (CodecError, FrameError) as error:
            facts["fault"] = plain(str(error))
            continue
        facts |= {
            "operator": plain(state.operator) if state.owner else None,
            "why": plain(state.why),
            "moved_by": plain(state.commander_name) or None,
            "age_s": round(age, 2),
        }
    return facts


def _words(facts: dict[str, Any]) -> str:
    if facts["round_trip_ms"] is None:
        return "does not answer"
    if "age_s" not in facts:
        return f"{facts['round_trip_ms']:g} ms away; {facts.get('fault', 'no state of control')}"
    owner = facts["operator"]
    drives = f"{owner} has control" if owner else f"free: {facts['why']}"
    moved = f", moved by {facts['moved_by']}" if facts["moved_by"] else ""
    return f"{drives}{moved}; {facts['round_trip_ms']:g} ms away, {facts['age_s']:g} s old"
