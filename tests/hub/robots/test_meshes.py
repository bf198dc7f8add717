"""Meshes widen the outline of a URDF file, and those that cannot be read are named."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from hub.robots.meshes import mesh_points
from hub.robots.robot_file import read_description
from hub.robots.urdf import UrdfModel, read_urdf, urdf_model

CORNERS = np.array([(x, y, z) for x in (-0.1, 0.1) for y in (-0.4, 0.4) for z in (0.0, 0.3)])
"""A plough, 0.8 m wide [m]."""
ROBOT = """<robot name="plougher">
  <link name="base_link"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision>
  </link>
  <link name="plough"><collision><geometry>
    <mesh filename="FILE" scale="SCALE SCALE SCALE"/></geometry></collision></link>
  <joint name="p" type="fixed"><parent link="base_link"/><child link="plough"/>
    <origin xyz="0.5 0 0"/></joint>
</robot>"""
COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="s"><float_array id="a" count="24">POINTS</float_array>
      <technique_common><accessor source="#a" count="8" stride="3"/></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#s"/></vertices></mesh></geometry>
  </library_geometries>
  <library_visual_scenes><visual_scene id="w"><node id="n">
    <translate>0 0 100</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>
    <instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
</COLLADA>"""


def binary_stl(points: np.ndarray) -> bytes:
    triangles = b"".join(
        struct.pack("<12fH", 0, 0, 1, *one, *one, *one, 0) for one in points.tolist()
    )
    return bytes(80) + struct.pack("<I", len(points)) + triangles


def text_stl(points: np.ndarray) -> bytes:
    lines = "".join(
        f"      vertex {each[0]:g} {each[1]:g} {each[2]:g}\n" for each in points.tolist()
    )
    return f"solid plough\n facet normal 0 0 1\n  outer loop\n{lines}  endloop\n".encode()


def obj(points: np.ndarray) -> bytes:
    return b"".join(b"v %g %g %g\nvn 9 9 9\n" % tuple(each) for each in points.tolist())


def collada(points: np.ndarray) -> bytes:
    """The points, turned and narrowed by the node of the file [mm]."""
    inner = np.stack((points[:, 1] / 2.0, -points[:, 0], points[:, 2] - 0.1), axis=1) * 1000.0
    return COLLADA.replace("POINTS", " ".join(f"{each:.3f}" for each in inner.ravel())).encode()


def robot(file: str, scale: float = 1.0) -> str:
    return ROBOT.replace("FILE", file).replace("SCALE", str(scale))


def read(folder: Path, text: str) -> UrdfModel:
    path = folder / "robot.urdf"
    path.write_text(text)
    return read_urdf(path)


def size(model: UrdfModel) -> tuple[float, float, float]:
    """How far it reaches ahead, behind and to the left [m]."""
    x, y = np.array(model.footprint).T
    return x.max(), -x.min(), y.max()


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("plough.stl", binary_stl(CORNERS)),
        ("plough.STL", text_stl(CORNERS)),
        ("plough.obj", obj(CORNERS)),
        ("plough.dae", collada(CORNERS)),
    ],
)
def test_a_mesh_widens_the_outline(tmp_path: Path, name: str, file: bytes) -> None:
    (tmp_path / name).write_bytes(file)
    points = np.unique(mesh_points(tmp_path / name).round(4), axis=0)
    assert points == pytest.approx(CORNERS), "they come in the order of their coordinates"
    model = read(tmp_path, robot(name))
    assert model.fault == ""
    assert size(model) == pytest.approx((0.6, 0.1, 0.4), abs=0.03)
    assert size(model) >= (0.5999, 0.0999, 0.3999), "it is never smaller"


def test_the_scale_of_a_mesh_counts(tmp_path: Path) -> None:
    (tmp_path / "mm.stl").write_bytes(binary_stl(CORNERS * 1000.0))
    assert size(read(tmp_path, robot("mm.stl", 0.001)))[0] == pytest.approx(0.6, abs=0.03)


def test_a_package_is_found_above_the_file_and_in_the_folders_of_ros(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "share" / "carrier"
    (package / "meshes").mkdir(parents=True)
    (package / "meshes" / "p.stl").write_bytes(binary_stl(CORNERS))
    text = robot("package://carrier/meshes/p.stl")
    assert read(package / "meshes", text).fault == ""
    assert "'carrier' is not on this machine" in urdf_model(text, "robot_description", {}).fault
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}")
    assert urdf_model(text, "robot_description", {}).fault == ""
    for escaping in ("carrier/../../etc/p.stl", "../p.stl", "/etc/p.stl"):
        model = urdf_model(robot(f"package://{escaping}"), "robot_description", {})
        assert "no file of a package" in model.fault, escaping
    assert "on the robot" in urdf_model(robot("file:///etc/p.stl"), "robot_description", {}).fault


@pytest.mark.parametrize(
    ("name", "file", "why"),
    [
        ("p.stl", None, "cannot be read"),
        ("p.stl", binary_stl(CORNERS)[:-1], "cut off"),
        ("p.stl", text_stl(CORNERS * np.nan), "no places"),
        ("p.stl", b"solid a", "no points"),
        ("p.stl", b"solid a\nvertex a b c\n", "could not convert"),
        ("p.dae", b"<COLLADA", "is not XML"),
        ("p.dae", collada(CORNERS).replace(b"#g", b"#h"), "does not have"),
        ("p.dae", collada(CORNERS).replace(b"<rotate>0 0 1 90", b"<rotate>0 0 1"), "no sense"),
        ("p.dae", collada(CORNERS).replace(b"_geometry url", b"_node url"), "no points"),
        ("p.dae", collada(CORNERS).replace(b'_geometry url="#g"', b'_node url="#n"'), "circle"),
        ("p.ply", b"ply", "files .ply are not read"),
        ("p.stl", binary_stl(CORNERS * 1e5), "large"),
    ],
)
def test_a_mesh_that_cannot_be_read_is_named_and_gives_no_outline(
    tmp_path: Path, name: str, file: bytes | None, why: str
) -> None:
    if file is not None:
        (tmp_path / name).write_bytes(file)
    model = read(tmp_path, robot(name))
    assert "the outline lacks link 'plough' at [0.5, 0]" in model.fault
    assert why in model.fault
    assert model.reach == pytest.approx(0.5), "it reaches to the plough at least"


def test_a_link_without_collision_shapes_counts_by_its_visual_ones(tmp_path: Path) -> None:
    (tmp_path / "p.stl").write_bytes(binary_stl(CORNERS))
    text = robot("p.stl")
    end = "</collision></link>\n  <joint"
    visual = text.replace("<collision><geometry>\n", "<visual><geometry>\n").replace(
        "</geometry></collision></link>\n  <joint", "</geometry></visual></link>\n  <joint"
    )
    assert size(read(tmp_path, visual))[0] == pytest.approx(0.6, abs=0.03)
    missing = text.replace('filename="p.stl"', 'filename="q.stl"')
    both = missing.replace(
        end,
        '</collision><visual><geometry><box size="0.2 0.8 0.3"/></geometry></visual>'
        "</link>\n  <joint",
    )
    assert size(read(tmp_path, both))[0] == pytest.approx(0.6, abs=0.03)


@pytest.mark.parametrize(
    ("body", "faults"),
    [("", 1), ("radius = 0.7", 0), ("footprint = [[1,1],[-1,1],[-1,-1],[1,-1]]", 0)],
)
def test_a_robot_file_needs_another_outline_then(tmp_path: Path, body: str, faults: int) -> None:
    (tmp_path / "robot.urdf").write_text(robot("package://r/plough.stl"))
    path = tmp_path / "robot.toml"
    path.write_text(f'name = "r"\nkind = "r:KIND"\n[body]\nurdf = "robot.urdf"\n{body}\n')
    found, problems = read_description(path)
    assert len(problems) == faults
    if faults:
        assert "lacks link 'plough'" in str(problems)
        assert "give 'footprint' or 'radius'" in str(problems)
    else:
        assert found.radius >= 0.7
