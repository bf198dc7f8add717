"""A link of 64 kbit/s that a robot's broadcasts alone would fill: pictures and states stay live."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import numpy as np
import pytest

from hub.gcm import navigation, ranges, vision
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.node.responders import Reply
from hub.modules.vision.coding import code
from rune_tui.link.robot_link import RobotLink
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.robot_state import RobotState
from rune_tui.startup.opening import open_layout
from tests.console.states import IN_THE_OPEN
from tests.support.messages import camera_state, robot_state
from tests.support.ports import free_port
from tests.support.thin_link import ThinLink
from tests.support.waiting import until

AHEAD_S = 7200.0
LAYOUT = """<rune>
  <robot name="magellan">
    <capability name="VIS_VID" interval_ms="66"/>
    <capability name="NAV_STATE"/>
  </robot>
  <view xsize="160" ysize="96">
    <viewport name="status" robot="magellan" xpos="0" ypos="0" xsize="160" ysize="2">
      <visualizer function="visualizeStatus" message="GCM_RobotState"/>
    </viewport>
  </view>
</rune>
"""


def clock() -> float:
    """Another machine's monotonic clock [s]."""
    return time.monotonic() + AHEAD_S


class Robot:
    """Publishes its state 50 times a second, its ranges 10 times; a thread of its own."""

    def __init__(self, endpoint: str) -> None:
        self._client = Client("robot", endpoint)
        self._ended = threading.Event()
        noise = np.random.default_rng(2).normal(0.0, 4.0, (96, 160, 3))
        steps = np.linspace(0, 200, 96 * 160).reshape(96, 160, 1) // 40 * 40
        self._pixels = np.clip(steps + noise, 0, 255).astype(np.uint8)
        self._client.respond_later(vision.IMAGE_REQUEST, vision.IMAGE, self._answer)
        self._client.every(0.02, self._tell)
        self._client.every(0.1, self._tell_ranges)
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        while not self._ended.is_set():
            self._client.listen(0.1)
        self._client.close()

    def _tell(self) -> None:
        now = time.monotonic()
        self._client.publish(navigation.ROBOT_STATE, robot_state(x=now), measured=now)

    def _tell_ranges(self) -> None:
        self._client.publish(ranges.RANGES, IN_THE_OPEN, measured=time.monotonic())

    def _answer(self, request: vision.ImageRequest, reply: Reply[vision.Image]) -> None:
        now = time.monotonic()
        pixels = self._pixels[: request.height_px, : request.width_px]
        data = code(pixels, request.coding, request.quality)
        image = vision.Image(
            camera=camera_state(stamp=now),
            coding=request.coding,
            width_px=pixels.shape[1],
            height_px=pixels.shape[0],
            channels=3,
            data=data,
        )
        reply.answer(image, measured=now)

    def close(self) -> None:
        self._ended.set()
        self._thread.join()


@pytest.fixture
def link(tmp_path: Path) -> Iterator[RobotLink]:
    (tmp_path / "layout.xml").write_text(LAYOUT)
    (spec,) = open_layout(tmp_path / "layout.xml").robots
    with ExitStack() as stack:
        central = stack.enter_context(closing(Central([f"tcp://127.0.0.1:{free_port()}"])))
        hub = central.endpoints[0]
        stack.enter_context(closing(Robot(hub)))
        thin = stack.enter_context(closing(ThinLink(hub, rate=64e3)))
        made = RobotLink(spec, thin.endpoint, near=False, clock=clock)
        made.start()
        yield stack.enter_context(closing(made))


@pytest.mark.soak
def test_on_a_link_that_broadcasts_would_fill_pictures_and_states_stay_live(
    link: RobotLink,
) -> None:
    fresh: list[float] = []
    shown = [0]

    def live() -> bool:
        """Whether ten pictures in a row came young, with a young state beside each."""
        state = link.state
        if state.picture is not None and state.picture.number != shown[-1]:
            shown.append(state.picture.number)
            link.shown(state.picture.number)
            fresh.append(worst_age(state))
            if fresh[-1] > 1.0:
                fresh.clear()
        return len(fresh) >= 10

    link.want_pictures({"": PictureNeed(size=(160, 96))})
    until(live, 40.0, lambda: f"ages are {fresh}: {link.state.link}")
    # Each came by half a round trip at most another way than it is taken to have come.
    now = link.state
    assert now.picture is not None
    assert abs(told(now) - true(now)) < 0.2


def worst_age(state: RobotState) -> float:
    assert state.picture is not None
    messages = (state.navigation, state.newest(ranges.RANGES))
    return max(true(state), *(each.age(clock()) if each else np.inf for each in messages))


def told(state: RobotState) -> float:
    """The picture's age as the console tells it [s]."""
    assert state.picture is not None
    return state.picture.age(clock())


def true(state: RobotState) -> float:
    """The picture's age by the clock that robot and console really have in common [s]."""
    assert state.picture is not None
    return time.monotonic() - state.picture.value.camera.stamp
