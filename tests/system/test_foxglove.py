"""A hub in Foxglove: real processes, and a program with its protocol."""

from __future__ import annotations

import contextlib
import json
import random
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
from websockets.exceptions import ConnectionClosed

from hub.gcm.common import COMMON_RESULT
from hub.gcm.control import CONTROL_REQUEST, ControlAction, ControlRequest
from hub.gcm.navigation import GROUND_TRUTH, ROBOT_STATE, STOP, VELOCITY_COMMAND, Stop
from hub.ipc.client import Client
from tests.support.foxglove_panel import DoorProcess, Panels
from tests.support.waiting import within
from tests.system.door_stops import STOP_S, free, stopped_after
from tests.system.harness import HubProcess, Observer, expect_stop, in_soak

HUB = {"modules": ("driver", "navigation", "vision", "mapping")}
FLOOD = 5_000


@pytest.fixture(scope="module")
def hub(lasting_hub: HubProcess) -> HubProcess:
    return lasting_hub


@pytest.fixture(scope="module")
def door(hub: HubProcess) -> Iterator[DoorProcess]:
    with closing(DoorProcess(hub.endpoint, "--drive")) as opened:
        yield opened


@pytest.fixture
def panels(door: DoorProcess, stack: ExitStack) -> Panels:
    return stack.enter_context(closing(Panels(door.address)))


@pytest.fixture
def observer(hub: HubProcess, stack: ExitStack) -> Observer:
    return stack.enter_context(closing(Observer(hub.endpoint, GROUND_TRUTH)))


def subscriptions(client: Client) -> set[str]:
    """What the door has subscribed to at the hub."""
    return {
        name
        for peer in client.directory.listing(5.0).peers
        if peer.name.startswith("rune-hub-serve")
        for name in peer.subscribes.split()
    }


def test_a_message_comes_unchanged_and_only_while_it_is_shown(
    panels: Panels, hub: HubProcess
) -> None:
    topic = f"/rune/{ROBOT_STATE.name}"
    with closing(Client("looks", hub.endpoint)) as client:
        client.wait_connected(5.0)
        assert ROBOT_STATE.name not in subscriptions(client)
        sent: set[bytes] = set()
        client.gather(lambda messages: sent.update(each[1] for each in messages))
        client.subscribe_gathered(ROBOT_STATE, "state")
        client.wait_subscribed(5.0)
        panels.show(topic)

        def both() -> bool:
            client.listen(0.01)
            return len(sent & set(panels.payloads[topic])) > 5

        panels.wait(both, why="payloads of the bus and the door differ;")
        assert ROBOT_STATE.name in subscriptions(client)
        assert abs(panels.stamps[topic][-1] - time.time_ns()) < 2e9
        assert panels.newest(topic).motion in range(7)
        panels.hide(topic)
        panels.wait(lambda: ROBOT_STATE.name not in subscriptions(client))


def test_standard_topics_are_what_tools_of_ros_read(panels: Panels) -> None:
    shown = {
        "/odom": "nav_msgs/msg/Odometry",
        "/scan": "sensor_msgs/msg/LaserScan",
        "/scan/sonar": "sensor_msgs/msg/LaserScan",
        "/scan/infrared": "sensor_msgs/msg/LaserScan",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/tf_static": "tf2_msgs/msg/TFMessage",
        "/battery_state": "sensor_msgs/msg/BatteryState",
        "/camera/camera/image/compressed": "sensor_msgs/msg/CompressedImage",
        "/camera/camera/camera_info": "sensor_msgs/msg/CameraInfo",
        "/map": "nav_msgs/msg/OccupancyGrid",
        "/rune/marks": "visualization_msgs/msg/MarkerArray",
        "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
        "/rosout": "rcl_interfaces/msg/Log",
    }
    assert {name: panels.topics[name]["schemaName"] for name in shown} == shown
    panels.show(*shown)
    assert bytes(panels.newest("/camera/camera/image/compressed").data[:2]) == b"\xff\xd8"
    assert panels.newest("/camera/camera/camera_info").header.frame_id == "camera_optical"
    assert len(panels.newest("/scan").ranges) == len(panels.newest("/scan/sonar").ranges) > 4
    frames = {each.child_frame_id for each in panels.newest("/tf_static").transforms}
    assert {"camera", "camera_optical", "sonar"} <= frames
    grid = panels.newest("/map")
    assert len(grid.data) == grid.info.width * grid.info.height > 0
    assert panels.newest("/odom").child_frame_id == "base_link"
    assert panels.newest("/rosout").msg
    panels.wait(lambda: all(panels.payloads[each] for each in shown))


def test_who_comes_later_gets_what_is_sent_once(panels: Panels, door: DoorProcess) -> None:
    once = ("/tf_static", "/rune/GCM_RobotDescription")
    panels.show(*once)
    panels.wait(lambda: all(panels.payloads[each] for each in once))
    with closing(Panels(door.address)) as other:
        other.show(*once)
        assert other.newest(once[1]).name == "magellan"
        other.wait(lambda: other.payloads[once[0]])
        assert other.payloads[once[0]][-1] == panels.payloads[once[0]][0]


def test_parameters_are_facts_that_nobody_sets(panels: Panels) -> None:
    panels.set_parameter("limit.surge_m_per_s", 50.0)
    panels.ask_parameters()
    panels.wait(lambda: "robot.kind" in panels.parameters)
    assert panels.parameters["robot.name"] == "magellan"
    assert panels.parameters["limit.surge_m_per_s"] == 0.5


def hold(panels: Panels, observer: Observer, ahead: float = 0.3) -> float:
    """Hold a button until the robot drives; returns when the last velocity was sent [s]."""
    sent = 0.0

    def driven() -> bool:
        nonlocal sent
        if time.monotonic() - sent > 0.08:
            panels.twist(ahead)
            sent = time.monotonic()
        observer.client.listen(0.01)
        return observer.truth.linear * ahead > 0.02

    panels.wait(driven, why="the robot does not drive;")
    return sent


def test_a_panel_drives_and_its_silence_stops_the_robot(panels: Panels, observer: Observer) -> None:
    panels.teleop()
    sent = hold(panels, observer)
    assert within(stopped_after(observer, sent), STOP_S)
    hold(panels, observer, -0.3)  # and again, without waiting for control
    panels.twist(0.0)
    expect_stop(observer)
    hold(panels, observer)
    panels.close()
    expect_stop(observer)
    free(observer.client)


def test_a_panel_that_sends_zeros_is_not_too_slow(panels: Panels, observer: Observer) -> None:
    panels.teleop()
    for ahead in (0.3, -0.3):
        hold(panels, observer, ahead)
        panels.twist(0.0)
        expect_stop(observer)
    assert not any("too slowly" in each for each in panels.said)
    free(observer.client)


def test_a_stop_of_another_operator_holds_until_the_button_is_released(
    panels: Panels, observer: Observer
) -> None:
    panels.teleop()
    hold(panels, observer)
    observer.client.publish(STOP, Stop(reason="alice is near"))

    def stopped() -> bool:
        panels.twist(0.3)
        observer.client.listen(0.05)
        said = any("alice is near" in each for each in panels.said)
        return said and observer.truth.commanded_linear == 0.0

    panels.wait(stopped, why="the button drives on;")
    observer.history.clear()
    for _ in range(5):
        panels.twist(0.3)
        observer.client.listen(0.08)
    assert all(truth.commanded_linear == 0.0 for _, truth in observer.history)
    panels.twist(0.0)
    hold(panels, observer)
    free(observer.client)


def test_only_one_panel_drives_at_a_time(
    panels: Panels, door: DoorProcess, observer: Observer
) -> None:
    with closing(Panels(door.address)) as other:
        panels.teleop()
        other.teleop()
        hold(panels, observer)
        observer.history.clear()
        for _ in range(10):
            panels.twist(0.3)
            other.twist(-0.3)
            panels.pump(0.08)
            observer.client.listen(0.0)
        assert min(truth.commanded_linear for _, truth in observer.history) >= 0.0
        expect_stop(observer)
        hold(other, observer, -0.2)
    free(observer.client)


def test_nothing_moves_while_another_operator_has_control(
    panels: Panels, observer: Observer
) -> None:
    request = ControlRequest(action=ControlAction.TAKE, operator="alice")
    taken = observer.client.query_response(CONTROL_REQUEST, request, COMMON_RESULT, timeout=5.0)
    assert taken.done, taken
    sent: list[bool] = []
    observer.client.subscribe(VELOCITY_COMMAND, lambda twist, _: sent.append(twist.neutral))
    observer.client.wait_subscribed(5.0)
    panels.teleop()

    def refused() -> bool:
        panels.twist(0.3)
        observer.client.listen(0.01)
        return any("alice has control" in each for each in panels.said)

    panels.wait(refused, why="the panel gets no refusal;")
    assert observer.truth.commanded_linear == 0.0
    assert all(sent)
    free(observer.client)


def test_the_robot_stops_when_the_door_is_killed(
    hub: HubProcess, observer: Observer, stack: ExitStack
) -> None:
    door = DoorProcess(hub.endpoint, "--drive")
    stack.callback(door.close)
    with closing(Panels(door.address)) as panels:
        panels.teleop()
        hold(panels, observer)
        door.process.send_signal(signal.SIGKILL)
        assert within(stopped_after(observer, time.monotonic()), STOP_S)
    free(observer.client)


@pytest.mark.parametrize("count", [FLOOD, *in_soak(20 * FLOOD)])
def test_a_flood_of_frames_moves_nothing_and_ends_nothing(
    panels: Panels, door: DoorProcess, observer: Observer, count: int
) -> None:
    frames: list[tuple[bytes, int]] = [
        (b"", 1), (random.Random(1).randbytes(40), 1), (b"[" * 3000, 1),
        (b'{"linear": {"x": NaN}}', 1),
        (b'{"linear": {"x": 1e999}}', 1), (b'{"linear": 3}', 1), (b"\x00" * 5000, 1),
        (b"{}", 77), (b'{"linear": {"x": true}}', 1), (b'{"linear": {"x": 1e6}}', 1),
    ]  # fmt: skip
    left = count // len(frames)
    while left:
        # The door disconnects a program that reads none of its statuses.
        with contextlib.suppress(ConnectionClosed), closing(Panels(door.address)) as hostile:
            hostile.teleop()
            while left:
                left -= 1
                for payload, channel in frames:
                    hostile.send(payload, channel)
                if not left % 100:
                    hostile.send_raw('{"op":"subscribe"' if left % 200 else b"\xfe\x00")
    observer.client.listen(0.0)
    panels.show("/odom")
    panels.newest("/odom")
    assert door.process.poll() is None
    assert all(truth.commanded_linear == 0.0 for _, truth in observer.history)


def test_a_door_without_driving_takes_no_commands(
    hub: HubProcess, observer: Observer, tmp_path: Path
) -> None:
    layout = tmp_path / "layout.json"
    with closing(DoorProcess(hub.endpoint, "--layout", str(layout))) as door:
        assert door.ready["layout"] == str(layout)
        image = json.loads(layout.read_text())["configById"]["Image!rune"]["imageMode"]
        assert image["imageTopic"] == "/camera/camera/image/compressed"
        with closing(Panels(door.address)) as panels:
            assert "clientPublish" not in panels.info["capabilities"]
            panels.teleop()
            for _ in range(10):
                panels.twist(0.3)
                panels.pump(0.05)
            assert observer.truth.commanded_linear == 0.0


Start = Callable[..., HubProcess]


def test_a_door_stays_open_when_the_hub_comes_back(start_hub: Start, stack: ExitStack) -> None:
    hub = start_hub(modules=("driver", "navigation"), name="again")
    door = stack.enter_context(closing(DoorProcess(hub.endpoint)))
    panels = stack.enter_context(closing(Panels(door.address)))
    panels.show("/odom")
    panels.newest("/odom")
    hub.close()
    panels.payloads.clear()
    start_hub(modules=("driver", "navigation"), name="again")
    panels.newest("/odom")
