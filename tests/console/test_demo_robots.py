"""Which robots and which arena a demo has."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub.robots.robot_file import SHIPPED
from hub.sim.arena import load_arena, shipped_arenas
from rune_tui.commands.demo import ARENAS, ROBOTS, DemoHubs, demo_layout, demo_robots
from rune_tui.errors import OwnHubError


def test_the_demo_knows_all_robots_and_arenas_that_come_with_the_hub() -> None:
    assert sorted(ROBOTS) == sorted(path.stem for path in SHIPPED.glob("*.toml"))
    assert sorted(ARENAS) == sorted(shipped_arenas())
    for name in ARENAS:
        (robot,), _ = demo_robots([""], name, None)
        assert robot in ROBOTS
        assert (robot == "rov") == (load_arena(name).berth("rov") is not None and name == "pool")


@pytest.mark.parametrize(
    ("roles", "arena", "robot", "wanted"),
    [
        (["robot"], "", None, (["magellan"], "")),
        (["robot"], "pool", None, (["rov"], "pool")),
        (["robot"], "red", "tracked", (["tracked"], "red")),
        (["left", "right"], "", None, (["magellan", "magellan"], "")),
        (["rover", "blimp", "submarine"], "", None, (["magellan", "blimp", "rov"], "hall")),
        (
            ["rover", "blimp", "submarine"],
            "mine.toml",
            "tracked",
            (["tracked", "blimp", "rov"], "mine.toml"),
        ),
    ],
)
def test_roles_choose_robots(
    roles: list[str], arena: str, robot: str | None, wanted: tuple[list[str], str]
) -> None:
    assert demo_robots(roles, arena, robot) == wanted


@pytest.mark.parametrize(
    ("arena", "robot", "layout"),
    [
        ("", None, "demo"),
        ("red", None, "demo"),
        ("red", "magellan", "demo"),
        ("red", "tracked", "auto"),
        ("", "blimp", "auto"),
        ("pool", None, "auto"),
        ("pool", "magellan", "demo"),
        ("", "autopilot-rover", "auto"),
    ],
)
def test_a_robot_with_more_than_wheels_has_a_layout_made_for_it(
    arena: str, robot: str | None, layout: str
) -> None:
    assert demo_layout(arena, robot) == layout


def test_a_hub_that_does_not_start_says_why_in_one_sentence(tmp_path: Path) -> None:
    log = tmp_path / "rune.log"
    log.write_text("rune-hub: the words of an earlier demo\n")
    with DemoHubs(log) as hubs:
        hubs.start(["rov"], "yellow")
        with pytest.raises(OwnHubError, match=r"did not start: .*it has no water to dive in"):
            hubs.endpoints()
