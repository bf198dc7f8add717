"""What the hub takes from a URDF file."""

from __future__ import annotations

import math
import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import RobotFileError
from hub.gcm.body import MOST_CORNERS
from hub.robots.robot_file import read_description
from hub.robots.urdf import read_urdf

BOX = '<collision><geometry><box size="0.6 0.4 0.2"/></geometry></collision>'
ROBOT = f"""<?xml version="1.0"?>
<robot name="carrier">
  <link name="base_footprint"/>
  <link name="base_link">{BOX}</link>
  <link name="mast"/>
  <link name="laser"/>
  <joint name="a" type="fixed"><parent link="base_footprint"/><child link="base_link"/>
    <origin xyz="0 0 0.1"/></joint>
  <joint name="b" type="revolute"><parent link="base_link"/><child link="mast"/>
    <origin xyz="0.2 0 0.5" rpy="0 0 1.5707963267948966"/></joint>
  <joint name="c" type="fixed"><parent link="mast"/><child link="laser"/>
    <origin xyz="0.1 0 0" rpy="0 0.5 0"/></joint>
</robot>"""


def written(folder: Path, text: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(text)
    return path


def test_frames_count_from_the_ground_and_the_outline_is_that_of_the_shapes(
    tmp_path: Path,
) -> None:
    model = read_urdf(written(tmp_path, ROBOT))
    assert set(model.footprint) == {(0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)}
    laser = model.frames["laser"]
    assert (laser.x, laser.y, laser.z) == pytest.approx((0.2, 0.1, 0.6))
    assert (laser.roll, laser.pitch, laser.yaw) == pytest.approx((0.0, 0.5, math.pi / 2))


def test_a_robot_file_places_its_sensors_in_frames_of_the_urdf_file(tmp_path: Path) -> None:
    written(tmp_path, ROBOT)
    path = tmp_path / "robot.toml"
    path.write_text(
        'name = "carrier"\nkind = "carrier:KIND"\n[body]\nurdf = "robot.urdf"\n'
        '[[range]]\nname = "scan"\nparent = "laser"\nkind = "laser"\nfarthest = 8.0\n'
    )
    robot, problems = read_description(path)
    assert not problems
    assert robot.radius == pytest.approx(math.hypot(0.3, 0.2))
    assert [frame.name for frame in robot.body.frames] == ["laser", "scan"], "only what is used"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("<robot", "is not XML"),
        ("<robots/>", "not <robot>"),
        ("<robot/>", "it has 0 links"),
        ('<robot><link name="a"/><link name="b"/></robot>', "2 links have no parent"),
        (ROBOT.replace('link="mast"', 'link="mats"', 1), "is no link"),
        (ROBOT.replace('<parent link="base_link"/>', '<parent link="laser"/>'), "circle of joints"),
        (ROBOT.replace("0.6 0.4 0.2", "0.6 0.4 nan"), "size of <box> is not 3 numbers"),
        (ROBOT.replace("0.6 0.4 0.2", "0.6 -0.4 0.2"), "size of <box> is not 3 numbers from 0 to"),
        (ROBOT.replace('<link name="mast"/>', '<link name="laser"/>'), "the name of another link"),
        (ROBOT.replace('xyz="0 0 0.1"', 'xyz="0 0 1e9"'), "xyz of <origin> is not 3 numbers"),
    ],
)
def test_a_file_that_is_no_robot_is_refused(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(RobotFileError, match=reason):
        read_urdf(written(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('<robot><link name="a"/></robot>', "no link has a box"),
        (ROBOT.replace("0.6 0.4 0.2", "60 40 20"), r"reaches 30 m from \[0, 0\]; at most 5 m"),
        (ROBOT.replace("0.6 0.4 0.2", "0.6 0 0.2"), "is not a list of the corners"),
        (ROBOT.replace('xyz="0 0 0.1"', 'xyz="0.4 0 0.1"'), r"does not enclose \[0, 0\]"),
        (
            ROBOT.replace("<box", "<blob"),
            r"lacks link 'base_link' at \[0, 0\] \(<blob> is not read",
        ),
    ],
)
def test_why_an_outline_is_not_known(tmp_path: Path, text: str, reason: str) -> None:
    assert re.search(reason, read_urdf(written(tmp_path, text)).fault)


def test_a_file_of_many_shapes_takes_little_memory(tmp_path: Path) -> None:
    def most_bytes(text: str) -> int:
        path = written(tmp_path, text)
        tracemalloc.start()
        read_urdf(path)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    sphere = '<collision><geometry><sphere radius="0.3"/></geometry></collision>'
    most_bytes(ROBOT)  # imports what it needs
    assert most_bytes(ROBOT.replace(BOX, 3000 * sphere)) < most_bytes(ROBOT) + 1_000_000


def test_entities_are_not_resolved(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("0.5")
    text = f'<!DOCTYPE robot [<!ENTITY a SYSTEM "{secret}">]>' + ROBOT.partition("?>")[2].replace(
        'name="mast"/>', 'name="mast">&a;</link>'
    )
    assert read_urdf(written(tmp_path, text)).frames["mast"].z == pytest.approx(0.6)


@given(
    radius=st.floats(0.05, 2.0),
    length=st.floats(0.05, 2.0),
    place=st.tuples(*[st.floats(-0.015, 0.015)] * 2),
    turned=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
def test_the_outline_encloses_a_cylinder_and_is_little_larger(
    tmp_path_factory: pytest.TempPathFactory,
    radius: float,
    length: float,
    place: tuple[float, float],
    turned: tuple[float, float, float],
) -> None:
    x, y = place
    text = (
        '<robot><link name="base_link"><collision>'
        f'<origin xyz="{x} {y} 0" rpy="{turned[0]} {turned[1]} {turned[2]}"/>'
        f'<geometry><cylinder radius="{radius}" length="{length}"/></geometry>'
        "</collision></link></robot>"
    )
    corners = np.array(
        read_urdf(written(tmp_path_factory.mktemp("urdf"), text)).footprint, np.float64
    )
    assert len(corners) <= MOST_CORNERS
    angles = np.linspace(0.0, math.tau, 100)
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    offsets = ((corners - place) @ normals.T).max(axis=0)
    # The axis of the cylinder; its support is half the length along it and the radius across it.
    roll, pitch, yaw = turned
    axis = np.array(
        [
            math.cos(yaw) * math.sin(pitch) * math.cos(roll) + math.sin(yaw) * math.sin(roll),
            math.sin(yaw) * math.sin(pitch) * math.cos(roll) - math.cos(yaw) * math.sin(roll),
        ]
    )
    along = np.abs(normals @ axis)
    support = along * length / 2 + radius * np.sqrt(np.maximum(1.0 - along**2, 0.0))
    assert (offsets > support - 2e-4).all()
    assert (offsets < support + 0.1 * (radius + length / 2)).all()
