"""Pictures of each encoding have their colours; sizes that do not match are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import RosMessageError
from hub.recording.topics import RecordedTopic
from hub.ros.clouds import SIDE, from_above, points_of
from hub.ros.decoding import RosDecoder
from hub.ros.images import pixels_of
from hub.ros.values import RosValue
from tests.support.ros_bags import STORE, make

RED, GREEN, BLUE, GREY = (255, 0, 0), (0, 255, 0), (0, 0, 255), (128, 128, 128)
FOUR = np.array([[RED, GREEN], [BLUE, GREY]], np.uint8).repeat(2, 0).repeat(2, 1)
"""A picture of 4 by 4 pixels in four colours, shape (4, 4, 3)."""


def read(message: object) -> RosValue:
    name: str = message.__msgtype__  # type: ignore[attr-defined]
    payload = bytes(STORE.serialize_cdr(message, name))
    return RosDecoder.of(RecordedTopic("/a", name)).decode(payload)


def image(encoding: str, rows: np.ndarray, width: int = 4, big: int = 0, pad: int = 0) -> RosValue:
    """A picture of these rows of bytes, with bytes behind each row that are no pixels."""
    padded = np.pad(rows.view(np.uint8).reshape(len(rows), -1), ((0, 0), (0, pad)))
    return read(
        make(
            "sensor_msgs/msg/Image",
            height=4,
            width=width,
            encoding=encoding,
            is_bigendian=big,
            step=padded.shape[1],
            data=padded.reshape(-1),
        )
    )


def yuv() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    red, green, blue = np.moveaxis(FOUR.astype(float), -1, 0)
    light = 0.299 * red + 0.587 * green + 0.114 * blue
    u, v = 128 + 0.564 * (blue - light), 128 + 0.713 * (red - light)
    return tuple(np.clip(np.rint(each), 0, 255).astype(np.uint8) for each in (light, u, v))


def coded(encoding: str) -> np.ndarray:
    """The rows of `FOUR` in an encoding."""
    alpha = np.full((4, 4, 1), 9, np.uint8)
    y, u, v = yuv()
    pairs = {"y0": y[:, ::2], "y1": y[:, 1::2], "u": u[:, ::2], "v": v[:, ::2]}
    uyvy = np.stack([pairs[each] for each in ("u", "y0", "v", "y1")], -1)
    yuyv = np.stack([pairs[each] for each in ("y0", "u", "y1", "v")], -1)
    half = np.stack([u[::2, ::2], v[::2, ::2]], -1).reshape(2, 4)
    return {
        "rgb8": FOUR,
        "bgr8": FOUR[..., ::-1],
        "8UC3": FOUR[..., ::-1],
        "rgba8": np.concatenate([FOUR, alpha], -1),
        "bgra8": np.concatenate([FOUR[..., ::-1], alpha], -1),
        "rgb16": FOUR.astype("<u2") << 8,
        "bgr16": FOUR[..., ::-1].astype("<u2") << 8,
        "yuv422": uyvy,
        "uyvy": uyvy,
        "yuyv": yuyv,
        "yuv422_yuy2": yuyv,
        "nv12": np.concatenate([y, half]),
        "nv21": np.concatenate([y, half.reshape(2, 2, 2)[..., ::-1].reshape(2, 4)]),
    }[encoding]


@pytest.mark.parametrize("pad", [0, 5])
@pytest.mark.parametrize(
    "encoding",
    [
        *("rgb8", "bgr8", "8UC3", "rgba8", "bgra8", "rgb16", "bgr16"),
        *("yuv422", "uyvy", "yuyv", "yuv422_yuy2", "nv12", "nv21"),
    ],
)
def test_colours_are_those_of_the_encoding(encoding: str, pad: int) -> None:
    pixels = pixels_of(image(encoding, np.ascontiguousarray(coded(encoding)), pad=pad))
    assert np.abs(pixels.astype(int) - FOUR).max() <= 3


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
@pytest.mark.parametrize("bits", [8, 16])
def test_bayer_pictures_have_half_the_pixels(pattern: str, bits: int) -> None:
    colours = {"r": FOUR[..., 0], "g": FOUR[..., 1], "b": FOUR[..., 2]}
    raw = np.zeros((4, 4), np.uint8)
    for place, letter in enumerate(pattern):
        at = np.s_[place // 2 :: 2, place % 2 :: 2]
        raw[at] = colours[letter][at]
    rows = raw if bits == 8 else raw.astype("<u2") << 8
    assert np.array_equal(pixels_of(image(f"bayer_{pattern}{bits}", rows)), FOUR[::2, ::2])


@pytest.mark.parametrize(
    ("encoding", "kind"), [("mono8", "u1"), ("mono16", "<u2"), ("16UC1", "<u2"), ("32FC1", "<f4")]
)
def test_numbers_become_shades(encoding: str, kind: str) -> None:
    ramp = np.linspace(1, 200, 16).reshape(4, 4)
    rows = (ramp * (1 if kind == "u1" else 256)).astype(kind)
    if kind == "<f4":
        rows[0, 0] = np.nan
    pixels = pixels_of(image(encoding, rows))
    assert pixels.shape == (4, 4, 3)
    assert (np.diff(pixels[..., 0].reshape(-1)[1:].astype(int)) >= 0).all()
    assert pixels[3, 3, 0] > pixels[0, 1, 0] + 100
    assert np.array_equal(pixels[..., 0], pixels[..., 2])
    if kind == "<u2":
        swapped = image(encoding, rows.astype(">u2"), big=1)
        assert np.array_equal(pixels_of(swapped), pixels)


def test_a_picture_of_all_equal_or_no_depths_has_shades() -> None:
    assert pixels_of(image("32FC1", np.full((4, 4), np.nan, np.float32))).max() == 0
    assert len(np.unique(pixels_of(image("32FC1", np.full((4, 4), 2, np.float32))))) == 1


def test_large_pictures_have_fewer_pixels() -> None:
    large = make(
        "sensor_msgs/msg/Image",
        height=2160,
        width=3840,
        encoding="rgb8",
        step=3840 * 3,
        data=np.zeros(2160 * 3840 * 3, np.uint8),
    )
    assert pixels_of(read(large)).shape == (720, 1280, 3)


@pytest.mark.parametrize(
    ("encoding", "rows", "width"),
    [
        ("rgb8", FOUR[:3], 4),
        ("rgb8", FOUR, 400),
        ("rgb8", FOUR, 0),
        ("rgb8", FOUR, 1 << 31),
        ("theora", FOUR, 4),
        ("bayer_xxxx8", FOUR, 4),
        ("bayer_rggb12", FOUR, 4),
        ("", FOUR, 4),
        ("nv12", FOUR[:, :1], 4),
    ],
)
def test_pictures_that_do_not_fit_are_refused(encoding: str, rows: np.ndarray, width: int) -> None:
    with pytest.raises(RosMessageError, match=r"pictures? of"):
        pixels_of(image(encoding, np.ascontiguousarray(rows), width=width))


@given(
    encoding=st.sampled_from(["rgb8", "mono16", "yuyv", "nv12", "bayer_rggb8", "32FC1", "bgr16"]),
    size=st.tuples(*[st.integers(0, 2**32 - 1) | st.integers(0, 20)] * 3),
    length=st.integers(0, 400),
)
def test_any_sizes_are_a_picture_or_refused(
    encoding: str, size: tuple[int, int, int], length: int
) -> None:
    height, width, step = size
    value = read(
        make(
            "sensor_msgs/msg/Image",
            height=height,
            width=width,
            step=step,
            encoding=encoding,
            data=np.full(length, 200, np.uint8),
        )
    )
    try:
        pixels = pixels_of(value)
    except RosMessageError:
        return
    assert pixels.dtype == np.uint8
    assert pixels.ndim == 3


def cloud(points: np.ndarray, **changes: object) -> RosValue:
    fields = [
        make("sensor_msgs/msg/PointField", name=name, offset=4 * at, datatype=7, count=1)
        for at, name in enumerate("xyz")
    ]
    given = {
        "height": 1,
        "width": len(points),
        "fields": fields,
        "point_step": 16,
        "data": np.pad(points.astype("<f4").view(np.uint8), ((0, 0), (0, 4))).reshape(-1),
    }
    return read(make("sensor_msgs/msg/PointCloud2", **{**given, **changes}))


def test_points_are_seen_from_above() -> None:
    points = np.array([[2, 0, 0], [0, 2, 1], [np.nan, 0, 0], [-1, -1, 0.5]])
    read_points = points_of(cloud(points))
    assert np.allclose(read_points, points[[0, 1, 3]])
    picture = from_above(np.repeat(read_points * 0.99, 30, axis=0))
    middle = SIDE // 2
    ahead, left = picture[:8, middle - 4 : middle + 4], picture[middle - 4 : middle + 4, :8]
    assert ahead.any()
    assert left.any()
    assert ahead.reshape(-1, 3).max(0)[2] > ahead.reshape(-1, 3).max(0)[0]  # low: blue
    assert left.reshape(-1, 3).max(0)[0] > left.reshape(-1, 3).max(0)[2]  # high: red
    assert not picture[-8:].any()
    assert from_above(np.empty((0, 3), np.float32)).any()


@pytest.mark.parametrize("changes", [{"point_step": 0}, {"point_step": 8}, {"fields": []}])
def test_clouds_without_points_are_refused(changes: dict[str, object]) -> None:
    with pytest.raises(RosMessageError, match=r"of a cloud|a cloud has"):
        points_of(cloud(np.ones((3, 3)), **changes))


def test_a_cloud_that_announces_too_much_has_what_is_there() -> None:
    assert len(points_of(cloud(np.ones((3, 3)), width=1 << 31, height=1 << 31))) == 3
    assert len(points_of(cloud(np.ones((3, 3)), width=0))) == 0
