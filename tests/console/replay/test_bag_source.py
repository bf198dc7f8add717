"""A recording of any robot of ROS 2 is shown, the same however a moment is reached."""

from __future__ import annotations

import io
import json
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer as McapWriter
from PIL import Image as PillowImage

from hub.recording.recording_set import RecordingSet
from hub.recording.ros.topic_roles import RosRole, TopicRole
from rune_tui.errors import LogError
from rune_tui.model.topics import Topics, topics_of
from rune_tui.replay.bag_layout import bag_layout
from rune_tui.replay.bag_source import STEP_NS, BagSource
from rune_tui.replay.player import Player
from rune_tui.replay.source import EventKind, ReplayFrame
from rune_tui.replay.topic_choice import TopicChoice
from rune_tui.startup.opening import open_layout
from tests.support import ros_bags
from tests.support.ros_bags import START, STORE, Entry, header, make

SECOND = 1_000_000_000
FOREIGN = Path(__file__).parents[2] / "data" / "bags"
SIZE = (118, 37)


@pytest.fixture(scope="module", name="rover")
def _rover(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bags") / "rover.mcap"
    return ros_bags.write_mcap(path, [*ros_bags.entries(6)])


Opened = Callable[..., BagSource]


@pytest.fixture(name="opened")
def _opened() -> Iterator[Opened]:
    made: list[BagSource] = []

    def opened(path: Path, choice: TopicChoice | None = None) -> BagSource:
        made.append(BagSource(RecordingSet.open([path]), choice=choice))
        return made[-1]

    yield opened
    for each in made:
        each.close()


def entry(topic: str, message: Any, stamp: int) -> Entry:
    name = message.__msgtype__
    return topic, name, stamp, bytes(STORE.serialize_cdr(message, name))


def topics(frame: ReplayFrame) -> Topics:
    received = topics_of(*frame.state.robots.values())
    assert received is not None
    return received.value


def test_frames_are_equally_far_apart(opened: Opened, rover: Path) -> None:
    source = opened(rover)
    stamps = [frame.stamp for frame in source.frames(source.start - 1, source.end)]
    assert stamps == [*range(source.start, source.end + 1, STEP_NS)]
    assert source.faults == []
    chance = random.Random(3)
    for _ in range(50):
        stamp = chance.randrange(source.start, source.end)
        before, after = source.frame_before(stamp), source.frame_after(stamp)
        assert before == max(each for each in stamps if each <= stamp)
        assert after == min(each for each in stamps if each > stamp)
    assert source.frame_before(source.start - 1) is None
    assert source.frame_after(source.end) is None


def test_100_jumps_show_what_playing_shows(opened: Opened, rover: Path) -> None:
    played = opened(rover)
    frames = {
        each.stamp: repr(each.state.robots["robot"].messages.keys())
        + repr(each.state.robots["robot"].navigation)
        + repr({name: p.number for name, p in each.state.robots["robot"].all_pictures.items()})
        for each in played.frames(played.start - 1, played.end)
    }
    jumped = opened(rover)
    chance = random.Random(5)
    for stamp in chance.choices([*frames], k=100):
        (frame,) = jumped.frames(stamp - 1, stamp)
        robot = frame.state.robots["robot"]
        here = repr(robot.messages.keys()) + repr(robot.navigation)
        here += repr({name: each.number for name, each in robot.all_pictures.items()})
        assert here == frames[stamp]


def test_a_jump_draws_what_playing_draws(opened: Opened, rover: Path) -> None:
    played = Player(lambda: opened(rover), size=SIZE)
    jumped = Player(lambda: opened(rover), size=SIZE)
    played.seek(played.source.start, whole=True)
    for stamp in (START + 2 * SECOND, START + 4 * SECOND + 7):
        one, other = played.seek(stamp, whole=True), jumped.seek(stamp, whole=True)
        assert one is not None
        assert other is not None
        assert np.array_equal(one.pixels, other.pixels)
        assert np.array_equal(one.glyphs, other.glyphs)


def test_a_pause_of_years_has_no_frames(opened: Opened, tmp_path: Path) -> None:
    text = make("std_msgs/msg/Float64", data=1.0)
    year = 400 * 86400 * SECOND
    entries = [entry("/a", text, START), entry("/a", text, START + year)]
    source = opened(ros_bags.write_mcap(tmp_path / "a.mcap", entries))
    stamps = [each.stamp for each in source.frames(source.start - 1, source.end)]
    assert len(stamps) == 52
    assert stamps[-1] == source.end >= START + year
    middle = START + year // 2
    assert source.frame_before(middle) == stamps[50]
    assert source.frame_after(middle) == stamps[51]


def test_pictures_have_their_colours(opened: Opened, tmp_path: Path) -> None:
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[:, :32, 0], pixels[:, 32:, 1] = 255, 255

    def packed(kind: str) -> bytes:
        out = io.BytesIO()
        PillowImage.fromarray(pixels).save(out, kind, quality=95)
        return out.getvalue()

    def message(data: bytes, name: str) -> Any:
        content = np.frombuffer(data, np.uint8)
        return make("sensor_msgs/msg/CompressedImage", format=name, data=content)

    depth = io.BytesIO()
    ramp = np.arange(1, 48 * 64 + 1, dtype=np.uint16).reshape(48, 64)
    PillowImage.fromarray(ramp).save(depth, "PNG")
    entries = [
        entry(f"/{kind.lower()}/compressed", message(packed(kind), f"bgr8; {kind}"), START)
        for kind in ("JPEG", "PNG", "WEBP")
    ]
    deep = message(bytes(12) + depth.getvalue(), "16UC1; compressedDepth png")
    entries.append(entry("/deep/compressedDepth", deep, START))
    bad = message(packed("JPEG")[:99], "jpeg")
    entries.append(entry("/bad/compressed", bad, START))
    bomb = message(packed("PNG")[:16] + b"\xff\xff\xff\xff\xff\xff\xff\xff", "png")
    entries.append(entry("/bomb/compressed", bomb, START))
    source = opened(ros_bags.write_mcap(tmp_path / "a.mcap", entries))
    (frame,) = source.frames(START - 1, START)
    robot = frame.state.robots["robot"]
    assert robot.body is not None
    shown = {name: each.value.pixels for name, each in robot.pictures.items()}
    shown[robot.body.cameras[0].name] = robot.picture.value.pixels
    for kind in ("jpeg", "png", "webp"):
        assert np.abs(shown[kind].astype(int) - pixels)[:, [5, -5]].max() < 30, kind
    assert shown["deep"][40, 40, 0] > shown["deep"][3, 3, 0]
    assert shown["bad"].shape == shown["bomb"].shape == (3, 4, 3)
    said = "\n".join(source.faults)
    assert "bad: a picture in the format 'jpeg' cannot be decoded" in said
    assert "bomb: " in said


def test_topics_that_cannot_be_read_are_in_the_tree(opened: Opened, tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        ros_bags.add_foreign(writer)
        writer.finish()
    source = opened(path)
    (frame,) = source.frames(START - 1, START)
    troubles = {each.name: each.trouble for each in topics(frame).entries}
    assert troubles.keys() == {"/thing", "/proto", "/bare"}
    assert "its messages are flatbuffer (flatbuffer)" in troubles["/thing"]
    assert "it is cut" in troubles["/proto"]
    assert "of no named encoding" in troubles["/bare"]
    cells = Player(lambda: opened(path), size=SIZE).seek(START)
    assert cells is not None
    text = "".join(map(chr, cells.glyphs[cells.glyphs > 0].tolist()))
    assert "foxglove.Lognotread" in text.replace(" ", "")


@pytest.mark.parametrize("name", ["foxglove", "foxglove-json", "ros1"])
def test_robots_of_other_encodings_are_shown(opened: Opened, name: str) -> None:
    source = opened(FOREIGN / f"{name}.mcap")
    *_, frame = source.frames(START - 1, START + SECOND // 2)
    (robot,) = frame.state.robots.values()
    assert source.faults == []
    assert {each.trouble for each in topics(frame).entries} == {""}
    assert robot.navigation is not None
    x = robot.navigation.value.x
    assert x == pytest.approx(0.25)
    assert robot.map is not None
    assert robot.map.value.resolution == 0.25
    assert robot.picture is not None
    colours = {"ros1": (0, 255, 0)}
    assert tuple(robot.picture.value.pixels[1, 1]) == colours.get(name, (255, 0, 0))
    assert robot.body is not None
    assert [each.beams for each in robot.body.ranges] == [21 if name == "ros1" else 31]
    chosen = topics(frame)
    assert chosen.field
    assert len(chosen.read_series().values)


def test_what_went_wrong_is_on_the_timeline(opened: Opened, tmp_path: Path) -> None:
    def problem(level: int, name: str = "motors") -> Any:
        status = make("diagnostic_msgs/msg/DiagnosticStatus", level=level, name=name, message="hot")
        return make("diagnostic_msgs/msg/DiagnosticArray", status=[status])

    def log(level: int, text: str = "no path") -> Any:
        return make("rcl_interfaces/msg/Log", level=level, name="nav", msg=text)

    def charge(share: float) -> Any:
        return make("sensor_msgs/msg/BatteryState", percentage=share)

    said = [
        *((1, "/diagnostics", problem(0)), (2, "/diagnostics", problem(1))),
        *((3, "/diagnostics", problem(2)), (4, "/diagnostics", problem(2))),
        *((5, "/diagnostics", problem(0)), (6, "/diagnostics", problem(2))),
        *((3.2, "/rosout", log(30)), (4.2, "/rosout", log(40)), (5.2, "/rosout", log(40))),
        *((20.2, "/rosout", log(40)), (20.4, "/rosout", log(50, "stopped"))),
        *((1.1, "/battery", charge(0.3)), (2.1, "/battery", charge(0.19))),
        *((3.1, "/battery", charge(0.21)), (4.1, "/battery", charge(0.18))),
    ]
    entries = [entry(topic, each, START + int(at * 10) * SECOND // 10) for at, topic, each in said]
    # Two topics: one is silent while the other goes on, then both are.
    beat = make("std_msgs/msg/Float64", data=1.0)
    entries += [entry("/a", beat, START + at * SECOND // 10) for at in range(80)]
    entries += [entry("/b", beat, START + at * SECOND // 2) for at in range(24)]
    entries.append(entry("/b", beat, START + 30 * SECOND))
    source = opened(ros_bags.write_mcap(tmp_path / "a.mcap", sorted(entries, key=lambda e: e[2])))
    overview = source.overview()
    found = [
        ((each.stamp - START) / SECOND, each.kind.value, each.text) for each in overview.events
    ]
    assert found == [
        (2.1, "!", "the battery is low: 19 %"),
        (3.0, "!", "motors: hot"),
        (4.2, "!", "nav: no path"),
        (6.0, "!", "motors: hot"),
        (20.2, "!", "nav: no path"),
        (20.4, "!", "nav: stopped"),
    ]
    gaps = [((each.start - START) / SECOND, (each.end - START) / SECOND) for each in overview.gaps]
    assert gaps == [(11.5, 20.2), (20.4, 30.0)]


def test_errors_of_foxglove_are_on_the_timeline(opened: Opened) -> None:
    overview = opened(FOREIGN / "foxglove.mcap").overview()
    assert [each.text for each in overview.events] == ["base: motor too hot"]


def test_bumpers_are_on_the_timeline(opened: Opened, tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        for at, (kind, pressed) in enumerate(
            (
                ("irobot_create_msgs/msg/HazardDetectionVector", {"detections": [{"type": 1}]}),
                ("irobot_create_msgs/msg/HazardDetectionVector", {"detections": [{"type": 3}]}),
                ("kobuki_ros_interfaces/msg/BumperEvent", {"state": 1, "bumper": 0}),
                ("kobuki_msgs/BumperEvent", {"state": 0, "bumper": 0}),
                ("gazebo_msgs/msg/ContactsState", {"states": [{}]}),
                ("gazebo_msgs/msg/ContactsState", {"states": []}),
            )
        ):
            channel = writer.register_channel(
                f"/bumper{at}", "json", writer.register_schema(kind, "jsonschema", b"{}")
            )
            for again in range(3):  # one touch
                stamp = START + at * 10 * SECOND + again * SECOND // 4
                writer.add_message(channel, stamp, json.dumps(pressed).encode(), stamp)
        writer.finish()
    events = opened(path).overview().events
    assert [(each.stamp - START) // SECOND for each in events] == [0, 20, 40]
    assert {each.kind for each in events} == {EventKind.BUMP}


def test_a_recording_waits_for_no_map(opened: Opened, tmp_path: Path) -> None:
    moved = ros_bags.transform(START, "odom", "base_link", 1.0, 0.0, 0.0)
    entries = [entry("/tf", make("tf2_msgs/msg/TFMessage", transforms=[moved]), START)]
    path = ros_bags.write_mcap(tmp_path / "a.mcap", entries)
    cells = Player(lambda: opened(path), size=SIZE).seek(START)
    assert cells is not None
    text = "".join(map(chr, cells.glyphs[cells.glyphs > 0].tolist()))
    assert "topics" in text
    assert "waiting" not in text


def test_keys_choose_topic_and_field(opened: Opened, rover: Path) -> None:
    choice = TopicChoice()
    source = opened(rover, choice)

    def shown() -> Topics:
        (frame,) = source.frames(START + SECOND - 1, START + SECOND)
        return topics(frame)

    first = shown()
    assert (first.chosen, first.field) == ("/battery", "voltage")
    assert source.press("down", START + SECOND)
    assert shown().chosen == "/camera/image_raw"
    assert source.press("down", START + SECOND)
    load = shown()
    assert (load.chosen, load.field) == ("/debug/load", "data")
    series = load.read_series()
    assert len(series.times) == 21
    assert series.values[-1] == pytest.approx(np.sin(2.0))
    assert source.press("z", START + SECOND)
    assert shown().seconds == 60.0
    assert source.press("pagedown", START + SECOND)
    assert source.press("up", START + SECOND)
    assert source.press("up", START + SECOND)
    assert source.press("up", START + SECOND)
    assert shown().chosen == "/odom"
    before = shown().field
    assert source.press("tab", START + SECOND)
    assert shown().field != before
    assert source.press("shift+tab", START + SECOND)
    assert shown().field == before
    assert not source.press("w", START + SECOND)


def test_a_recording_without_messages_is_refused(opened: Opened, tmp_path: Path) -> None:
    with pytest.raises(LogError, match="has no messages"):
        opened(ros_bags.write_mcap(tmp_path / "a.mcap", [entry("/a", header(0), 0)]))


def test_ten_thousand_topics_are_shown(opened: Opened, tmp_path: Path) -> None:
    message = make("std_msgs/msg/Float64", data=1.0)
    entries = [entry(f"/part/t{n}", message, START + n) for n in range(10_000)]
    source = opened(ros_bags.write_mcap(tmp_path / "a.mcap", entries))
    frame = next(source.frames(START, source.end))
    assert len(topics(frame).entries) == 10_000


ROLES = list(RosRole)


@pytest.mark.parametrize("seed", range(20))
def test_any_recording_has_a_layout(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    names = ["a \"b\" <c> & 'd'", "x" * 64, "{robot}", "front", "depth", "--", "e", "f"]
    cameras = [
        TopicRole(channel=n, role=RosRole.PICTURE, name=names[n])
        for n in range(chance.randrange(len(names)))
    ]
    roles = frozenset(chance.sample(ROLES, chance.randrange(len(ROLES))))
    path = tmp_path / "layout.xml"
    path.write_text(bag_layout(cameras, roles), "utf-8")
    layout = open_layout(path)
    assert {"topics", "fields", "plot"} <= {each.name for each in layout.view.viewports}
