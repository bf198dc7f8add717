"""Vision gets poses while somebody looks, and no picture shows an old place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from hub.gcm.navigation import GROUND_TRUTH, ROBOT_STATE
from hub.ipc.message_info import MessageInfo
from hub.modules.vision.pose_feed import LINGER_S, WAKE_S, PoseFeed, PoseSource


class Bus:
    """Subscriptions without sockets.

    Attributes:
        handlers: Of the messages that are subscribed now.
    """

    def __init__(self) -> None:
        self.handlers: dict[str, Callable[..., None]] = {}

    def subscribe(self, definition: Any, handler: Callable[..., None]) -> None:
        assert definition.name not in self.handlers
        self.handlers[definition.name] = handler

    def unsubscribe(self, definition: Any) -> None:
        del self.handlers[definition.name]

    def send(self, definition: Any) -> None:
        self.handlers[definition.name](definition.name, MessageInfo(1, 1, 0, 0.0, 0.0))


class Scene:
    """A feed, and what it did in its order."""

    def __init__(self) -> None:
        self.bus = Bus()
        self.done: list[str] = []
        definitions = ROBOT_STATE, GROUND_TRUTH
        sources = [
            PoseSource(definition=each, handler=lambda name, _: self.done.append(name))
            for each in definitions
        ]
        self.feed = PoseFeed(self.bus, sources)

    def picture(self, now: float) -> None:
        self.feed.need(now, lambda: self.done.append("picture"))

    def poses(self) -> None:
        self.bus.send(ROBOT_STATE)
        self.bus.send(GROUND_TRUTH)


def test_it_subscribes_to_nothing_before_somebody_looks() -> None:
    scene = Scene()
    scene.feed.look(100.0)
    assert scene.feed.asleep
    assert not scene.bus.handlers


def test_the_first_picture_waits_for_a_pose_of_each_kind() -> None:
    scene = Scene()
    scene.picture(0.0)
    scene.bus.send(GROUND_TRUTH)
    scene.bus.send(GROUND_TRUTH)
    scene.feed.look(WAKE_S / 2.0)
    assert "picture" not in scene.done
    scene.bus.send(ROBOT_STATE)
    assert scene.done[-2:] == [ROBOT_STATE.name, "picture"]
    scene.picture(1.0)
    assert scene.done[-2:] == ["picture", "picture"]


def test_without_poses_pictures_come_all_the_same() -> None:
    scene = Scene()
    scene.picture(0.0)
    scene.picture(0.1)
    assert scene.feed.due == WAKE_S
    scene.feed.look(WAKE_S)
    assert scene.done == ["picture", "picture"]
    scene.picture(1.0)
    assert len(scene.done) == 3


def test_it_falls_asleep_when_nobody_looks_and_wakes_again() -> None:
    scene = Scene()
    scene.picture(0.0)
    scene.poses()
    scene.feed.need(3.0)
    scene.feed.look(LINGER_S + 1.0)
    assert not scene.feed.asleep
    scene.feed.look(LINGER_S + 3.0)
    assert scene.feed.asleep
    assert not scene.bus.handlers
    scene.done.clear()
    scene.picture(100.0)
    assert not scene.done
    scene.poses()
    assert scene.done[-1] == "picture"


def test_a_picture_that_fails_takes_no_other_with_it() -> None:
    scene = Scene()

    def fail() -> None:
        raise RuntimeError

    scene.feed.need(0.0, fail)
    scene.picture(0.0)
    with pytest.raises(RuntimeError):
        scene.poses()
    scene.feed.look(scene.feed.due)
    assert scene.done[-1] == "picture"
