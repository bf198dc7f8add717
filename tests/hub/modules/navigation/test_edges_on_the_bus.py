"""Navigation publishes edges where beams to the ground meet none, and only for robots that roll."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.edges import EDGES, Edges
from hub.gcm.navigation import DRIVE_STATE
from hub.gcm.ranges import RANGES, RangeReadings, scan_of
from hub.modules.navigation.__main__ import Navigation
from hub.robots.robot_file import read_description
from tests.hub.modules.navigation.test_lost_place import AT_ORIGIN
from tests.hub.modules.timed_bus import TimedBus

ROBOT_FILE = """
name = "cart"
kind = "simulated-wheels"
[limits]
heave = {heave}
[[range]]
name = "floor"
kind = "laser"
beams = 5
first_deg = -20
spread_deg = 40
forward = 0.2
height = 0.4
pitch_deg = 45
farthest = {farthest}
"""


def published(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, measured: float, **values: float
) -> tuple[list[Edges], list[str]]:
    """The edges and the names of problems after a second in which all beams measure this [m]."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    path = tmp_path / "robot.toml"
    path.write_text(ROBOT_FILE.format(**{"heave": 0.0, "farthest": 3.0} | values))
    robot, problems = read_description(path)
    assert not problems
    bus = TimedBus(monkeypatch)
    Navigation(bus, robot)  # type: ignore[arg-type]
    (group,) = robot.body.ranges
    for _ in range(12):
        bus.send(DRIVE_STATE, AT_ORIGIN, "driver")
        ranges = np.full(group.beams, measured, np.float32)
        bus.send(RANGES, RangeReadings(scans=(scan_of(group, ranges, bus.now),)), "driver")
        bus.wait(0.1)
    edges = [each for _, name, each in bus.published if name == EDGES.name]
    said = [each for _, name, each in bus.published if name == DIAGNOSTICS.name]
    return edges, [status.name for status in said[-1].status]


@pytest.mark.parametrize("measured", [1.2, math.inf])
def test_ground_that_is_missing_is_an_edge(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, measured: float
) -> None:
    edges, problems = published(tmp_path, monkeypatch, measured)
    assert problems == ["edge"]
    assert 1 <= len(edges) <= 4
    # Nothing is known of the ground before it, so it may begin at the robot's rim.
    assert {each.header.frame_id for each in edges} == {"map"}
    assert all(0.2 < cell.x < 0.3 for cell in edges[-1].cells)


@pytest.mark.parametrize(
    ("measured", "values"),
    [(0.56, {}), (math.inf, {"heave": 0.5}), (math.inf, {"farthest": 0.5}), (math.nan, {})],
    ids=["a floor", "a robot that flies", "beams that are too short", "no measurement"],
)
def test_no_edge_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, measured: float, values: dict[str, float]
) -> None:
    edges, problems = published(tmp_path, monkeypatch, measured, **values)
    assert edges == []
    assert "edge" not in problems
