"""Panels that drive: the messages on the bus, beside a daemon that gives and takes control."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from hub.doors.panels.panel_drive import PanelDrive
from hub.doors.panels.wishes import Panel, PanelCommand, SenderKind
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.control import (
    CONTROL_REQUEST,
    CONTROL_STATE,
    ControlAction,
    ControlRequest,
    ControlState,
)
from hub.gcm.navigation import STOP, VELOCITY_COMMAND, Stop
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.ipc.security.publish_rights import ROBOMON
from tests.support.waiting import until

ONE, OTHER = (1, 1), (2, 1)
PANEL = SenderKind(owner="a panel", noun="panel", release="release it", rate="set 10 Hz")
NODE = SenderKind(owner="a node", noun="node", release="end its velocities", rate="send 10 Hz")


class Site:
    """A bus with a daemon that gives control to who asks, and a door's driving.

    Attributes:
        sent: Speeds that came to the bus.
        asked: Orders about control.
        said: Texts for the people at the panels.
        refusal: Why control is refused; empty: it is given.
    """

    def __init__(self, endpoint: str, sender: SenderKind) -> None:
        self.sent: list[float] = []
        self.asked: list[ControlAction] = []
        self.said: list[str] = []
        self.refusal = ""
        self.daemon = Client(ROBOMON, endpoint)
        self.client = Client("door", endpoint, loop=self.daemon.loop)
        self.daemon.respond(CONTROL_REQUEST, COMMON_RESULT, self._order)
        self.daemon.define(CONTROL_STATE, STOP)
        self.daemon.subscribe(
            VELOCITY_COMMAND, lambda value, _: self.sent.append(value.twist.linear.x), queue=100
        )
        self.drive = PanelDrive(self.client, sender, self.said.append)
        for each in (self.daemon, self.client):
            each.wait_connected(5.0)
            each.wait_subscribed(5.0)
            each.wait_defined(5.0)
        self.daemon.wait_published(5.0)

    def _order(self, request: ControlRequest) -> CommonResult:
        self.asked.append(request.action)
        if request.action is ControlAction.TAKE:
            if self.refusal:
                return CommonResult(done=0, text=self.refusal)
            self.state(owner=self.client.number)
        return CommonResult(done=1, text="done")

    def state(self, owner: int, asker: int = 0, why: str = "") -> None:
        self.daemon.publish(CONTROL_STATE, ControlState(owner=owner, asker=asker, why=why))

    def press(self, ahead: float, panel: Panel = ONE) -> None:
        data = json.dumps({"linear": {"x": ahead}}).encode()
        command = PanelCommand(
            panel=panel, encoding="json", schema_name="geometry_msgs/Twist", data=data,
            came=time.monotonic(),
        )  # fmt: skip
        self.drive.obey(command)

    def wait(self, condition: Callable[[], object], *, held: float = 0.0) -> None:
        """Until something holds; meanwhile a button is held, if a speed is given."""

        def meanwhile() -> None:
            if held:
                self.press(held)
            self.daemon.listen(0.01)

        until(condition, 10.0, lambda: f"{self.sent} {self.asked} {self.said}", meanwhile=meanwhile)


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with opened(tmp_path, PANEL) as made:
        yield made


@contextmanager
def opened(folder: Path, sender: SenderKind) -> Iterator[Site]:
    with closing(Central([f"ipc://{folder}/c"])) as central:
        made = Site(central.endpoints[0], sender)
        with closing(made.daemon), closing(made.client):
            yield made


def test_control_and_neutral_come_before_the_first_velocity(site: Site) -> None:
    site.press(0.5)
    assert site.sent == []
    site.wait(lambda: site.sent, held=0.5)
    begun = time.monotonic()
    site.wait(lambda: 0.5 in site.sent, held=0.5)
    assert site.sent[0] == 0.0
    assert time.monotonic() - begun > 0.05  # a receiver that keeps the newest sees both
    assert site.asked == [ControlAction.TAKE]


def test_silence_is_a_release(site: Site) -> None:
    site.wait(lambda: 0.5 in site.sent, held=0.5)
    last, pressed = len(site.sent), time.monotonic()
    site.wait(lambda: site.sent[-1] == 0.0)
    assert 0.2 < time.monotonic() - pressed < 3.0
    site.wait(lambda: len(site.sent) > last + 3)  # neutral goes on at a slow rate
    site.wait(lambda: 0.4 in site.sent, held=0.4)
    assert site.asked == [ControlAction.TAKE]


def test_a_panel_that_is_gone_is_released_at_once(site: Site) -> None:
    site.wait(lambda: 0.5 in site.sent, held=0.5)
    site.drive.follow(frozenset({OTHER}))
    site.press(0.3, OTHER)  # it need not wait for the first one's silence
    assert site.drive.refused["another panel drives"] == 0
    site.wait(lambda: site.sent[-1] == 0.0)


def test_after_a_stop_nothing_is_sent_until_the_panel_is_released(site: Site) -> None:
    site.wait(lambda: 0.5 in site.sent, held=0.5)
    site.daemon.publish(STOP, Stop(reason="a child"))
    site.wait(lambda: any("a child" in each for each in site.said), held=0.5)
    site.daemon.listen(0.05)
    site.sent.clear()
    end = time.monotonic() + 0.5
    site.wait(lambda: time.monotonic() > end, held=0.5)
    assert not any(site.sent)
    site.press(0.0)
    site.wait(lambda: 0.5 in site.sent, held=0.5)


def test_a_refusal_is_shown_and_asked_again_only_after_a_release(site: Site) -> None:
    site.refusal = "alice has control"
    site.wait(lambda: site.said, held=0.5)
    assert "alice has control" in site.said[0]
    for _ in range(20):
        site.press(0.5)
        site.daemon.listen(0.01)
    assert site.asked == [ControlAction.TAKE]
    assert site.sent == []


def test_a_flood_of_presses_floods_neither_the_hub_nor_the_people(site: Site) -> None:
    site.refusal = "alice has control"
    begun = time.monotonic()
    while time.monotonic() < begun + 1.0:
        site.press(0.5)
        site.press(0.0)
        site.press(math.nan)
        site.daemon.listen(0.001)
    seconds = time.monotonic() - begun
    assert 1 <= len(site.asked) <= 1 + seconds / 0.5
    assert 1 <= len(site.said) <= 1 + seconds / 0.2


def test_control_that_is_lost_ends_the_velocities(site: Site) -> None:
    site.wait(lambda: 0.5 in site.sent, held=0.5)
    site.state(owner=site.daemon.number, why="alice took control")
    site.wait(lambda: any("alice took control" in each for each in site.said), held=0.5)
    site.daemon.listen(0.05)
    site.sent.clear()
    for _ in range(10):
        site.press(0.5)
        site.daemon.listen(0.01)
    assert site.sent == []


def test_who_asks_gets_control_while_no_panel_drives(site: Site) -> None:
    site.wait(lambda: 0.5 in site.sent, held=0.5)
    site.state(owner=site.client.number, asker=site.daemon.number)
    for _ in range(10):
        site.press(0.5)
        site.daemon.listen(0.01)
    assert ControlAction.GRANT not in site.asked
    site.wait(lambda: ControlAction.GRANT in site.asked)
    assert site.sent[-1] == 0.0


def test_a_panel_that_is_too_slow_is_named(site: Site) -> None:
    for _ in range(4):
        site.press(0.5)
        end = time.monotonic() + 0.3
        site.wait(lambda: time.monotonic() > end)  # noqa: B023 - called in this turn only
    assert any("10 Hz" in each for each in site.said)


def test_old_commands_are_not_followed(site: Site) -> None:
    data = b'{"linear": {"x": 1}}'
    command = PanelCommand(
        panel=ONE, encoding="json", schema_name="geometry_msgs/Twist", data=data,
        came=time.monotonic() - 0.3,
    )  # fmt: skip
    site.drive.obey(command)
    assert site.drive.refused["late"] == 1
    site.daemon.listen(0.05)
    assert site.asked == []


def test_commands_that_cannot_be_read_are_counted_and_said_once(site: Site) -> None:
    begun = time.monotonic()
    while time.monotonic() < begun + 0.7:
        site.press(math.nan)
        site.press(1e300)
        site.daemon.listen(0.001)
    assert site.drive.refused["unreadable"] > 10
    assert [each for each in site.said if each] == site.said[:1]
    assert "cannot be read (1 so far): x of a velocity in JSON is no number" in site.said[0]
    assert (site.sent, site.asked) == ([], [])


def test_every_sentence_names_the_kind_of_sender(tmp_path: Path) -> None:
    with opened(tmp_path, NODE) as site:
        site.press(math.nan)
        site.wait(lambda: site.said)
        for _ in range(4):
            site.press(0.5)
            end = time.monotonic() + 0.3
            site.wait(lambda: time.monotonic() > end)  # noqa: B023 - called in this turn only
        site.wait(lambda: site.sent and site.sent[-1] == 0.5, held=0.5)
        site.daemon.publish(STOP, Stop(reason="a child"))
        site.wait(lambda: any("a child" in each for each in site.said), held=0.5)
        site.press(0.0)
        site.state(owner=site.daemon.number, why="alice took control")
        site.wait(lambda: not site.drive.mine)
        site.refusal = "alice has control"
        site.wait(lambda: any("alice has" in each for each in site.said), held=0.5)
        assert not any("panel" in each for each in site.said)
        for words in ("a node cannot be read", "the node sends too slowly to drive: send 10 Hz"):
            assert any(words in each for each in site.said), words
        assert any("a child): to drive by this node, end its vel" in each for each in site.said)
        assert any("the node cannot drive: alice has control" in each for each in site.said)
