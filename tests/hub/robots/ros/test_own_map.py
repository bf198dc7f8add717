"""The robot's own map: it counts where its frames place it, with its changes."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from hub.modules.mapping.grid import OccupancyGrid
from hub.modules.mapping.painted_map import PaintedMap
from hub.robots.ros.own_map import RosMap
from hub.robots.ros_table import RosTable
from tests.hub.robots.ros.test_body import transforms
from tests.support.memory_ros_line import MemoryLine

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types
STAMP = TYPES["builtin_interfaces/msg/Time"](0, 0)
HEADER = TYPES["std_msgs/msg/Header"](STAMP, "map")


def grid(cells, x=-1.0, y=-0.5, resolution=0.1, turn=0.0):
    point = TYPES["geometry_msgs/msg/Point"](x, y, 0.0)
    turned = TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, turn, (1.0 - turn * turn) ** 0.5)
    origin = TYPES["geometry_msgs/msg/Pose"](point, turned)
    height, width = cells.shape
    info = TYPES["nav_msgs/msg/MapMetaData"](STAMP, resolution, width, height, origin)
    kind = "nav_msgs/msg/OccupancyGrid"
    message = TYPES[kind](HEADER, info, cells.reshape(-1).astype(np.int8))
    return bytes(STORE.serialize_cdr(message, kind))


class Scene:
    def __init__(self):
        self.line = MemoryLine()
        self.line.topic("/map", "nav_msgs/msg/OccupancyGrid")
        self.line.topic("/tf", "tf2_msgs/msg/TFMessage")
        self.map = RosMap(self.line, RosTable(map="/map"))
        self.cells = np.full((20, 30), -1, np.int8)
        self.cells[5:15, 5:25] = 0
        self.cells[5, 5:25] = 100

    def give(self, **more):
        self.line.give("/map", grid(self.cells, **more), 1.0)

    def place(self):
        self.line.give("/tf", transforms(("map", "odom", 0.5, 0.0)), 1.0)


@pytest.fixture
def scene():
    return Scene()


def test_it_counts_as_soon_as_its_place_is_known_and_once(scene):
    scene.give()
    assert scene.map.take() is None
    assert "no frames join it" in scene.map.fault
    scene.place()
    found = scene.map.take()
    assert not scene.map.fault
    assert (found.cells == scene.cells).all()
    assert (found.resolution, found.origin_x, found.origin_y) == pytest.approx((0.1, -1.0, -0.5))
    assert scene.map.take() is None
    assert "/tf" not in scene.line.takers
    scene.give()
    assert scene.map.take() is not None


def test_a_turned_one_is_used_also_with_its_changes(scene):
    scene.place()
    scene.give(turn=0.5**0.5)  # a quarter to the left
    found = scene.map.take()
    assert not scene.map.fault
    assert found.cells.shape == (20, 10)
    assert (found.cells[:, -1] == 100).all()
    assert (found.origin_x, found.origin_y) == pytest.approx((-2.5, 0.0), abs=1e-6)


def test_one_that_makes_no_sense_is_named_and_the_last_stays(scene):
    scene.place()
    scene.give()
    before = scene.map.take()
    scene.give(resolution=0.0)
    assert scene.map.take() is None
    assert "no size of its cells" in scene.map.fault
    assert before is not None


def test_it_is_painted_in_the_place_of_scans_also_after_the_grid_was_cleared(scene):
    ours = OccupancyGrid(0.05, 10.0)
    painted = PaintedMap(scene.map, ours)
    scene.place()
    assert not painted.follow(1.0)
    scene.give()
    assert painted.follow(2.0)
    whole = ours.whole()
    assert (whole.cells > 50).any()
    assert (whole.cells == 0).any() or ((whole.cells >= 0) & (whole.cells < 50)).any()
    assert painted.problems().status == ()
    scene.give(resolution=0.0)
    assert not painted.follow(3.0)
    assert [each.name for each in painted.problems().status] == ["own map"]
    ours.clear()
    painted.paint()
    assert (ours.whole().cells == whole.cells).all()
    painted.close()
    assert not scene.line.state.up
