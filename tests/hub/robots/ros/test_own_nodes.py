"""Nodes through which Rune publishes, and all others."""

from __future__ import annotations

from hub.robots.ros.own_nodes import foreign, rivals


def test_the_node_of_a_robot_that_rune_serves_is_one_that_may_follow() -> None:
    own = ("/foxglove_bridge", "/foxglove_nodelet_manager", "rune_4711", "/lab/rune_4711")
    others = ("/rune", "/rover/rune", "/teleop", "/prune_node")
    assert foreign((*own, *others)) == others


def test_another_hub_that_publishes_velocities_is_a_rival_and_the_bridge_is_none() -> None:
    assert rivals(("/foxglove_bridge", "/foxglove_nodelet_manager")) == ()
    assert rivals(("/foxglove_bridge", "/rune_4711", "/teleop")) == ("/rune_4711", "/teleop")
