"""A robot that maps its surroundings by itself, and an operator who comes first."""

from __future__ import annotations

import os
import signal
from contextlib import ExitStack
from pathlib import Path

import pytest
from PIL import Image
from ruamel.yaml import YAML

from hub.gcm import mapping, navigation
from hub.gcm.autonomy import Behaviour, DrivingMode, Phase
from hub.gcm.common import COMMON_RESULT
from hub.gcm.geometry import TwistStamped
from hub.gcm.navigation import Task
from tests.system.exploring_hub import Tour


@pytest.fixture
def tour(stack: ExitStack, tmp_path: Path) -> Tour:
    return Tour(stack, tmp_path)


def test_it_explores_and_the_operators_stick_takes_over_at_once(tour: Tour) -> None:
    assert tour.state.behaviour is Behaviour.HOLD
    start = tour.truth
    known = (tour.grid().cells >= 0).sum()
    tour.ask(Behaviour.EXPLORE)
    tour.observer.wait(
        lambda: abs(tour.truth.x - start.x) + abs(tour.truth.y - start.y) > 0.5, 30.0
    )
    assert tour.state.pilot is DrivingMode.AUTONOMY
    assert tour.state.frontier_m > 1.0
    tour.observer.wait(lambda: (tour.grid().cells >= 0).sum() > 1.1 * known, 30.0)

    turn = TwistStamped.planar(0.0, 0.3)

    def push() -> bool:
        tour.observer.client.publish(navigation.VELOCITY_COMMAND, turn)
        return tour.state.behaviour is Behaviour.HOLD

    tour.observer.client.publish(navigation.VELOCITY_COMMAND, TwistStamped())
    tour.observer.wait(push, 10.0, "it does not yield")
    assert tour.state.why == "the operator took over"
    assert tour.state.pilot is DrivingMode.OPERATOR
    statuses = tour.observer.seen[navigation.NAVIGATION_STATUS.name]
    tour.observer.wait(lambda: push() and statuses[-1][1].task is Task.CANCELLED, 10.0)

    # The stick is let go: the robot stands, and nobody sends it on.
    tour.observer.client.publish(navigation.VELOCITY_COMMAND, TwistStamped())
    tour.observer.wait(lambda: tour.state.pilot is DrivingMode.NOBODY, 10.0)
    tour.observer.wait(lambda: tour.truth.commanded_linear == 0.0, 10.0)
    assert tour.state.behaviour is Behaviour.HOLD
    assert tour.truth.contacts == 0


@pytest.mark.parametrize("name", ["navigation", "driver"])
def test_it_waits_for_a_module_that_was_away_and_goes_on(tour: Tour, name: str) -> None:
    def moved(least: float) -> bool:
        return abs(tour.truth.x - before.x) + abs(tour.truth.y - before.y) > least

    before = tour.truth
    tour.ask(Behaviour.EXPLORE)
    tour.observer.wait(lambda: moved(0.5), 30.0)
    os.kill(tour.hub.pids[name], signal.SIGSTOP)
    try:
        tour.observer.wait(lambda: tour.state.phase is Phase.WAITING, 10.0, "it does not wait")
        assert tour.state.why.startswith("waits: ")
    finally:
        os.kill(tour.hub.pids[name], signal.SIGCONT)
    before = tour.truth
    tour.observer.wait(lambda: moved(0.5), 30.0, lambda: f"it does not go on: {tour.state}")
    assert tour.state.behaviour is Behaviour.EXPLORE
    assert tour.state.phase is Phase.ACTIVE

    # A stop of somebody ends it, and nothing has it go on.
    tour.observer.client.publish(navigation.STOP, navigation.Stop(reason="lunch"))
    tour.observer.wait(lambda: tour.state.phase is Phase.STOPPED, 10.0, "it does not end")
    assert tour.state.why == "stopped: lunch"
    assert tour.truth.contacts == 0


@pytest.mark.soak
def test_a_whole_arena_is_mapped_without_a_contact(tour: Tour, tmp_path: Path) -> None:
    tour.explore(1200.0)
    assert tour.state.why.startswith("explored: ")
    assert tour.truth.contacts == 0
    assert tour.mapped_share() > 0.9

    save = mapping.MapCommand(order=mapping.MapOrder.SAVE, name="arena")
    result = tour.observer.client.query_response(
        mapping.MAP_COMMAND, save, COMMON_RESULT, timeout=10.0
    )
    assert result.done == 1, result.text
    described = YAML(typ="safe").load(tmp_path / "maps" / "arena.yaml")
    grid = tour.grid()
    assert described["resolution"] == grid.resolution
    with Image.open(tmp_path / "maps" / described["image"]) as picture:
        assert picture.format == "PPM"
        assert picture.size == (grid.width_cells, grid.height_cells)
        # 0 is occupied, 254 free, 205 unknown, as map_server writes them.
        assert set(picture.tobytes()) == {0, 205, 254}
