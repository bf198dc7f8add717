"""Layouts that are made from what a hub describes."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.body import (
    BodyFrame,
    CameraBody,
    Freedom,
    HoldBody,
    HoldKind,
    JointBody,
    LightBody,
    Motion,
    RangeGroup,
    RangeKind,
    RobotBody,
)
from hub.gcm.capability import Capability
from hub.robots.registry import body_of
from hub.robots.robot_file import SHIPPED, read_description
from rune_tui.layout.arrangement_notes import arrangement_notes
from rune_tui.layout.spec import LayoutSpec
from rune_tui.startup.auto_layout import layout_text
from rune_tui.startup.opening import open_layout

ALL = {capability.value for capability in Capability} - {Capability.DRV_MODE.value}
"""All but an autopilot's."""
HUB = "tcp://127.0.0.1:1381"


def opened(folder: Path, body: RobotBody, capabilities: set[str]) -> LayoutSpec:
    path = folder / "auto.xml"
    path.write_text(layout_text(body, capabilities, HUB))
    return open_layout(path)


def names(layout: LayoutSpec) -> set[str]:
    return {viewport.name for viewport in layout.view.viewports}


@pytest.mark.parametrize("robot", sorted(path.stem for path in SHIPPED.glob("*.toml")))
def test_each_shipped_robot_has_one(tmp_path: Path, robot: str) -> None:
    body = body_of(read_description(SHIPPED / f"{robot}.toml")[0])
    shown = names(opened(tmp_path, body, ALL))
    assert {"camera", "map", "alarms", "status", "keys"} <= shown
    wide, *_ = opened(tmp_path, body, ALL).view.arrangements
    assert {place.viewport for place in wide.places} == shown, "all of it where there is room"
    assert ("range" in shown) == (robot in {"magellan", "tracked"})
    assert ("height" in shown) == (robot in {"blimp", "rov"})
    assert ("attitude" in shown) == (robot != "magellan")


def test_a_robot_with_nothing_has_words_and_gauges(tmp_path: Path) -> None:
    shown = names(opened(tmp_path, RobotBody(name="a", kind="b", radius=0.2), {"NAV_STATE"}))
    assert shown == {"alarms", "log", "heading", "speed", "battery", "keys", "status"}


def test_keys_are_those_of_its_degrees_of_freedom() -> None:
    def text(*freedoms: Freedom) -> str:
        motions = tuple(Motion(freedom=each, limit=0.4, acceleration=1.0) for each in freedoms)
        return layout_text(
            RobotBody(name="a", kind="b", radius=0.2, motions=motions), {"NAV_MOVE"}, HUB
        )

    assert 'control="rotate"' not in text(Freedom.SURGE)
    assert 'control="translate"' in text(Freedom.SURGE)
    assert "widgetSetSpeed" not in text()
    assert "widgetStop" in text()


@pytest.mark.parametrize(
    ("robot", "first"),
    [
        ("magellan", "Space STOP · WASD drive · T control · IJKL look"),
        ("tracked", "Space STOP · WASD drive · T control · IJKL look"),
        ("blimp", "Space STOP · WASD drive · PgUp PgDn climb · T control"),
        ("rov", "Space STOP · WASD drive · PgUp PgDn climb · T control · , . sideways"),
    ],
)
def test_the_most_important_keys_are_the_first_in_the_line_of_keys(robot: str, first: str) -> None:
    text = layout_text(body_of(read_description(SHIPPED / f"{robot}.toml")[0]), ALL, HUB)
    (line,) = re.findall(r'visualizeLabel" text="(.*)"', text)
    assert line.startswith(first)
    most = " · ".join([*line.split(" · ")[: first.count("·") + 1][:4], "F1 help", "Q quit"])
    assert len(most) <= 80, "a line of 80 columns"
    if robot == "rov":
        assert "G hold depth · Y hold heading" in line


@pytest.mark.parametrize("robot", sorted(path.stem for path in SHIPPED.glob("*.toml")))
def test_panels_are_high_enough_to_be_read_at_every_size(tmp_path: Path, robot: str) -> None:
    body = body_of(read_description(SHIPPED / f"{robot}.toml")[0])
    *sizes, _ = opened(tmp_path, body, ALL).view.arrangements
    for size in sizes:
        heights = {place.viewport: place.ysize for place in size.places}
        assert min(heights[name] for name in ("map", "alarms")) >= 6
        for picture in heights.keys() & {"map", "range", "attitude", "height", "camera 2"}:
            assert heights[picture] >= 12, "a title, and five rows of the picture"
        if body.holds or body.joints or body.arms:
            words = len(body.holds) + len(body.joints) + len(body.lights)
            assert heights["vehicle"] >= 2 * (2 + words), "a title, and a row for each part"


def test_each_velocity_has_its_own_limit() -> None:
    limits = {Freedom.SURGE: 0.6, Freedom.SWAY: 0.4, Freedom.HEAVE: 0.9, Freedom.YAW: 1.2}
    motions = tuple(Motion(freedom=f, limit=v, acceleration=1.0) for f, v in limits.items())
    text = layout_text(
        RobotBody(name="a", kind="b", radius=0.2, motions=motions), {"NAV_MOVE"}, HUB
    )
    for option, value in (("linear", 0.6), ("climb", 0.9), ("angular", 1.2)):
        assert f'<option name="{option}" value="{value:g}"/>' in text


_NAMES = st.text('ab<&"-é \t\n\x1b\u202e${}', min_size=1, max_size=64)


@given(
    name=_NAMES,
    cameras=st.lists(_NAMES, max_size=6, unique=True),
    ranges=st.booleans(),
    freedoms=st.sets(st.sampled_from(Freedom)),
    holds=st.lists(st.sampled_from(HoldKind), unique=True),
    joints=st.lists(_NAMES, max_size=20),
    limit=st.floats(0.0, 100.0),
    capabilities=st.sets(st.sampled_from(sorted(ALL))),
)
def test_every_body_has_a_layout_without_mistakes(
    tmp_path_factory: pytest.TempPathFactory,
    name: str,
    cameras: list[str],
    ranges: bool,  # noqa: FBT001 - hypothesis gives it
    freedoms: set[Freedom],
    holds: list[HoldKind],
    joints: list[str],
    limit: float,
    capabilities: set[str],
) -> None:
    body = RobotBody(
        name=name,
        kind="simulated-wheels",
        radius=0.2,
        motions=tuple(Motion(freedom=each, limit=limit, acceleration=1.0) for each in freedoms),
        frames=tuple(BodyFrame(name=each) for each in cameras),
        ranges=(RangeGroup(name="a", kind=RangeKind.LASER, farthest=1.0),) * ranges,
        cameras=tuple(CameraBody(name=each, horizontal_fov=1.0) for each in cameras),
        holds=tuple(HoldBody(kind=each) for each in holds),
        joints=tuple(JointBody(name=n, lowest=-1.0, highest=1.0, speed=1.0) for n in joints),
        lights=tuple(LightBody(name=each) for each in joints),
        arms=len(joints) % 2,
    )
    layout = opened(tmp_path_factory.mktemp("auto"), body, capabilities)
    notes = [note for note in arrangement_notes(layout) if note.startswith("note: ")]
    assert [note for note in notes if "needed at every size" in note or "cover" in note] == []


def test_a_vehicle_with_an_autopilot_has_its_pane_and_keys(tmp_path: Path) -> None:
    plain = body_of(read_description(SHIPPED / "magellan.toml")[0])
    body = dataclasses.replace(plain, arms=1)
    every = ALL | {"DRV_MODE"}
    shown = opened(tmp_path, body, every)
    assert "autopilot" in names(shown)
    assert "vehicle" not in names(shown), "the pane of the autopilot says whether it is armed"
    assert shown.notes == ()
    for size in shown.view.arrangements[:-1]:
        heights = {place.viewport: place.ysize for place in size.places}
        assert heights["autopilot"] >= 16
    with_holds = dataclasses.replace(body, holds=(HoldBody(kind=HoldKind.DEPTH),))
    assert {"autopilot", "vehicle"} <= names(opened(tmp_path, with_holds, every))
    without = opened(tmp_path, body, ALL)
    assert {"autopilot", "vehicle"} & names(without) == {"vehicle"}
    text = layout_text(body, every, HUB)
    for key in ("f8", "f9", "f", "h", "f2", "f3"):
        assert text.count(f'<event key="{key}"') == 1
    assert "F8 F8 arm, F9 off · F follow" in text
