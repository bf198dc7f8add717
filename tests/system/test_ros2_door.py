"""A robot as a node of ROS 2: real processes and router, and nodes that know nothing of Rune."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from hub.doors.fleet.certificates import Certificates
from hub.doors.panels.panel_drive import SILENCE_S
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import DRIVE_STATE, GROUND_TRUTH, VELOCITY_COMMAND
from hub.ipc.client import Client
from hub.ros.rmw_zenoh import HASH_OF_HUMBLE
from tests.support.command_line import rune_hub
from tests.support.ports import free_port
from tests.support.ros_node import STORE, Paced, RosNode, dds, encoded
from tests.support.running_command import RunningCommand
from tests.support.sdk_nodes import SdkNode
from tests.support.waiting import until, within
from tests.support.zenoh_router import ZenohRouter, zenoh_router
from tests.system.door_stops import STOP_S, free, stopped_after
from tests.system.harness import HubProcess, Observer, expect_stop

TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
TYPES = STORE.types
HUB = {"modules": ("driver", "navigation", "vision", "mapping")}


class Ros2Door(RunningCommand):
    """`rune-hub serve ros2`."""

    def __init__(self, hub: str, router: str, *options: str) -> None:
        super().__init__("serve", "ros2", "--hub", hub, "--connect", router, *options)


class Teleop:
    """A node that shows topics and drives."""

    def __init__(self, endpoint: str) -> None:
        self.node = RosNode(endpoint, "teleop")
        self.came: dict[str, list[bytes]] = defaultdict(list)

    def show(self, topic: str, kind: str, *, latched: bool = False) -> None:
        def take(payload: bytes, attached: bytes) -> None:
            assert len(attached) == 33
            self.came[topic].append(payload)

        self.node.subscribe(topic, kind, take, latched=latched)

    def newest(self, topic: str, kind: str) -> Any:
        until(lambda: self.came[topic], 20.0, f"nothing came on {topic}")
        return STORE.deserialize_cdr(self.came[topic][-1], kind)


def twist(kind: str, ahead: float) -> bytes:
    vector = TYPES["geometry_msgs/msg/Vector3"]
    speed = TYPES[TWIST](linear=vector(x=ahead, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0))
    if kind == TWIST:
        return encoded(TWIST, speed)
    header = TYPES["std_msgs/msg/Header"](
        stamp=TYPES["builtin_interfaces/msg/Time"](sec=0, nanosec=0), frame_id=""
    )
    return encoded(STAMPED, TYPES[STAMPED](header=header, twist=speed))


@pytest.fixture(scope="module")
def router() -> Iterator[ZenohRouter]:
    with zenoh_router() as running:
        yield running


@pytest.fixture(scope="module")
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture(scope="module")
def door(hub: HubProcess, router: ZenohRouter) -> Iterator[Ros2Door]:
    with closing(Ros2Door(hub.endpoint, router.endpoint, "--drive")) as opened:
        yield opened


@pytest.fixture
def teleop(door: Ros2Door, router: ZenohRouter) -> Iterator[Teleop]:
    assert door.ready["router"] == router.endpoint
    made = Teleop(router.endpoint)
    yield made
    made.node.leave()


@pytest.fixture
def observer(hub: HubProcess, stack: ExitStack) -> Observer:
    return stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH)))


def test_standard_topics_come_as_nodes_read_them(teleop: Teleop) -> None:
    shown = {
        "/odom": "nav_msgs/msg/Odometry",
        "/scan": "sensor_msgs/msg/LaserScan",
        "/scan/sonar": "sensor_msgs/msg/LaserScan",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/battery_state": "sensor_msgs/msg/BatteryState",
        "/camera/camera/image/compressed": "sensor_msgs/msg/CompressedImage",
        "/camera/camera/camera_info": "sensor_msgs/msg/CameraInfo",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    }
    latched = {"/tf_static": "tf2_msgs/msg/TFMessage", "/map": "nav_msgs/msg/OccupancyGrid"}
    for topic, kind in shown.items():
        teleop.show(topic, kind)
    for topic, kind in latched.items():
        teleop.show(topic, kind, latched=True)
    for topic, kind in (shown | latched).items():
        teleop.newest(topic, kind)
    picture = teleop.newest(
        "/camera/camera/image/compressed", shown["/camera/camera/image/compressed"]
    )
    assert bytes(picture.data[:2]) == b"\xff\xd8"
    grid = teleop.newest("/map", latched["/map"])
    assert len(grid.data) == grid.info.width * grid.info.height > 0
    frames = {
        each.child_frame_id
        for each in teleop.newest("/tf_static", latched["/tf_static"]).transforms
    }
    assert {"camera", "camera_optical", "sonar"} <= frames


def test_a_topic_is_made_while_it_has_a_subscriber(teleop: Teleop, hub: HubProcess) -> None:
    def subscribed(client: Client) -> bool:
        return any(
            DRIVE_STATE.name in peer.subscribes.split()
            for peer in client.directory.listing(5.0).peers
            if peer.name.startswith("rune-hub-serve")
        )

    with closing(Client("looks", hub.endpoint)) as client:
        client.wait_connected(5.0)
        assert not subscribed(client)
        teleop.show("/odom", "nav_msgs/msg/Odometry")
        teleop.newest("/odom", "nav_msgs/msg/Odometry")
        assert subscribed(client)
        teleop.node.leave()
        until(lambda: not subscribed(client), 10.0)


@pytest.mark.parametrize("kind", [TWIST, STAMPED])
def test_a_node_drives_and_its_silence_stops_the_robot(
    teleop: Teleop, observer: Observer, kind: str
) -> None:
    publish = teleop.node.publisher("/cmd_vel", kind)
    stick = Paced(lambda: publish(twist(kind, 0.3)), 20.0)
    observer.wait(lambda: observer.truth.commanded_linear > 0.02, 10.0, "it does not drive")
    stick.leave()
    assert within(stopped_after(observer, time.monotonic()), STOP_S)
    free(observer.client)


def test_the_robot_stops_when_the_door_is_killed(
    hub: HubProcess, router: ZenohRouter, observer: Observer, stack: ExitStack
) -> None:
    door = Ros2Door(hub.endpoint, router.endpoint, "--drive", "--namespace", "/rover")
    stack.callback(door.close)
    teleop = Teleop(router.endpoint)
    publish = teleop.node.publisher("/rover/cmd_vel", TWIST)
    stick = Paced(lambda: publish(twist(TWIST, 0.3)), 20.0)
    try:
        observer.wait(lambda: observer.truth.commanded_linear > 0.02, 10.0, "it does not drive")
        door.process.send_signal(signal.SIGKILL)
        assert within(stopped_after(observer, time.monotonic()), STOP_S)
    finally:
        stick.leave()
        teleop.node.leave()
    free(observer.client)


def test_a_hub_drives_the_robot_of_another_as_one_with_ros(
    router: ZenohRouter, door: Ros2Door, observer: Observer, start_hub: Callable[..., HubProcess]
) -> None:
    """Door and line meet; the stop is of the door, as the robot's own watchdog is."""
    address = f"zenoh+tcp://127.0.0.1:{router.port}?domain={door.ready['domain']}"
    table = f'\n[ros]\naddress = "{address}"\n'
    hub = start_hub(kind="ros", tables=table, modules=("driver", "navigation"))
    with closing(Observer(hub.endpoint, DRIVE_STATE)) as driver:
        forward, still = (TwistStamped.of(Twist.planar(speed, 0.0)) for speed in (0.3, 0.0))
        commands = [still] * 10 + [forward] * 10_000
        due = 0.0

        def hold() -> bool:
            nonlocal due
            if time.monotonic() > due:
                due = time.monotonic() + 0.05
                driver.client.publish(VELOCITY_COMMAND, commands.pop(0))
            driver.client.listen(0.005)
            return observer.truth.commanded_linear > 0.02

        observer.wait(hold, 20.0, "it does not drive")
        os.kill(hub.pids["driver"], signal.SIGKILL)
        assert within(stopped_after(observer, time.monotonic()), STOP_S)
    free(observer.client)


def held(push: Callable[[], None], observer: Observer) -> Paced:
    """A stick that drives; where that begins while control is freed, it is pushed again."""
    for wait_s in (3.0, 10.0):
        stick = Paced(push, 20.0)
        with contextlib.suppress(AssertionError):
            observer.wait(lambda: observer.truth.commanded_linear > 0.02, wait_s)
            return stick
        stick.leave()
        let_go(observer)
    pytest.fail("it does not drive")


def let_go(observer: Observer) -> None:
    """Let the time pass after which a node counts as silent."""
    end = time.monotonic() + 2.0 * SILENCE_S
    observer.wait(lambda: time.monotonic() > end, 5.0)


def test_velocities_that_waited_in_the_network_move_nothing(
    teleop: Teleop, observer: Observer, router: ZenohRouter
) -> None:
    publish = teleop.node.publisher("/cmd_vel", TWIST)
    stick = held(lambda: publish(twist(TWIST, 0.3)), observer)
    router.freeze()
    expect_stop(observer)
    stick.leave()
    observer.history.clear()
    router.thaw()
    publish(twist(TWIST, 0.0))
    observer.wait(lambda: len(observer.history) > 20, 5.0)
    assert all(truth.commanded_linear == 0.0 for _, truth in observer.history)
    free(observer.client)


@pytest.mark.parametrize("count", [5_000, pytest.param(100_000, marks=pytest.mark.soak)])
def test_bytes_of_anyone_move_nothing_and_end_nothing(
    teleop: Teleop, door: Ros2Door, observer: Observer, count: int
) -> None:
    chance = random.Random(5)
    keys = [f"0/cmd_vel/{dds(TWIST)}/{STORE.hash_rihs01(TWIST)}", "0/cmd_vel/x/y"]
    good = twist(TWIST, 0.3)
    for number in range(count):
        size = chance.choice((0, 32, 33, 33, 77))
        payload = chance.choice(
            (chance.randbytes(52), b"", good, good + good, chance.randbytes(9000))
        )
        attached = chance.randbytes(size) if payload is not good else chance.randbytes(size)[:20]
        teleop.node.put(chance.choice(keys), payload, attached)
        if number < 200:
            parts = chance.choices(["MP", "MS", "%", "ä", "0", ".."], k=11)
            teleop.node.announce(f"@ros2_lv/0/{'/'.join(parts)}/{number}")
    teleop.show("/odom", "nav_msgs/msg/Odometry")
    teleop.newest("/odom", "nav_msgs/msg/Odometry")
    assert door.process.poll() is None
    assert all(truth.commanded_linear == 0.0 for _, truth in observer.history)


def test_a_door_without_driving_takes_no_commands(
    hub: HubProcess, router: ZenohRouter, observer: Observer
) -> None:
    with closing(Ros2Door(hub.endpoint, router.endpoint, "--domain", "7")) as door:
        assert door.ready["domain"] == 7
        node = RosNode(router.endpoint, "teleop", domain=7)
        publish = node.publisher("/cmd_vel", TWIST)
        came: list[bytes] = []
        node.subscribe("/odom", "nav_msgs/msg/Odometry", lambda payload, _: came.append(payload))
        until(lambda: len(came) > 10, 10.0, meanwhile=lambda: publish(twist(TWIST, 0.3)))
        node.leave()
        assert all(truth.commanded_linear == 0.0 for _, truth in observer.history)


def test_nodes_of_humble_and_later_ones_see_the_robot_together(
    hub: HubProcess, router: ZenohRouter, stack: ExitStack
) -> None:
    with closing(Ros2Door(hub.endpoint, router.endpoint, "--domain", "8")):
        came: set[tuple[str, str]] = set()
        for release, hashed in (("jazzy", ""), ("humble", HASH_OF_HUMBLE)):
            node = RosNode(router.endpoint, release, domain=8)
            stack.callback(node.leave)
            for topic, kind in (
                ("/odom", "nav_msgs/msg/Odometry"), ("/tf_static", "tf2_msgs/msg/TFMessage")
            ):  # fmt: skip
                seen = (release, topic)
                node.subscribe(
                    topic,
                    kind,
                    lambda _, __, seen=seen: came.add(seen),
                    latched=topic == "/tf_static",
                    hashed=hashed,
                )
            both = {(release, "/odom"), (release, "/tf_static")}
            until(lambda both=both: both <= came, 20.0, lambda: f"{came}")


def test_the_door_joins_a_router_with_tls(hub: HubProcess, tmp_path: Path) -> None:
    made = Certificates(tmp_path / "authority")
    for name, role in (("localhost", "router"), ("rover", "robot")):
        made.make(name, role, days=2)
    came: list[bytes] = []
    with (
        zenoh_router(made.of_router()) as secure,
        closing(Ros2Door(hub.endpoint, secure.secure, "--tls", str(made.folder))) as door,
    ):
        assert door.ready["router"] == secure.secure
        node = RosNode(secure.endpoint, "looks")
        node.subscribe("/odom", "nav_msgs/msg/Odometry", lambda payload, _: came.append(payload))
        try:
            until(lambda: came, 10.0)
        finally:
            node.leave()


def test_what_cannot_be_opened_is_said(hub: HubProcess) -> None:
    where = f"tcp/127.0.0.1:{free_port()}"
    done = rune_hub("serve", "ros2", "--hub", hub.endpoint, "--connect", where)
    assert done.returncode != 0
    assert f"no Zenoh router answers at {where}" in done.stderr
    done = rune_hub("serve", "ros2", "--hub", hub.endpoint, "--namespace", "a b")
    assert "write one as /rover" in done.stderr
    done = rune_hub("serve", "ros2", "--hub", hub.endpoint, "--connect", where, "--tls", "folder")
    assert "--tls is for a router with TLS: --connect tls/HOST:7447" in done.stderr


def test_nodes_of_others_read_the_robot_and_drive_it(
    door: Ros2Door, router: ZenohRouter, observer: Observer
) -> None:
    assert door.ready
    with closing(SdkNode("driver", router.port)) as driver:
        observer.wait(lambda: observer.truth.linear > 0.1, 30.0, "the node does not drive")
        wanted = {"/odom", "/scan", "/tf", "/tf_static", "/map"}
        until(
            lambda: wanted <= set(driver.newest.get("came", ())), 30.0, lambda: f"{driver.newest}"
        )
        until(lambda: driver.newest["x"] != 0.0, 20.0)
    expect_stop(observer)
