"""Withheld control beside freezes and pauses: what a pause ends, and what waits."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rune_study.plan.steps import Step
from rune_study.session.interruptions import Interruptions
from rune_study.session.journal import Journal
from rune_study.session.schedule import FREEZE, WITHHOLD, Due, Schedule
from tests.study.studies import study_of


class Console:
    """The conducted console's side of the socket."""

    def __init__(self) -> None:
        self.orders: list[str] = []
        self.unread: list[dict[str, Any]] = []

    def order(self, do: str, **_: object) -> None:
        self.orders.append(do)

    def reports(self) -> Iterator[dict[str, Any]]:
        unread, self.unread = self.unread, []
        return iter(unread)

    def wait_for(self, _: str) -> bool:
        return True


@pytest.fixture
def console() -> Console:
    return Console()


@pytest.fixture
def schedule() -> Schedule:
    return Schedule(Step(kind="trial", freezes=(4.0,), withheld=(3.0,)), 0.0)


@pytest.fixture
def parts(tmp_path: Path, console: Console) -> Iterator[tuple[Interruptions, Journal]]:
    study = study_of(tmp_path, "[neglect]\n[trial]\nseconds = 600\n")
    robot = SimpleNamespace(pause=lambda **_: None, low_for=lambda _: 99.0)
    stage: Any = SimpleNamespace(console=console, robots=[robot])
    with Journal.of(study, 1) as journal:
        yield Interruptions(study, Step(kind="trial", trial=1), 1, journal, stage), journal


PROBE = Due(at=3.0, what=WITHHOLD, number=1)


def test_a_freeze_waits_until_control_is_back(schedule: Schedule) -> None:
    (probe,) = schedule.due(3.0)
    assert probe == PROBE
    assert schedule.due(5.0, withheld=True) == []
    (freeze,) = schedule.due(6.0)
    assert freeze == Due(at=4.0, what=FREEZE, number=1)
    assert schedule.due(9.0) == []


def test_a_pause_ends_withheld_control_and_is_no_drop(
    parts: tuple[Interruptions, Journal], console: Console, schedule: Schedule
) -> None:
    interruptions, journal = parts
    interruptions.begin(PROBE, schedule)
    interruptions.withheld()
    assert interruptions.withholds
    interruptions.pause(schedule)
    interruptions.go_on(schedule)
    assert not interruptions.withholds
    interruptions.look(1e9)
    allowed = [each.data["why"] for each in journal.records if each.what == "allowed"]
    assert allowed == ["pause"]
    assert console.orders == ["withhold", "say", "allow", "withdraw", "return"]


def test_withheld_control_that_waits_for_quiet_waits_through_a_pause(
    parts: tuple[Interruptions, Journal], console: Console, schedule: Schedule
) -> None:
    interruptions, _ = parts
    interruptions.begin(PROBE, schedule)
    interruptions.pause(schedule)
    assert console.orders == ["withhold", "allow", "withdraw"]
    interruptions.go_on(schedule)
    assert console.orders[-2:] == ["return", "withhold"]
    assert not interruptions.withholds


def test_a_report_from_before_a_pause_does_not_withhold_after_it(
    parts: tuple[Interruptions, Journal], console: Console, schedule: Schedule
) -> None:
    interruptions, _ = parts
    interruptions.begin(PROBE, schedule)
    console.unread.append({"event": "withheld"})
    interruptions.pause(schedule)
    assert console.unread == []
