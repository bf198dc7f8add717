"""Pictures of a robot with ROS: the newest one, decoded, or the reason why there is none."""

import io
import math
import time

import numpy as np
import pytest
from PIL import Image

from hub.errors import CameraError, RosMessageError
from hub.gcm.camera_info import CameraInfo
from hub.gcm.standard import Header
from hub.robots.body_tables import CameraTable
from hub.robots.ros.camera import RosCamera
from hub.robots.ros.pictures import decoded
from hub.ros.standard_types import CompressedImage
from hub.ros.values import NamedValue
from tests.support.memory_ros_line import MemoryLine, cdr
from tests.support.waiting import until

PACKED = "sensor_msgs/msg/CompressedImage"
TOPIC = "/camera/compressed"


def pixels(width=64, height=48):
    """Red on the left, blue on the right."""
    made = np.zeros((height, width, 3), np.uint8)
    made[:, : width // 2, 0] = 255
    made[:, width // 2 :, 2] = 255
    return made


def packed(kind="JPEG", picture=None):
    file = io.BytesIO()
    Image.fromarray(pixels() if picture is None else picture).save(file, kind)
    return np.frombuffer(file.getvalue(), np.uint8)


def compressed(data, kind="jpeg"):
    return NamedValue(PACKED, {"format": kind, "data": data.tobytes()})


def raw(encoding, data, width=64, height=48, size=3):
    fields = {
        "height": height,
        "width": width,
        "encoding": encoding,
        "is_bigendian": 0,
        "step": width * size,
        "data": np.ascontiguousarray(data).tobytes(),
    }
    return NamedValue("sensor_msgs/msg/Image", fields)


@pytest.mark.parametrize(
    "value",
    [
        compressed(packed("JPEG"), "rgb8; jpeg compressed bgr8"),
        compressed(packed("PNG"), "png"),
        raw("rgb8", pixels()),
        raw("bgr8", pixels()[..., ::-1]),
    ],
    ids=["jpeg", "png", "rgb8", "bgr8"],
)
def test_a_picture_in_any_usual_form_is_red_on_the_left_and_blue_on_the_right(value):
    found, whole = decoded(value, (32, 32))
    assert whole == (64, 48)
    assert found.shape == (32, 32, 3)
    assert found[16, 2] == pytest.approx([255, 0, 0], abs=12)
    assert found[16, -3] == pytest.approx([0, 0, 255], abs=12)


def test_depths_are_shades():
    depths = np.linspace(500, 4000, 64 * 48).reshape(48, 64).astype(np.uint16)
    for value in (
        raw("16UC1", depths, size=2),
        compressed(packed("PNG", depths), "16UC1; png compressed"),
    ):
        found, _ = decoded(value, (64, 48))
        assert found[0, 0, 0] < found[-1, -1, 0]


@pytest.mark.parametrize(
    "value",
    [
        compressed(packed()[:200]),
        compressed(np.zeros(100, np.uint8)),
        compressed(np.zeros(0, np.uint8)),
        compressed(packed(), "compressedDepth png"),
        raw("rgb8", np.zeros(10)),
        raw("strange", pixels()),
        raw("rgb8", pixels(), width=0),
        raw("rgb8", pixels(), width=1 << 20),
    ],
)
def test_what_is_no_picture_is_refused_in_a_sentence(value):
    with pytest.raises(RosMessageError):
        decoded(value, (32, 32))


class Scene:
    """A camera on a line in memory."""

    def __init__(self, **more):
        self.line = MemoryLine()
        self.line.topic(TOPIC, PACKED)
        self.line.topic("/camera/info", "sensor_msgs/msg/CameraInfo")
        table = CameraTable(topic=TOPIC, info="/camera/info", **more)
        self.camera = RosCamera(self.line, table)

    def take(self):
        return self.camera.take(32, 24, time.monotonic())

    def wake(self):
        with pytest.raises(CameraError):
            self.take()
        until(lambda: "/camera/info" in self.line.takers, 10.0)

    def give(self, age=0.0, data=None):
        whole = packed() if data is None else data
        value = CompressedImage(header=Header(), format="jpeg", data=whole)
        self.line.give(TOPIC, cdr(value), time.monotonic(), age)


@pytest.fixture
def scene():
    made = Scene()
    yield made
    made.camera.close()


def test_it_subscribes_when_a_picture_is_wanted(scene):
    assert TOPIC not in scene.line.takers
    with pytest.raises(CameraError, match=r"not connected yet|ask again"):
        scene.take()
    until(lambda: TOPIC in scene.line.takers, 10.0)
    before = time.monotonic()
    scene.give(age=0.3)
    picture = scene.take()
    assert picture.pixels.shape == (24, 32, 3)
    assert before - 0.3 - 1.0 < picture.measured < before
    assert scene.take() is picture


def test_its_field_of_view_is_that_of_the_robots_own_data(scene):
    scene.wake()
    info = CameraInfo.of(Header(), width_px=64, height_px=48, horizontal_fov=1.2)
    scene.line.give("/camera/info", cdr(info), time.monotonic())
    scene.give()
    assert scene.take().horizontal_fov == pytest.approx(1.2)
    assert scene.camera.camera_state(0.0).horizontal_fov == pytest.approx(1.2)


def test_a_picture_that_came_late_makes_the_connection_new(scene):
    scene.wake()
    scene.give(age=0.8)
    assert not scene.line.reconnects
    scene.give(age=1.5)
    assert scene.line.reconnects == [f"pictures of {TOPIC} came 1.5 s late"]
    scene.give(age=1.5)
    assert len(scene.line.reconnects) == 1


def test_an_old_picture_is_not_shown_and_the_reason_is_given(scene):
    scene.wake()
    scene.give(age=3.0)
    with pytest.raises(CameraError, match=r"no picture has come from /camera/compressed for 3 s"):
        scene.take()
    scene.line.lose("the bridge closed the connection")
    until(lambda: _says(scene, "the bridge closed the connection"), 10.0)


def test_a_picture_that_cannot_be_decoded_is_refused_with_its_topic(scene):
    scene.wake()
    scene.give(data=packed()[:200])
    with pytest.raises(CameraError, match=f"a picture of {TOPIC} cannot be decoded: its format"):
        scene.take()


def test_a_table_without_a_topic_is_refused():
    with pytest.raises(CameraError, match="names no topic"):
        RosCamera(MemoryLine(), CameraTable())


def test_it_has_no_headlight_and_the_usual_view_before_it_knows_better():
    table = CameraTable(topic=TOPIC)
    assert not table.camera.headlight
    assert math.isclose(table.fov, math.radians(60.0))


def _says(scene, words):
    try:
        scene.take()
    except CameraError as error:
        return words in str(error)
    return False
