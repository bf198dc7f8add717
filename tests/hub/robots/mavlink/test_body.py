"""A vehicle with an autopilot as a body: what the driver sees of it, and what it sends."""

from __future__ import annotations

import selectors
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hub.gcm.autopilot import AutopilotPhase, MavlinkFrames
from hub.gcm.diagnostics import Severity
from hub.gcm.geometry import Twist
from hub.gcm.vehicle import Arming
from hub.robots.description import RobotDescription
from hub.robots.interfaces import BodyJoints, BodyLights
from hub.robots.mavlink.body import MavlinkBody
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from hub.robots.robot_file import read_description
from tests.hub.robots.mavlink.robot_parts import PARTS
from tests.hub.robots.mavlink.udp_vehicle import UdpVehicle
from tests.support.mavlink_numbers import BLIMP, GUIDED, HOLD, ROVER

ROBOT = """
name = "rover"
kind = "mavlink"
[mavlink]
address = "{address}"
{more}
[body]
arming = "disarmed"
[limits]
linear = 1.0
"""
TICK_S = 0.05


def robot(folder: Path, address: str, kind: str = "") -> RobotDescription:
    path = folder / "robot.toml"
    path.write_text(ROBOT.format(address=address, more=f'vehicle = "{kind}"' if kind else ""))
    described, problems = read_description(path)
    assert not problems
    return described


class Scene:
    """A body and its vehicle, whose time passes in ticks."""

    def __init__(self, folder: Path, kind: int = ROVER, of_file: str = "") -> None:
        self.now = 100.0
        self.vehicle = UdpVehicle(kind)
        described = robot(folder, self.vehicle.address, of_file)
        self.body = MavlinkBody(described, clock=lambda: self.now)
        self.plays = True

    def wait(self, seconds: float, each: Callable[[], None] = lambda: None) -> None:
        """Let time pass; the vehicle sends heartbeats and its attitude, unless it does not play."""
        for tick in range(round(seconds / TICK_S)):
            if self.plays:
                if tick % 10 == 0:
                    self.vehicle.heartbeat()
                self.vehicle.attitude()
                each()
            self.body.advance(TICK_S)
            self.vehicle.answer()
            self.now += TICK_S

    def drive(self) -> None:
        """Until it is armed, and in the mode that follows velocities."""
        self.wait(5.0)
        self.body.arm(armed=True)
        self.wait(1.5)
        assert self.phase is AutopilotPhase.DRIVING

    def close(self) -> None:
        self.body.close()
        self.vehicle.close()

    @property
    def phase(self) -> AutopilotPhase:
        return self.body.autopilot(0.0).phase

    @property
    def problems(self) -> list[str]:
        return [each.message for each in self.body.sensors(0.0).diagnostics]


@pytest.fixture
def scene(tmp_path: Path) -> Iterator[Scene]:
    opened = Scene(tmp_path)
    yield opened
    opened.close()


class Files:
    """A loop with file descriptors, which waits for them when a test says so."""

    def __init__(self) -> None:
        self.watched: dict[int, Callable[[], None]] = {}

    def watch(self, file: int, work: Callable[[], None]) -> None:
        assert file not in self.watched
        self.watched[file] = work

    def unwatch(self, file: int) -> None:
        del self.watched[file]

    def serve(self) -> None:
        """Wait for the one that is watched, and serve it."""
        ((file, work),) = self.watched.items()
        with selectors.DefaultSelector() as selector:
            selector.register(file, selectors.EVENT_READ)
            assert selector.select(5.0)
        work()


def test_nothing_is_known_of_a_vehicle_before_it_is_heard(scene: Scene) -> None:
    scene.plays = False
    scene.wait(1.0)
    assert not scene.body.sensors(0.0).known
    assert scene.phase is AutopilotPhase.LINKING
    assert "the autopilot is silent" in scene.problems[0]


def test_it_is_armed_by_an_order_only_and_follows_velocities_then(scene: Scene) -> None:
    scene.wait(3.0)
    scene.body.command(Twist.planar(0.5, 0.0))
    scene.wait(1.0)
    assert not scene.vehicle.armed
    assert scene.body.sensors(0.0).vehicle.arming is Arming.DISARMED
    scene.drive()
    scene.body.command(Twist.planar(0.5, 0.0))
    assert not any(scene.vehicle.velocities()), "a stick that is deflected already moves nothing"
    scene.body.command(Twist())
    scene.body.command(Twist.planar(0.5, 0.0))
    scene.vehicle.answer()
    assert scene.vehicle.velocities()[-1] == 0.5, "a new velocity leaves at once"
    assert scene.body.sensors(0.0).commanded.linear.x == 0.5
    scene.body.command(Twist())
    scene.vehicle.answer()
    assert scene.vehicle.velocities()[-1] == 0.0


def test_a_vehicle_of_another_kind_than_the_robot_file_is_not_driven(tmp_path: Path) -> None:
    with closing(Scene(tmp_path, ROVER, of_file="blimp")) as scene:
        scene.wait(5.0)
        scene.body.arm(armed=True)
        scene.wait(1.5)
        assert not scene.vehicle.armed
        why = "a rover answers, and the robot file is for a blimp: adopt this vehicle anew"
        assert scene.problems == [why]
        assert scene.body.autopilot(0.0).why == why
        scene.vehicle.armed, scene.vehicle.mode = True, GUIDED
        scene.wait(1.0)
        scene.body.drive()
        scene.wait(2.0)
        scene.body.command(Twist())
        scene.body.command(Twist.planar(0.5, 0.0))
        scene.wait(0.5)
        assert not any(scene.vehicle.velocities())
        scene.body.arm(armed=False)
        scene.wait(0.5)
        assert not scene.vehicle.armed, "anyone may disarm it"


def test_a_vehicle_of_the_kind_of_the_robot_file_is_driven(tmp_path: Path) -> None:
    with closing(Scene(tmp_path, ROVER, of_file="rover")) as scene:
        scene.drive()


def test_a_silent_vehicle_is_not_reported_and_its_velocities_begin_anew(scene: Scene) -> None:
    scene.drive()
    scene.body.command(Twist())
    scene.body.command(Twist.planar(0.5, 0.0))
    scene.plays = False
    scene.wait(3.0)
    assert scene.phase is AutopilotPhase.GONE
    assert not scene.body.sensors(0.0).known
    scene.vehicle.received.clear()
    scene.plays = True
    scene.wait(6.0, each=lambda: scene.body.command(Twist.planar(0.5, 0.0)))
    assert scene.body.sensors(0.0).known
    assert not any(scene.vehicle.velocities()), "it was deflected when the link came back"


def test_an_armed_vehicle_that_a_new_driver_finds_is_left_alone(scene: Scene) -> None:
    """As after kill -9 of the process before."""
    scene.vehicle.armed, scene.vehicle.mode = True, GUIDED
    scene.wait(5.0, each=lambda: scene.body.command(Twist()))
    scene.body.command(Twist.planar(0.5, 0.0))
    scene.wait(1.0)
    assert scene.phase is AutopilotPhase.ELSEWHERE
    moving = {"SET_POSITION_TARGET_LOCAL_NED", "MANUAL_CONTROL", "RC_CHANNELS_OVERRIDE"}
    assert not moving & {frame.name for frame in scene.vehicle.received}
    orders = [frame["command"] for frame in scene.vehicle.received if frame.name == "COMMAND_LONG"]
    assert not {176, 400} & set(orders), "no mode and no arming was asked for"
    scene.body.drive()
    scene.wait(2.0)
    assert scene.phase is AutopilotPhase.DRIVING


def test_a_mode_of_another_station_ends_driving(scene: Scene) -> None:
    scene.drive()
    scene.body.command(Twist())
    scene.body.command(Twist.planar(0.5, 0.0))
    scene.vehicle.mode = HOLD
    scene.wait(1.0)
    assert scene.phase is AutopilotPhase.ELSEWHERE
    assert any("hold" in each for each in scene.problems)
    scene.vehicle.mode = GUIDED  # the other station puts it back
    scene.vehicle.received.clear()
    scene.wait(2.0, each=lambda: scene.body.command(Twist.planar(0.5, 0.0)))
    assert scene.phase is AutopilotPhase.ELSEWHERE
    assert not scene.vehicle.velocities()


def test_the_bytes_of_the_link_are_kept_while_somebody_wants_them(scene: Scene) -> None:
    scene.wait(1.0)
    assert scene.body.take_frames(wanted=False) == ()
    scene.wait(1.0)
    assert scene.body.take_frames(wanted=True) == ()
    scene.vehicle.received.clear()
    scene.wait(1.0)
    kept = scene.body.take_frames(wanted=False)

    def names(sent: int) -> list[str]:
        parser = FrameParser()
        pieces: list[MavlinkFrames] = [each for each in kept if each.sent == sent]
        return [frame.name for each in pieces for frame in parser.feed(each.data.tobytes())]

    assert names(1) == [frame.name for frame in scene.vehicle.received]
    assert names(0).count("ATTITUDE") == 20
    assert all(each.stamp > 1e9 for each in kept)
    scene.wait(0.5)
    assert scene.body.take_frames(wanted=False) == ()


def test_an_answer_is_read_when_it_comes(scene: Scene) -> None:
    """Not with the next call of `advance`, which would add its period to the round trip."""
    files = Files()
    scene.body.wake_by(files, lambda: False)
    scene.wait(2.0)
    scene.now += 1.0
    scene.body.advance(TICK_S)
    while "TIMESYNC" not in [frame.name for frame in scene.vehicle.answer()]:
        pass
    scene.now += 0.003
    files.serve()
    assert scene.body.autopilot(0.0).round_trip_s == pytest.approx(0.003, abs=1e-6)
    assert not files.watched, "nothing is awaited"


def test_an_answer_that_does_not_come_is_awaited_for_a_short_time(scene: Scene) -> None:
    files = Files()
    scene.body.wake_by(files, lambda: False)
    scene.wait(5.0)
    scene.vehicle.deaf = True
    watched = []
    for _ in range(8):
        scene.wait(TICK_S)
        watched.append(bool(files.watched))
    assert set(watched) == {False, True}
    scene.wait(0.2 if files.watched else 0.0)
    scene.body.close()
    assert not files.watched


def test_frames_of_another_station_pass_unless_they_drive(scene: Scene) -> None:
    scene.wait(3.0)
    scene.vehicle.received.clear()
    station = FramePacker(254, 190)
    frames = station.pack("MANUAL_CONTROL", target=1, z=1000)
    frames += station.pack("PARAM_REQUEST_LIST", target_system=1)
    scene.body.pass_on(frames + station.pack("HEARTBEAT", type=6, autopilot=8))
    scene.vehicle.answer()
    came = [each.name for each in scene.vehicle.received if each.system == 254]
    assert came == ["PARAM_REQUEST_LIST"]


def test_the_parts_of_a_robot_file_are_the_vehicles(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(ROBOT.format(address="udp://127.0.0.1:9", more="") + PARTS)
    described, problems = read_description(path)
    assert not problems
    body = MavlinkBody(described)
    read = body.vehicle.telemetry
    read.named["Lights1"], read.tilt = 0.5, 0.3
    body.set_light("lamp", 1.0)
    body.turn_joint("camera", 0.1)
    sensors = body.sensors(1.0)
    body.close()
    assert isinstance(body, BodyLights)
    assert isinstance(body, BodyJoints)
    assert [(each.name, each.brightness) for each in sensors.vehicle.lights] == [("lamp", 0.5)]
    assert [(each.name, each.position) for each in sensors.joints] == [("camera", 0.3)]
    assert [each.header.frame_id for each in sensors.scans] == ["ahead"]


def test_the_dead_reckoning_of_a_vehicle_with_satellites_is_that_of_its_origin(
    scene: Scene, tmp_path: Path
) -> None:
    """A new driver process goes on with the same map; a vehicle without a place does not."""

    def place() -> None:
        scene.vehicle.send("GPS_GLOBAL_ORIGIN", latitude=338103130, longitude=-1183938670)
        scene.vehicle.send("GPS_RAW_INT", satellites_visible=10)
        scene.vehicle.place(1.0, 2.0)

    scene.wait(5.0)
    first = scene.body.sensors(0.0).reckoning
    scene.wait(1.0, each=place)
    placed = scene.body.sensors(0.0)
    assert (placed.x, placed.y) == (2.0, 1.0)
    assert placed.reckoning != first
    scene.wait(2.0)
    assert scene.body.sensors(0.0).reckoning not in (first, placed.reckoning), "no place any more"
    scene.body.close()
    scene.body = MavlinkBody(robot(tmp_path, scene.vehicle.address), clock=lambda: scene.now)
    scene.wait(0.3)
    assert not scene.body.sensors(0.0).known, "its place may not have come yet"
    scene.wait(5.0, each=place)
    again = scene.body.sensors(0.0)
    assert again.known
    assert again.reckoning == placed.reckoning
    scene.vehicle.boot_ms = 0
    scene.wait(1.0)
    assert scene.body.sensors(0.0).reckoning != placed.reckoning


@pytest.mark.parametrize(
    ("severity", "words", "name", "level"),
    [
        (2, "Leak Detected", "leak", Severity.ERROR),
        (4, "Battery 1 is low 10.50V used 3200 mAh", "battery", Severity.WARN),
        (2, "EKF Failsafe: Position", "estimator", Severity.ERROR),
        (3, "Crash: Disarming", "vehicle", Severity.ERROR),
        (6, "Leak sensor found", None, Severity.OK),
        (2, "PreArm: Battery 1 below minimum arming voltage", None, Severity.OK),
    ],
)
def test_a_vehicle_says_what_is_wrong_in_its_own_words(
    scene: Scene, severity: int, words: str, name: str | None, level: Severity
) -> None:
    scene.wait(5.0)
    scene.vehicle.text(words, severity)
    scene.wait(1.0)
    found = [each for each in scene.body.sensors(0.0).diagnostics if words in each.message]
    assert [(each.name, each.level) for each in found] == ([(name, level)] if name else [])
    scene.wait(31.0)
    assert not any(words in each for each in scene.problems)


def test_it_is_an_alarm_that_a_vehicle_never_stops_by_itself(tmp_path: Path) -> None:
    scene = Scene(tmp_path, BLIMP)
    scene.vehicle.parameters |= {"FS_THR_ENABLE": 0.0, "RC_OVERRIDE_TIME": 3.0}
    scene.wait(5.0)
    (stops,) = [each for each in scene.body.sensors(0.0).diagnostics if each.name == "stops"]
    assert stops.level is Severity.WARN
    scene.vehicle.armed = True
    scene.wait(1.0)
    (stops,) = [each for each in scene.body.sensors(0.0).diagnostics if each.name == "stops"]
    assert stops.level is Severity.ERROR
    assert scene.body.autopilot(0.0).stops_after_cut_s == float("inf")
    scene.close()
