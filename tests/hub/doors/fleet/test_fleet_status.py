"""`rune-hub fleet list`: the robots that are there, one on a line."""

from __future__ import annotations

import pytest

from hub.doors.fleet.fleet_status import list_robots


class FakeSession:
    """A router that knows these tokens."""

    def __init__(self, *tokens: str) -> None:
        self._tokens = tokens

    def tokens(self, _pattern: str, *, timeout: float) -> tuple[str, ...]:
        assert timeout > 0.0
        return self._tokens


def test_an_empty_fleet_is_said_beside_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert list_robots(FakeSession(), "rune/lab", as_json=False) == 0
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "rune-hub: no robot is in the fleet rune/lab now\n")


def test_robots_are_listed_once_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    tokens = ("rune/v1/rover/alive", "rune/v1/boat/alive", "rune/v1/rover/alive")
    assert list_robots(FakeSession(*tokens), "rune", as_json=False) == 0
    said = capsys.readouterr()
    assert (said.out, said.err) == ("boat\nrover\n", "")
