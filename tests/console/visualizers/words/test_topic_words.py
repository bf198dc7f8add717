"""The topics of a recording as a tree, the fields of one as a table, a number as a line."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import Received, RobotState
from rune_tui.model.theme import DARK
from rune_tui.model.topics import TOPICS, NumberSeries, TopicEntry, TopicField, Topics
from rune_tui.raster.canvas import Canvas
from tests.console.visualizers.conftest import made_by, words

ENTRIES = (
    TopicEntry(name="/camera/front/image", kind="sensor_msgs/msg/Image", count=300, rate_hz=30.0),
    TopicEntry(name="/camera/rear/image", kind="sensor_msgs/msg/Image", count=3, rate_hz=0.5),
    TopicEntry(name="/chatter", kind="std_msgs/msg/String"),
    TopicEntry(name="/proto", kind="x/msg/Log", trouble="its messages are protobuf"),
)
FIELDS = tuple(TopicField(path=f"data.part[{n}]", text=str(n), numeric=True) for n in range(50))
TIMES = np.arange(70.0, 100.0, 0.5)


def topics(**changes: object) -> Topics:
    usual = Topics(
        entries=ENTRIES,
        chosen="/chatter",
        newest=1,
        age_s=0.5,
        field="data.part[40]",
        read_fields=lambda: FIELDS,
        read_series=lambda: NumberSeries(times=TIMES, values=np.sin(TIMES)),
    )
    return dataclasses.replace(usual, **changes)


def drawn(made, function: str, value: Topics | None, size: tuple[int, int]) -> list[str]:
    return [row.rstrip() for row in words(canvas_of(made, function, value, size))]


def canvas_of(made, function: str, value: Topics | None, size: tuple[int, int]) -> Canvas:
    robot: RobotState = made.robot()
    if value is not None:
        shown = Received(value=value, measured=100.0, number=7)
        robot = robot.with_(messages={**robot.messages, TOPICS: shown})
    canvas = Canvas.blank(*size)
    visualizer = made_by(function)
    visualizer.source(robot, ConsoleState(now=100.0))
    visualizer.draw(canvas, robot, ConsoleState(now=100.0))
    return canvas


def test_topics_are_a_tree_with_rates_and_numbers(made) -> None:
    canvas = canvas_of(made, "visualizeTopics", topics(), (50, 20))
    assert [row.rstrip() for row in words(canvas)][:7] == [
        "camera/",
        "  front/",
        f"{'    image  Image':<34}{'30.0/s':>8}{300:>8}",
        "  rear/",
        f"{'    image  Image':<34}{'0.50/s':>8}{3:>8}",
        "chatter  String",
        "proto  Log not read",
    ]
    marked = (canvas.pixels[::2] == DARK.track).all(axis=2).all(axis=1)
    assert marked.tolist().index(True) == 5


@pytest.mark.parametrize("width", [1, 10, 20, 30, 200])
@pytest.mark.parametrize("function", ["visualizeTopics", "visualizeFields", "visualizeTopicPlot"])
def test_any_width_is_drawn(made, function: str, width: int) -> None:
    for height in (1, 2, 3, 40):
        drawn(made, function, topics(), (width, height))
        drawn(made, function, topics(entries=(), chosen="", field=""), (width, height))


@pytest.mark.parametrize("function", ["visualizeTopics", "visualizeFields", "visualizeTopicPlot"])
def test_a_robot_without_a_recording_says_so(made, function: str) -> None:
    assert "recordings" in " ".join(drawn(made, function, None, (60, 10)))


def test_the_chosen_topic_of_ten_thousand_is_seen(made) -> None:
    many = tuple(TopicEntry(name=f"/a/t{n:05d}", kind="x/msg/Y") for n in range(10_000))
    rows = drawn(made, "visualizeTopics", topics(entries=many, chosen="/a/t07000"), (40, 20))
    assert any(row.startswith("  t07000") for row in rows)
    assert "more below" in rows[-1]


def test_fields_are_a_table_around_the_chosen_one(made) -> None:
    rows = drawn(made, "visualizeFields", topics(), (40, 20))
    assert rows[0] == "/chatter  String"
    assert "data.part[40]  40" in rows
    rows = drawn(made, "visualizeFields", topics(age_s=7.0), (40, 20))
    assert rows[0] == "/chatter  String  7.0 s ago"


def test_fields_say_why_there_are_none(made) -> None:
    said = " ".join(drawn(made, "visualizeFields", topics(chosen="/proto"), (40, 20)))
    assert "its messages are protobuf" in said
    for newest, reason in ((0, "no message of /chatter until now"), (1, "does not fit its type")):
        shown = topics(read_fields=tuple, newest=newest)
        said = " ".join(drawn(made, "visualizeFields", shown, (40, 20)))
        assert reason in " ".join(said.split())


def test_a_number_is_a_line_with_its_limits(made) -> None:
    canvas = canvas_of(made, "visualizeTopicPlot", topics(), (80, 20))
    rows = words(canvas)
    assert rows[0].startswith("/chatter data.part[40] ")
    assert "-0.999 to 1 in 30 s" in rows[0]
    line = (canvas.pixels == DARK.accent).all(axis=2)
    assert line[:, 2:].any(axis=0).mean() > 0.95
    heights = [line[:, column].argmax() for column in range(2, 78) if line[:, column].any()]
    assert (
        np.corrcoef(heights, -np.sin(70 + 30 * np.arange(2, 78) / 80)[: len(heights)])[0, 1] > 0.9
    )


@pytest.mark.parametrize("values", [[], [math.nan] * 3])
def test_a_field_without_numbers_says_so(made, values: list[float]) -> None:
    none = NumberSeries(times=np.arange(len(values), dtype=float), values=np.array(values))
    rows = drawn(made, "visualizeTopicPlot", topics(read_series=lambda: none), (60, 10))
    assert "no numbers of data.part[40] of /chatter in 30 s" in " ".join(rows)
