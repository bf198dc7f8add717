"""Saved maps: as other programs read them, and what is refused when they are read."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from PIL import Image
from ruamel.yaml import YAML

from hub.errors import MapFileError
from hub.gcm.mapping import InterestPoint, PointKind
from hub.gcm.occupancy_map import OccupancyMap
from hub.missions import point_file, ros_map, storage
from hub.missions.points import MAX_POINTS
from tests.support.cases import for_each

PICTURE = OccupancyMap(
    cells=np.array([[-1, 0, 25], [30, 65, 100]], np.int8),
    resolution=0.05,
    origin_x=-1.25,
    origin_y=3.5,
)
HEADER = ros_map.decode_yaml(ros_map.encode_yaml(PICTURE, "office.pgm"))
THUMBNAIL = np.arange(256, dtype=np.uint8)
POINTS = (
    InterestPoint(
        number=3, kind=PointKind.VICTIM, x=1.25, y=-0.5, uncertainty=0.125, distance=2.5,
        stamp=1e9, by="Ada",
        note="sitzt; „Hilfe“\n", thumbnail=THUMBNAIL, version=4, kept=1,
    ),
    InterestPoint(
        number=8, kind=PointKind.LANDMARK, x=0.1, y=1 / 3, height=1.25, stamp=1.5e9,
        thumbnail=THUMBNAIL[:0], version=1, kept=1,
    ),
)  # fmt: skip


def same(first: InterestPoint, second: InterestPoint) -> bool:
    values = [dataclasses.asdict(point) for point in (first, second)]
    return str(values[0]) == str(values[1])


def yaml_with(**values: str) -> bytes:
    """The description with other values; an empty one leaves the key out."""
    lines = ros_map.encode_yaml(PICTURE, "office.pgm").decode().splitlines()
    kept = [line for line in lines if line.split(":")[0] not in values]
    return "\n".join(kept + [f"{key}: {value}" for key, value in values.items() if value]).encode()


def test_other_programs_see_walls_black_and_the_largest_y_on_top() -> None:
    image = Image.open(io.BytesIO(ros_map.encode_pgm(PICTURE)))
    assert (image.mode, image.size) == ("L", (3, 2))
    assert np.asarray(image).tolist() == [[205, 0, 0], [205, 254, 254]]


def test_other_programs_read_the_description_as_map_server_does() -> None:
    values = YAML(typ="safe").load(ros_map.encode_yaml(PICTURE, "office.pgm"))
    assert values == {
        "image": "office.pgm",
        "resolution": 0.05,
        "origin": [-1.25, 3.5, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
        "mode": "trinary",
    }
    assert all(isinstance(value, float) for value in values["origin"])


@given(
    cells=arrays.arrays(np.int8, (5, 7), elements=st.integers(-1, 100)),
    resolution=st.floats(0.01, 1.0), x=st.floats(-999, 999), y=st.floats(-999, 999),
)  # fmt: skip
def test_a_map_is_read_as_it_was_written(cells: Any, resolution: float, x: float, y: float) -> None:
    picture = OccupancyMap(cells=cells, resolution=resolution, origin_x=x, origin_y=y)
    header = ros_map.decode_yaml(ros_map.encode_yaml(picture, "m.pgm"))
    read = ros_map.picture_of(header, ros_map.decode_pgm(ros_map.encode_pgm(picture)))
    expected = np.where(cells < 0, -1, np.where(cells <= 25, 0, np.where(cells >= 65, 100, -1)))
    assert np.array_equal(read.cells, expected)
    assert read.resolution == pytest.approx(resolution, abs=1e-6)
    assert (read.origin_x, read.origin_y) == pytest.approx((x, y), abs=1e-6)


@given(
    shades=arrays.arrays(np.uint8, (3, 4)),
    negate=st.booleans(), free=st.floats(0.0, 0.5), occupied=st.floats(0.51, 1.0),
)  # fmt: skip
def test_any_shade_is_read_as_map_server_reads_it(
    shades: Any, free: float, occupied: float, *, negate: bool
) -> None:
    """http://wiki.ros.org/map_server, value interpretation."""
    header = dataclasses.replace(HEADER, negate=negate, free_thresh=free, occupied_thresh=occupied)
    cells = ros_map.picture_of(header, shades).cells
    for row in range(3):
        for column in range(4):
            shade = int(shades[2 - row, column])
            probability = shade / 255.0 if negate else 1.0 - shade / 255.0
            expected = 100 if probability > occupied else 0 if probability < free else -1
            assert cells[row, column] == expected


def test_descriptions_of_other_programs_are_read() -> None:
    nav2 = (
        b"# made elsewhere\n---\nimage: 'office.pgm'\nmode: trinary\nresolution: 0.05\n"
        b"origin: [-1.25, 3.5, 0]  # metres\nnegate: 0\noccupied_thresh: .65\n"
        b"free_thresh: 1.96e-1\nfloor: 3\n"
    )
    assert ros_map.decode_yaml(nav2) == HEADER


def test_a_turned_picture_is_turned_onto_the_axes() -> None:
    header = ros_map.decode_yaml(yaml_with(origin="[1, 2, 1.5707963267948966]", resolution="0.5"))
    shades = np.array([[254, 254, 0]], np.uint8)
    read = ros_map.picture_of(header, shades)
    assert read.cells.tolist() == [[0], [0], [100]]
    assert (read.origin_x, read.origin_y) == pytest.approx((0.5, 2.0))


def test_a_picture_of_pillow_is_read() -> None:
    shades = np.arange(12, dtype=np.uint8).reshape(3, 4)
    file = io.BytesIO()
    Image.fromarray(shades).save(file, format="PPM")
    assert np.array_equal(ros_map.decode_pgm(file.getvalue()), shades)


@for_each(
    ("raw", "why"),
    [
        (b"", "binary PGM"),
        (b"P2\n1 1\n255\n0", "binary PGM"),
        (b"P5 2 2 255 abc", "has 3 bytes"),
        (b"P5 2 2 255 abcde", "has 5 bytes"),
        (b"P5 0 4 255 ", "between 1 and"),
        (b"P5 99999999 99999999 255 ab", "between 1 and"),
        (b"P5 1 1 65535 ab", "white is 65535"),
        (b"P5 " + b"#" * 5000, "binary PGM"),
        (b"P5 111111111 1 255 a", "binary PGM"),
    ],
)
def test_a_wrong_picture_is_refused(raw: bytes, why: str) -> None:
    with pytest.raises(MapFileError, match=why):
        ros_map.decode_pgm(raw)


@for_each(
    ("raw", "why"),
    [
        (yaml_with(resolution=""), "resolution ''"),
        (yaml_with(resolution="0"), "resolution '0'"),
        (yaml_with(resolution="nan"), "resolution 'nan'"),
        (yaml_with(resolution="1e999"), "resolution"),
        (yaml_with(origin="[1, 2]"), "origin"),
        (yaml_with(origin="[1, 2, nan]"), "origin"),
        (yaml_with(origin="[.inf, 2, 0]"), "origin"),
        (yaml_with(origin="[9e9, 2, 0]"), "origin"),
        (yaml_with(negate="maybe"), "negate"),
        (yaml_with(free_thresh="0.7"), "free_thresh is not below"),
        (yaml_with(mode="raw"), "only trinary"),
        (yaml_with() + b"\nimage: b.pgm", "no new 'key: value'"),
        (yaml_with() + b"\n- a list", "no new 'key: value'"),
        (b"\xff", "UTF-8"),
        (b"a" * 10_001, "larger than"),
    ],
)
def test_a_wrong_description_is_refused(raw: bytes, why: str) -> None:
    with pytest.raises(MapFileError, match=why):
        ros_map.decode_yaml(raw)


@given(st.binary(max_size=300), st.integers(0, 200), st.binary(max_size=3))
def test_damaged_files_raise_only_our_own_error(raw: bytes, place: int, change: bytes) -> None:
    good = [
        ros_map.encode_pgm(PICTURE),
        ros_map.encode_yaml(PICTURE, "m.pgm"),
        point_file.encode_points(POINTS),
    ]
    readers = [ros_map.decode_pgm, ros_map.decode_yaml, point_file.decode_points]
    for file, read in zip(good, readers, strict=True):
        for damaged in (raw, file[:place], file[:place] + change + file[place + len(change) :]):
            with contextlib.suppress(MapFileError):
                read(damaged)


def test_points_are_read_as_they_were_written() -> None:
    read = point_file.decode_points(point_file.encode_points(POINTS))
    assert len(read) == 2
    assert all(same(*pair) for pair in zip(read, POINTS, strict=True))


def test_points_are_geojson() -> None:
    collection = json.loads(point_file.encode_points(POINTS))
    assert collection["type"] == "FeatureCollection"
    feature = collection["features"][0]
    assert feature["geometry"] == {"type": "Point", "coordinates": [1.25, -0.5]}
    assert feature["properties"]["kind"] == "victim"
    assert feature["properties"]["note"] == POINTS[0].note
    assert feature["properties"]["uncertainty"] == 0.125
    assert feature["properties"]["distance"] == 2.5
    unsure = collection["features"][1]["properties"]
    assert unsure["uncertainty"] is unsure["distance"] is None


def test_points_of_a_file_that_says_nothing_of_how_sure_they_are_are_read() -> None:
    collection = json.loads(point_file.encode_points(POINTS))
    for feature in collection["features"]:
        del feature["properties"]["uncertainty"], feature["properties"]["distance"]
    read = point_file.decode_points(json.dumps(collection).encode())
    assert [point.number for point in read] == [3, 8]
    assert all(math.isnan(point.uncertainty) and math.isnan(point.distance) for point in read)


def changed(place: str, value: object) -> bytes:
    """A file of points in which the first differs: "properties.kind"."""
    collection = json.loads(point_file.encode_points(POINTS))
    target = collection["features"][0]
    *way, last = place.split(".")
    for step in way:
        target = target[step]
    target[last] = value
    return json.dumps(collection).encode()


@for_each(
    "raw",
    [
        b"{",
        b"[" * 100_000,
        b"[]",
        b'{"type": "FeatureCollection"}',
        changed("geometry.coordinates", [1.0]),
        changed("geometry.coordinates", [1.0, "2"]),
        changed("geometry.coordinates", [float("nan"), 2.0]),
        changed("geometry.coordinates", [10**400, 2.0]),
        changed("geometry.type", "Polygon"),
        changed("geometry", None),
        changed("properties.kind", "treasure"),
        changed("properties.number", 0),
        changed("properties.number", 1.5),
        changed("properties.number", "1"),
        changed("properties.number", POINTS[1].number),
        changed("properties.stamp", -1),
        changed("properties.uncertainty", -0.1),
        changed("properties.uncertainty", float("inf")),
        changed("properties.distance", 1e6),
        changed("properties.distance", "2.5"),
        changed("properties.note", "n" * 501),
        changed("properties.note", "a\0b"),
        changed("properties.note", "\ud800"),
        changed("properties.thumbnail", "!!!"),
        changed("properties.thumbnail", "A" * 8000),
        point_file.encode_points(
            tuple(dataclasses.replace(POINTS[1], number=n + 1) for n in range(MAX_POINTS + 1))
        ),
    ],
)  # fmt: skip
def test_wrong_points_are_refused(raw: bytes) -> None:
    with pytest.raises(MapFileError):
        point_file.decode_points(raw)


def test_a_saved_map_is_loaded_again(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "maps"
    described = storage.save(folder, "office", PICTURE, POINTS)
    assert described == folder / "office.yaml"
    assert sorted(path.name for path in folder.iterdir()) == [
        "office.geojson", "office.pgm", "office.yaml",
    ]  # fmt: skip
    picture, points = storage.load(folder, "office")
    assert picture.cells.tolist() == [[-1, 0, 0], [-1, 100, 100]]
    assert [point.number for point in points] == [3, 8]
    assert (folder / "office.pgm").stat().st_mode & 0o777 == 0o644


def test_a_map_of_another_program_has_no_points(tmp_path: Path) -> None:
    storage.save(tmp_path, "office", PICTURE, POINTS)
    (tmp_path / "office.geojson").unlink()
    assert storage.load(tmp_path, "office")[1] == ()


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../map", "a/b", "/etc/map", ".hidden", "-r", "a\0", "a\n", "ä", "n" * 65],
)
def test_a_name_does_not_lead_out_of_the_folder(tmp_path: Path, name: str) -> None:
    with pytest.raises(MapFileError, match="no name of a map"):
        storage.save(tmp_path / "maps", name, PICTURE, ())
    with pytest.raises(MapFileError, match="no name of a map"):
        storage.load(tmp_path, name)
    assert list(tmp_path.iterdir()) == []


def test_a_description_does_not_lead_out_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "secret.pgm").write_bytes(ros_map.encode_pgm(PICTURE))
    folder = tmp_path / "maps"
    storage.save(folder, "office", PICTURE, ())
    (folder / "office.yaml").write_bytes(yaml_with(image="../secret.pgm"))
    with pytest.raises(MapFileError, match="no name of a map"):
        storage.load(folder, "office")


def test_a_map_that_cannot_be_written_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    storage.save(tmp_path, "office", PICTURE, POINTS)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def full(handle: int) -> None:
        del handle
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(MapFileError, match="No space left"):
        storage.save(tmp_path, "office", dataclasses.replace(PICTURE, resolution=0.1), ())
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    storage.save(tmp_path, "office", PICTURE, ())
    with pytest.raises(MapFileError, match="cannot be read: No such file"):
        storage.load(tmp_path, "nowhere")
    (tmp_path / "office.pgm").unlink()
    os.mkfifo(tmp_path / "office.pgm")
    with pytest.raises(MapFileError, match="no regular file"):
        storage.load(tmp_path, "office")
