"""Sessions of operators at a robot, more than it takes."""

from __future__ import annotations

import json
from collections.abc import Callable
from unittest import mock

import pytest

from hub.doors.fleet import operators
from hub.doors.fleet.operators import MOST_SESSIONS, FleetOperators
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.zenoh.attachment import Attachment


def robot_with_operators(
    monkeypatch: pytest.MonkeyPatch,
) -> tuple[FleetOperators, Callable[[str, bool], None]]:
    """A robot's side, and what the line calls with the key of a session that comes or goes."""

    def made(principal: object, session: int, _client: object) -> mock.Mock:
        return mock.Mock(principal=principal, number=session)

    monkeypatch.setattr(operators, "RemoteOperator", made)
    line, client = mock.Mock(), mock.Mock()
    client.loop.clock.return_value = 0.0
    served = FleetOperators(client, line, mock.Mock(), mock.Mock(), fleet="rune", robot="rover")
    return served, line.watch.call_args.args[1]


def test_a_session_that_came_after_too_many_others_is_let_in_when_one_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    served, changed = robot_with_operators(monkeypatch)

    def token(number: int) -> str:
        return f"rune/v1/rover/operator/operate:eve{number}/{number}"

    def sessions() -> set[int]:
        return {int(each.rpartition("/")[2]) for each in json.loads(served.as_json())}

    for number in range(1, 10_000):
        changed(token(number), True)  # noqa: FBT003
    assert sessions() == set(range(1, MOST_SESSIONS + 1))
    changed(token(MOST_SESSIONS + 1), False)  # noqa: FBT003
    changed(token(3), False)  # noqa: FBT003
    assert sessions() == set(range(1, MOST_SESSIONS + 1)) - {3} | {MOST_SESSIONS + 2}
    for number in range(1, 10_000):
        changed(token(number), False)  # noqa: FBT003
    assert sessions() == set()
    changed(token(7), True)  # noqa: FBT003
    assert sessions() == {7}


def test_one_operator_and_those_that_observe_leave_places_to_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    served, changed = robot_with_operators(monkeypatch)

    def come(operator: str, numbers: range) -> list[str]:
        for number in numbers:
            changed(f"rune/v1/rover/operator/{operator}/{number}", True)  # noqa: FBT003
        return [each for each in json.loads(served.as_json()) if each.startswith(f"{operator}/")]

    assert len(come("observe:eve", range(1, 41))) == operators.MOST_OF_ONE
    assert len(come("operate:alice", range(1, 41))) == operators.MOST_OF_ONE
    for number in range(9):
        come(f"observe:eve{number}", range(1, 9))
    observing = [each for each in json.loads(served.as_json()) if each.startswith("observe:")]
    assert len(observing) == operators.MOST_THAT_OBSERVE
    # The number of a session of another operator is no claim on it.
    assert come("supervise:sue", range(1, 2)) == ["supervise:sue/1"]


def test_commands_that_overtake_their_session_are_dropped_and_refused_aloud_later_only() -> None:
    line, client, faults = mock.Mock(), mock.Mock(), mock.Mock()
    messages = mock.Mock(known={VELOCITY_COMMAND.name: VELOCITY_COMMAND})
    FleetOperators(client, line, messages, faults, fleet="rune", robot="rover")
    commanded = line.subscribe.call_args.args[1]
    header = Attachment(publisher=7, fingerprint=0, sequence=1, stamp_ns=0).pack()

    def refusals(now: float, operator: str = "operate:eve") -> int:
        client.loop.clock.return_value = now
        line.put.reset_mock()
        commanded(f"rune/v1/rover/command/{operator}/{VELOCITY_COMMAND.name}", b"", header)
        return int(line.put.call_count)

    assert [refusals(now) for now in (100.0, 101.0, 102.9, 103.1)] == [0, 0, 0, 1]
    assert refusals(103.2, "operate:alice") == 0  # with a session of the same number
    assert faults.count.call_count == 5
