"""The mapping module in a running hub: the map, the points, and their files."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hub.errors import HandlerFailedError
from hub.gcm import map_coding, mapping, navigation
from hub.gcm.common import COMMON_RESULT, REQUEST_DATA, CommonResult, RequestData
from hub.gcm.geometry import TwistStamped
from tests.support.command_line import run
from tests.system.harness import HubProcess, Observer, robot_file

WHOLE = mapping.MapRequest(x=math.nan)
TIMEOUT = 10.0


HUB = {"arena": "yellow", "modules": ("driver", "navigation", "mapping")}


@pytest.fixture(scope="module")
def lasting_watch(lasting_hub: HubProcess) -> Iterator[Observer]:
    definitions = navigation.GROUND_TRUTH, mapping.INTEREST_POINTS
    with closing(Observer(lasting_hub.endpoint, *definitions)) as observer:
        yield observer


@pytest.fixture
def watch(lasting_watch: Observer) -> Observer:
    """Sees ground truth and interest points, of which there are none; much is mapped."""
    for point in points(lasting_watch):
        lasting_watch.client.publish(mapping.POINT_COMMAND, remove(point.number))
    lasting_watch.wait(lambda: not points(lasting_watch), 5.0, "points stay")
    lasting_watch.wait(lambda: known(lasting_watch) > 500, 10.0, "nothing is mapped")
    return lasting_watch


def map_of(watch: Observer, request: mapping.MapRequest = WHOLE) -> tuple[mapping.Map, Any]:
    found = watch.client.query_response(mapping.MAP_REQUEST, request, mapping.MAP, timeout=TIMEOUT)
    cells = map_coding.decode(found.data, found.height_cells, found.width_cells)
    return found, cells


def known(watch: Observer) -> int:
    """Cells of which something is known."""
    return int((map_of(watch)[1] >= 0).sum())


def farthest(watch: Observer) -> float:
    """Where the picture of the whole map ends [m]."""
    found, _ = map_of(watch)
    return found.origin_x + found.width_cells * found.resolution


def order(watch: Observer, what: mapping.MapOrder, name: str = "") -> CommonResult:
    command = mapping.MapCommand(order=what, name=name)
    return watch.client.query_response(mapping.MAP_COMMAND, command, COMMON_RESULT, timeout=TIMEOUT)


def points(watch: Observer) -> tuple[mapping.InterestPoint, ...]:
    newest: mapping.InterestPoints = watch.seen[mapping.INTEREST_POINTS.name][-1][1]
    return newest.points


def mark(x: float, **fields: Any) -> mapping.PointCommand:
    empty = np.empty(0, np.uint8)
    point = mapping.InterestPoint(
        kind=mapping.PointKind.VICTIM, x=x, y=0.5, thumbnail=empty, **fields
    )
    return mapping.PointCommand(point=point)


def remove(number: int) -> mapping.PointCommand:
    point = mark(0.0, number=number).point
    return mapping.PointCommand(action=mapping.PointAction.REMOVE, point=point)


def test_the_map_grows_where_the_robot_drives_and_comes_in_windows(watch: Observer) -> None:
    found, before = map_of(watch)
    assert found.resolution == 0.05
    assert found.stamp > 0.0
    assert (before >= 65).any()
    start = watch.truth
    turns = 0

    def drive() -> bool:
        nonlocal turns
        turns += 1
        truth: navigation.GroundTruth = watch.history[-1][1]
        # Neutral comes first, and again where commands of a busy machine fell silent.
        neutral = truth.commanded_linear == 0.0 and turns % 10 == 1
        velocity = TwistStamped.planar(0.0 if neutral else 0.3, 0.0)
        watch.client.publish(navigation.VELOCITY_COMMAND, velocity)
        return truth.y - start.y > 0.8

    watch.wait(drive, 30.0, "it does not drive")
    watch.client.publish(navigation.VELOCITY_COMMAND, TwistStamped())
    watch.wait(lambda: known(watch) > (before >= 0).sum() + 500, 5.0, "the map does not grow")
    window = mapping.MapRequest(x=0.5, y=0.0, width=1.0, height=0.5)
    part, cells = map_of(watch, window)
    assert cells.shape == (10, 20)
    assert (part.origin_x, part.origin_y) == pytest.approx((0.0, -0.25))
    assert (cells[:, :15] >= 0).mean() > 0.5
    with pytest.raises(HandlerFailedError, match="no part of the map"):
        map_of(watch, mapping.MapRequest(x=500.0, y=0.0))


def test_points_are_told_to_all_when_they_change_and_on_request(watch: Observer) -> None:
    watch.client.publish(mapping.POINT_COMMAND, mark(2.5, note="waves", uncertainty=0.2))
    watch.wait(lambda: points(watch), 5.0, "the point is not told")
    (point,) = points(watch)
    assert (point.x, point.note, point.uncertainty) == (2.5, "waves", 0.2)
    assert point.by
    assert point.stamp > 1e9
    watch.client.publish(mapping.POINT_COMMAND, mark(math.nan))
    watch.client.publish(mapping.POINT_COMMAND, mark(3.5, number=point.number, by="Bob"))
    changed = mark(3.5, number=point.number, by="Ada", version=point.version)
    watch.client.publish(mapping.POINT_COMMAND, changed)
    watch.wait(lambda: points(watch)[0].x == 3.5, 5.0, "the point is not replaced")
    assert (len(points(watch)), points(watch)[0].by) == (1, "Ada")
    history = watch.seen[mapping.INTEREST_POINTS.name]
    told = len(history)
    watch.client.publish(REQUEST_DATA, RequestData(message=mapping.INTEREST_POINTS.name))
    # Sooner than the five seconds after which they come anyway.
    watch.wait(lambda: len(history) > told, 3.0, "they are not told on request")
    watch.client.publish(mapping.POINT_COMMAND, remove(point.number))
    watch.wait(lambda: not points(watch), 5.0, "the point is not removed")


def test_a_map_is_saved_loaded_and_cleared(watch: Observer, lasting_hub: HubProcess) -> None:
    watch.client.publish(mapping.POINT_COMMAND, mark(2.5))
    watch.wait(lambda: points(watch), 5.0, "the point is not told")
    saved = order(watch, mapping.MapOrder.SAVE, "office")
    assert saved.done == 1, saved.text
    described = lasting_hub.log.parent / "maps" / "office.yaml"
    image = Image.open(described.with_suffix(".pgm"))
    assert {0, 205, 254} == set(np.unique(np.asarray(image)).tolist())
    elsewhere = re.sub(r"origin: .*", "origin: [15.0, 15.0, 0.0]", described.read_text())
    described.write_text(elsewhere)
    loaded = order(watch, mapping.MapOrder.LOAD, "office")
    assert loaded.done == 1, loaded.text
    assert farthest(watch) > 15.0
    assert len(points(watch)) == 1
    assert order(watch, mapping.MapOrder.CLEAR).done == 1
    assert farthest(watch) < 10.0
    assert len(points(watch)) == 1
    for name in ("../office", "nowhere"):
        refused = order(watch, mapping.MapOrder.LOAD, name)
        assert refused.done == 0
        assert name in refused.text
    assert "mapping was ended" not in lasting_hub.log.read_text()


def test_a_map_of_too_many_cells_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    text = robot_file()
    robot.write_text(text.replace("[mapping]", "[mapping]\nsize = 1000.0\nresolution = 0.01"))
    done = run("hub.modules.mapping", "--robot", str(robot), "--describe")
    assert done.returncode == 2
    assert "more than 4096 cells" in done.stderr
