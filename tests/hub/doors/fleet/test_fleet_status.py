"""`rune-hub fleet list`: the robots that are there, one on a line."""

from __future__ import annotations

import itertools

import pytest

from hub.doors.fleet.fleet_status import MOST_LISTED, list_robots, show_status
from hub.ipc.roles import Principal, Role
from hub.zenoh.settings import parse_place

OPEN, GUARDED = parse_place("tcp/127.0.0.1:7447"), parse_place("tls/fleet.example:7447")


class FakeSession:
    """A router that knows these tokens."""

    def __init__(self, *tokens: str) -> None:
        self._tokens = tokens

    def tokens(self, _pattern: str, *, timeout: float) -> tuple[str, ...]:
        assert timeout > 0.0
        return self._tokens

    def answers(self, _key: str, **_options: object) -> tuple[()]:
        return ()


def test_an_empty_fleet_is_said_beside_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    assert list_robots(FakeSession(), "rune/lab", OPEN, as_json=False) == 0
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "rune-hub: no robot is in the fleet rune/lab now\n")


def test_robots_are_listed_once_in_order(capsys: pytest.CaptureFixture[str]) -> None:
    tokens = ("rune/v1/rover/alive", "rune/v1/boat/alive", "rune/v1/rover/alive")
    assert list_robots(FakeSession(*tokens), "rune", OPEN, as_json=False) == 0
    said = capsys.readouterr()
    assert (said.out, said.err) == ("boat\nrover\n", "")


def test_a_certificate_that_the_router_does_not_list_may_be_why_a_fleet_looks_empty(
    capsys: pytest.CaptureFixture[str],
) -> None:
    who = Principal(name="ann", role=Role.OPERATE)
    assert list_robots(FakeSession(), "rune", GUARDED, as_json=False) == 0
    assert show_status(FakeSession(), "rune", GUARDED, who, as_json=False) == 0
    assert capsys.readouterr().err.count("the router's list lacks this certificate") == 2


def test_tokens_that_lie_hide_no_robot(capsys: pytest.CaptureFixture[str]) -> None:
    lies = ("rune/v1/a b/alive", "rune/v1/\x1b[2J/alive", f"rune/v1/{'x' * 900}/alive", "x")
    tokens = (*lies, "rune/v1/rover/alive", *(f"rune/v1/z{each}/alive" for each in range(10_000)))
    assert list_robots(FakeSession(*tokens), "rune", OPEN, as_json=False) == 0
    said = capsys.readouterr()
    assert said.out.splitlines()[0] == "rover"
    assert len(said.out.splitlines()) == MOST_LISTED
    assert said.err.splitlines() == [
        "rune-hub: 4 tokens left out, which cannot be the name of a robot",
        f"rune-hub: 9001 robots left out, as at most {MOST_LISTED} are listed",
    ]


def test_status_ends_though_many_robots_never_answer(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    seconds = itertools.count()
    monkeypatch.setattr("hub.doors.fleet.fleet_status.time.monotonic", lambda: float(next(seconds)))
    tokens = [f"rune/v1/ghost{each}/alive" for each in range(500)]
    who = Principal(name="ann", role=Role.OPERATE)
    assert show_status(FakeSession(*tokens), "rune", OPEN, who, as_json=False) == 0
    said = capsys.readouterr()
    assert 5 < said.out.count("does not answer") < 40
    assert "not asked, as the answers took more than 30 s" in said.err
