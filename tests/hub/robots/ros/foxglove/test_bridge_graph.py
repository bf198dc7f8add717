"""The topics of a bridge, and what it says of nodes."""

from __future__ import annotations

from hub.robots.ros.foxglove.bridge_events import BridgeGraph
from hub.robots.ros.foxglove.bridge_graph import BridgeTopics


def graph(**nodes: dict[str, tuple[str, ...]]) -> BridgeGraph:
    return BridgeGraph(**({"publishers": {}, "subscribers": {}, "gone": ()} | nodes))


def test_nodes_are_not_known_before_the_bridge_names_one() -> None:
    """The bridge for ROS 2 answers with an empty graph, and with a whole one at the next change."""
    topics = BridgeTopics()
    topics.connect(graph())
    assert not topics.graph("jazzy").whole
    topics.connect(graph(publishers={"/odom": ("/base",)}))
    assert topics.graph("jazzy").whole
