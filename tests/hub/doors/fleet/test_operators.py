"""Sessions of operators at a robot, more than it takes."""

from __future__ import annotations

import json
from unittest import mock

import pytest

from hub.doors.fleet import operators
from hub.doors.fleet.operators import MOST_SESSIONS, FleetOperators


def test_a_session_that_came_after_too_many_others_is_let_in_when_one_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def made(principal: object, session: int, _client: object) -> mock.Mock:
        return mock.Mock(principal=principal, number=session)

    monkeypatch.setattr(operators, "RemoteOperator", made)
    line, client = mock.Mock(), mock.Mock()
    client.loop.clock.return_value = 0.0
    served = FleetOperators(client, line, mock.Mock(), mock.Mock(), fleet="rune", robot="rover")
    changed = line.watch.call_args.args[1]

    def token(number: int) -> str:
        return f"rune/v1/rover/operator/operate:eve{number}/{number}"

    def sessions() -> set[int]:
        return {int(each) for each in json.loads(served.as_json())}

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
