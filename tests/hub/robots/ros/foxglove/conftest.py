"""A scripted bridge and a line to it, for the tests of this folder."""

import pytest

from hub.robots.ros.address import ros_address
from hub.robots.ros.opening import line_to
from tests.hub.robots.ros.foxglove.scripted_bridge import ScriptedBridge, channel
from tests.support.waiting import until


class Both:
    """A scripted bridge and a line to it, with a clock that the test moves."""

    def __init__(self, bridge):
        self.bridge, self.now = bridge, 1000.0
        self.line = line_to(ros_address(bridge.url))

    def advance(self, seconds=0.0):
        self.now += seconds
        self.line.advance(self.now)
        self.bridge.turn()

    def wait(self, condition):
        until(condition, 20.0, lambda: f"{self.line.state}", meanwhile=self.advance)

    def meet(self, *topics):
        """Connect, and subscribe to topics; returns the numbers of the subscriptions."""
        self.wait(lambda: self.line.state.up)
        self.bridge.say(
            {"op": "advertise", "channels": [channel(*each) for each in enumerate(topics)]}
        )
        self.wait(lambda: len(self.bridge.subscriptions()) == len(topics))
        return [self.bridge.subscriptions()[each] for each in range(len(topics))]


@pytest.fixture
def both():
    made = []

    def make(**options):
        made.append(Both(ScriptedBridge(**options)))
        return made[-1]

    yield make
    for each in made:
        each.line.close()
        each.bridge.close()
