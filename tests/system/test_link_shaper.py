"""A link shaper between a client and a real hub: what passes, what is published, who stops."""

from __future__ import annotations

import json
import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

import psutil
import pytest

from hub.errors import LinkShaperError
from hub.gcm import navigation, vision
from hub.gcm.geometry import TwistStamped
from hub.gcm.shaper import SHAPER_STATE, ShaperState
from hub.ipc.client import Client
from hub.ipc.roles import Role
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.keyring import Keyring
from hub.shaper.shaped_link import ShapedLink
from tests.support.ports import free_port
from tests.support.waiting import until, within
from tests.system.harness import HubProcess, Observer

STOP_S = 0.35
BLACKOUT = "delay_ms = 5\n[blackouts]\ngap_s = [4, 6]\nlength_s = [3, 4]\n"


@pytest.fixture(scope="module")
def hub(tmp_path_factory: pytest.TempPathFactory) -> HubProcess:  # type: ignore[misc]
    """A hub at TCP port 0: seven ports that stand in no row."""
    with closing(HubProcess(tmp_path_factory.mktemp("hub"), options=("--listen", "0"))) as running:
        yield running  # type: ignore[misc]


def client(stack: ExitStack, link: ShapedLink, name: str, **options: object) -> Client:
    """A connected client behind the link."""
    made = Client(name, link.endpoint, **options)  # type: ignore[arg-type]
    stack.callback(made.close)
    made.wait_connected(15.0)
    return made


def test_a_client_on_the_hubs_machine_sends_all_through_the_link(
    hub: HubProcess, stack: ExitStack
) -> None:
    link = stack.enter_context(ShapedLink(hub.endpoint, "threshold", 7))
    far = client(stack, link, "far")
    assert not far.near
    ages: list[float] = []
    far.subscribe(navigation.ROBOT_STATE, lambda _, how: ages.append(how.age))
    until(lambda: len(ages) > 40, 20.0, meanwhile=lambda: far.listen(0.01))
    assert min(ages) > 0.05
    assert 0.1 < statistics.median(ages) < 0.4
    until(lambda: far.round_trip > 0.1, 10.0, meanwhile=lambda: far.listen(0.01))


def test_the_state_is_on_the_hub_and_in_the_file(
    hub: HubProcess, stack: ExitStack, tmp_path: Path
) -> None:
    log = tmp_path / "link.jsonl"
    link = stack.enter_context(ShapedLink(hub.endpoint, "wifi-edge", 42, log=log))
    observer = stack.enter_context(closing(Observer(hub.endpoint, SHAPER_STATE)))
    far = client(stack, link, "watching")
    states = observer.seen[SHAPER_STATE.name]

    def newest() -> ShaperState:
        state: ShaperState = states[-1][1]
        return state

    observer.wait(lambda: newest().connections > 0 and newest().down.packets > 0, 10.0)
    state = newest()
    assert (state.profile, state.seed) == ("wifi-edge", 42)
    assert state.digest == link.ready["sha256"]
    assert link.endpoint == f"tcp://{state.address}:{hub.listening['tcp'].rpartition(':')[2]}"
    assert 0.0 < state.down.delay < 5.0
    far.close()
    until(lambda: link.state.get("elapsed_s", 0.0) >= state.elapsed, 5.0)
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    assert [each["event"] for each in lines[:2]] == ["ready", "state"]
    assert any(each["connections"] for each in lines[1:])


class Driver:
    """Drives the robot through a link, and sees from the hub's side what its wheels get."""

    def __init__(self, hub: HubProcess, stack: ExitStack, link: ShapedLink) -> None:
        self.observer = stack.enter_context(
            closing(Observer(hub.endpoint, navigation.ROBOT_STATE, navigation.DRIVE_STATE))
        )
        self._client = client(stack, link, f"driver-{link.pid}")
        self._client.every(0.05, self._send)
        self._twist = TwistStamped.planar(0.0, 0.0)
        self.drive_until(lambda: self.motion is navigation.MotionState.STANDING)
        self._twist = TwistStamped.planar(0.0, 0.5)
        self.drive_until(lambda: abs(self.commanded) > 0.1)

    def _send(self) -> None:
        self._client.publish(navigation.VELOCITY_COMMAND, self._twist, measured=time.monotonic())

    @property
    def motion(self) -> navigation.MotionState:
        """What navigation does."""
        state: navigation.RobotState = self.observer.seen[navigation.ROBOT_STATE.name][-1][1]
        return state.motion

    @property
    def commanded(self) -> float:
        """The turn rate that the driver has commanded last [rad/s]."""
        state: navigation.DriveState = self.observer.seen[navigation.DRIVE_STATE.name][-1][1]
        return state.commanded.angular.z

    def drive_until(self, condition: Callable[[], object]) -> None:
        """Go on sending commands."""
        until(condition, 20.0, meanwhile=self._serve)

    def _serve(self) -> None:
        self._client.listen(0.005)
        self.observer.client.listen(0.005)

    def stopped_after(self, since: float) -> float:
        """When the wheels first got zero after a moment, from then on [s]."""
        self.drive_until(lambda: self.commanded == 0.0)
        history = self.observer.seen[navigation.DRIVE_STATE.name]
        still = [at for at, state in history if at >= since and state.commanded.angular.z == 0.0]
        return still[0] - since


def test_a_killed_shaper_is_a_cut_link(hub: HubProcess, stack: ExitStack) -> None:
    link = stack.enter_context(ShapedLink(hub.endpoint, "lan", 1))
    driver = Driver(hub, stack, link)
    os.kill(link.pid, signal.SIGKILL)
    assert within(driver.stopped_after(time.monotonic()), STOP_S)
    assert link.ended


@pytest.mark.soak
def test_in_a_blackout_the_robot_stops_and_afterwards_waits_for_neutral(
    hub: HubProcess, stack: ExitStack, tmp_path: Path
) -> None:
    profile = tmp_path / "gone.toml"
    profile.write_text(BLACKOUT)
    link = stack.enter_context(ShapedLink(hub.endpoint, str(profile), 3))
    watcher = stack.enter_context(closing(Observer(hub.endpoint, SHAPER_STATE)))
    states = watcher.seen[SHAPER_STATE.name]
    watcher.wait(lambda: states[-1][1].blackout == 1, 20.0)
    watcher.wait(lambda: states[-1][1].blackout == 0, 20.0)
    driver = Driver(hub, stack, link)
    driver.drive_until(lambda: watcher.client.listen(0.0) or states[-1][1].blackout == 1)
    # The blackout is seen up to 0.05 s late.
    assert within(driver.stopped_after(states[-1][0]), STOP_S + 0.05)
    watcher.wait(lambda: states[-1][1].blackout == 0, 20.0)
    began = time.monotonic()
    driver.drive_until(lambda: time.monotonic() - began > 2.0)
    assert driver.commanded == 0.0


def test_a_stop_reaches_the_robot_over_half_a_second(
    hub: HubProcess, stack: ExitStack, tmp_path: Path
) -> None:
    profile = tmp_path / "far.toml"
    profile.write_text("delay_ms = 250\njitter_ms = 50\nrate_kbit = 256\n")
    lan = stack.enter_context(ShapedLink(hub.endpoint, "lan", 1))
    far = stack.enter_context(ShapedLink(hub.endpoint, str(profile), 4))
    driver = Driver(hub, stack, lan)
    command = [sys.executable, "-m", "hub", "halt", "--hub", far.endpoint]
    halting = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    driver.drive_until(lambda: halting.poll() is not None)
    said, _ = halting.communicate()
    assert (halting.returncode, said[:16]) == (0, "the robot stands")
    assert driver.commanded == 0.0


def test_cameras_give_as_many_pictures_as_the_profile_says(
    hub: HubProcess, stack: ExitStack
) -> None:
    link = stack.enter_context(ShapedLink(hub.endpoint, "fps-2", 1))
    far = client(stack, link, "eye")
    request = vision.ImageRequest(width_px=32, height_px=24)

    def taken() -> float:
        image = far.query_response(vision.IMAGE_REQUEST, request, vision.IMAGE, timeout=5.0)
        return image.camera.stamp

    until(lambda: link.state, 5.0)
    stamps = {taken() for _ in range(3)}  # the limit is known by now
    began = time.monotonic()
    while time.monotonic() < began + 3.0:
        stamps.add(taken())
    assert 5 <= len(stamps) <= 10


def test_a_key_passes_through_the_link_to_a_gateway(tmp_path: Path, stack: ExitStack) -> None:
    keyring = Keyring(tmp_path / "keys")
    paths = {role: keyring.make(role.value, role) for role in (Role.OPERATE, Role.MODULE)}
    gateway = free_port()
    lines = f'gateway = "tcp://127.0.0.1:{gateway}"\nkeys = "{tmp_path / "keys"}"'
    running = stack.enter_context(closing(HubProcess(tmp_path, gateway=lines)))
    endpoint = f"tcp://127.0.0.1:{gateway}"
    link = stack.enter_context(ShapedLink(endpoint, "wifi-good", 5, keys=paths[Role.MODULE]))
    observer = stack.enter_context(closing(Observer(running.endpoint, SHAPER_STATE)))
    far = client(stack, link, "keyed", keys=read_client_keys(paths[Role.OPERATE]))
    states: list[float] = []
    far.subscribe(navigation.ROBOT_STATE, lambda _, how: states.append(how.age))
    until(lambda: len(states) > 5, 10.0, meanwhile=lambda: far.listen(0.01))
    until(lambda: far.round_trip > 0.01, 5.0, meanwhile=lambda: far.listen(0.01))
    observer.wait(lambda: observer.seen[SHAPER_STATE.name][-1][1].connections > 0, 10.0)


def test_a_key_that_may_not_publish_states_shapes_all_the_same(
    tmp_path: Path, stack: ExitStack
) -> None:
    keyring = Keyring(tmp_path / "keys")
    key = keyring.make("alice", Role.OBSERVE)
    gateway = free_port()
    lines = f'gateway = "tcp://127.0.0.1:{gateway}"\nkeys = "{tmp_path / "keys"}"'
    stack.enter_context(closing(HubProcess(tmp_path, gateway=lines)))
    link = stack.enter_context(
        ShapedLink(f"tcp://127.0.0.1:{gateway}", "lan", 5, keys=key, log=tmp_path / "log")
    )
    until(lambda: link.state, 5.0)
    assert client(stack, link, "keyed", keys=read_client_keys(key)).connected


def test_the_shaper_ends_with_its_starter_and_frees_its_address(
    hub: HubProcess, stack: ExitStack
) -> None:
    first = ShapedLink(hub.endpoint, "lan", 1)
    second = stack.enter_context(ShapedLink(hub.endpoint, "lan", 1))
    assert first.endpoint != second.endpoint
    process = psutil.Process(first.pid)
    first.close()
    assert not process.is_running()
    third = stack.enter_context(ShapedLink(hub.endpoint, "lan", 1))
    assert third.endpoint == first.endpoint


def test_what_cannot_start_says_why(hub: HubProcess, tmp_path: Path) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text("los = 1\n")
    for profile, at, part in (
        (str(bad), "", "did you mean 'loss'"),
        ("lan", "0.0.0.0", "without keys only this machine"),
        ("lan", "127.0.0.1", "cannot listen"),
    ):
        with pytest.raises(LinkShaperError, match=part):
            ShapedLink(hub.endpoint, profile, 1, at=at)
