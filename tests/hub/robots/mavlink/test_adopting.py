"""Robot files of vehicles that answer in simulated time."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import VehicleSilentError
from hub.gcm.body import Freedom
from hub.robots.description import RobotDescription
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink import adopting
from hub.robots.mavlink.asking.findings import VehicleFinder
from hub.robots.mavlink.asking.search import find_vehicle
from hub.robots.mavlink.asking.session import VehicleSession
from hub.robots.robot_file import read_description
from tests.support.fake_vehicle import FakeVehicle, asked, served

ROVER = {
    "FS_GCS_ENABLE": (0.0, 2),
    "FS_GCS_TIMEOUT": (2.0, 9),
    "FS_THR_ENABLE": (1.0, 2),
    "FS_TIMEOUT": (0.1, 9),
    "FS_ACTION": (2.0, 2),
    "RC_OVERRIDE_TIME": (0.5, 9),
    "MAV_GCS_SYSID": (255.0, 4),
    "WP_SPEED": (5.0, 9),
    "ACRO_TURN_RATE": (180.0, 9),
    "SPEED_MAX": (0.0, 9),
    "ATC_STR_RAT_MAX": (45.0, 9),
}
SUB = {
    "PILOT_SPEED": (100.0, 4),
    "PILOT_SPEED_UP": (40.0, 4),
    "PILOT_SPEED_DN": (20.0, 4),
    "THR_DZ": (100.0, 4),
    "JS_GAIN_DEFAULT": (0.5, 9),
}
BLIMP = {"MAX_VEL_XY": (0.2, 9), "MAX_VEL_Z": (0.25, 9), "MAX_VEL_YAW": (0.4, 9)}


def vehicle_of(kind: int, parameters: dict[str, tuple[float, int]]) -> FakeVehicle:
    vehicle = FakeVehicle(kind=kind)
    vehicle.parameters = dict(parameters)
    return vehicle


def found(*vehicles: FakeVehicle, system: int = 0) -> VehicleFinder:
    finder = VehicleFinder(system, extra=adopting.EXTRA)
    assert asked(finder, *vehicles)
    return finder


def adopted(folder: Path, finder: VehicleFinder) -> RobotDescription:
    path = folder / "robot.toml"
    path.write_text(adopting.robot_file(finder, "udp://:14550"))
    robot, problems = read_description(path)
    assert problems == []
    return robot


def remarks(finder: VehicleFinder) -> list[str]:
    return [*adopting.remarks(finder, station=255, signs=False)]


def test_nothing_that_counts_as_life_of_a_station_is_sent() -> None:
    vehicle = vehicle_of(10, ROVER)
    found(vehicle)
    assert set(vehicle.heard) == {"TIMESYNC", "PARAM_REQUEST_READ", "COMMAND_LONG"}


@pytest.mark.parametrize(
    ("kind", "parameters", "limits", "alone"),
    [
        (10, ROVER, {Freedom.SURGE: 1.0, Freedom.YAW: 0.78}, LeftAlone.STAND),
        (10, {}, {Freedom.SURGE: 0.3, Freedom.YAW: 1.0}, LeftAlone.STAND),
        (
            12,
            SUB,
            {Freedom.SURGE: 0.37, Freedom.SWAY: 0.37, Freedom.HEAVE: 0.2, Freedom.YAW: 1.0},
            LeftAlone.SURFACE,
        ),
        (
            7,
            BLIMP,
            {Freedom.SURGE: 0.2, Freedom.SWAY: 0.2, Freedom.HEAVE: 0.25, Freedom.YAW: 0.4},
            LeftAlone.HOLD_HEIGHT,
        ),
        (
            2,
            {},
            {Freedom.SURGE: 1.0, Freedom.SWAY: 1.0, Freedom.HEAVE: 0.5, Freedom.YAW: 1.0},
            LeftAlone.HOLD_HEIGHT,
        ),
    ],
)
def test_limits_are_those_of_the_vehicle(
    tmp_path: Path,
    kind: int,
    parameters: dict[str, tuple[float, int]],
    limits: dict[Freedom, float],
    alone: LeftAlone,
) -> None:
    robot = adopted(tmp_path, found(vehicle_of(kind, parameters)))
    assert {each.freedom: each.limit for each in robot.body.motions} == pytest.approx(limits)
    assert robot.left_alone is alone


@pytest.mark.parametrize(("function", "said"), [(26.0, 1), (73.0, 0)])
def test_a_vehicle_that_steers_with_wheels_is_said_to(function: float, said: int) -> None:
    finder = found(vehicle_of(10, ROVER | {"SERVO1_FUNCTION": (function, 4)}))
    assert sum("turn on the spot" in each for each in remarks(finder)) == said


def test_cameras_and_components(tmp_path: Path) -> None:
    vehicle = vehicle_of(12, SUB)
    vehicle.beats = [(100, 30, 8), (154, 26, 8), (77, 99, 8)]
    vehicle.streams = {100: "rtsp://192.168.2.2:8554/video"}
    finder = found(vehicle)
    said = remarks(finder)
    assert "it has a component 154: gimbal" in said
    assert "it has a component 77: type 99, which is not understood" in said
    (missing,) = (each for each in said if each.startswith("it has no parameters of these names"))
    assert any(each.startswith("not known: FS_PILOT_INPUT was not read") for each in said)
    assert "ATC_STR_RAT_MAX" not in missing, "a parameter of rovers"
    robot = adopted(tmp_path, finder)
    assert robot.camera.source == "rtsp://192.168.2.2:8554/video"
    assert "vision" in robot.modules


@pytest.mark.parametrize(
    ("kind", "encoding", "said", "source"),
    [
        (1, 1, "5600", "rtp://0.0.0.0:5600"),
        (1, 2, "udp://192.168.2.1:5601", "rtp://0.0.0.0:5601?codec=h265"),
        (3, 0, "udp://239.0.0.1:5602/", "udp://0.0.0.0:5602"),
    ],
)
def test_a_stream_of_datagrams_is_waited_for(
    tmp_path: Path, kind: int, encoding: int, said: str, source: str
) -> None:
    vehicle = vehicle_of(12, SUB)
    vehicle.beats = [(100, 30, 8)]
    vehicle.streams = {100: said}
    vehicle.stream_fields = {"type": kind, "encoding": encoding}
    finder = found(vehicle)
    assert adopted(tmp_path, finder).camera.source == source
    assert f"its stream 'main' has to be sent to this machine: {source}" in remarks(finder)


@pytest.mark.parametrize("other", [(1, 30, 0), (1, 26, 3), (1, 40, 8), (1, 12, 3)])
def test_who_else_uses_the_number_of_the_autopilot_does_not_take_its_place(
    other: tuple[int, int, int],
) -> None:
    vehicle = vehicle_of(10, ROVER)
    vehicle.beats = [other]
    finder = found(vehicle)
    assert finder.profile is not None
    assert finder.profile.name == "rover"
    assert finder.parameters


def test_a_stream_that_cannot_be_read_is_named_and_not_written(tmp_path: Path) -> None:
    vehicle = vehicle_of(10, ROVER)
    vehicle.beats = [(100, 30, 8)]
    vehicle.streams = {100: 'x"\n\x1b[31m[modules.evil]'}
    finder = found(vehicle)
    said = [each for each in remarks(finder) if "no pictures can be read" in each]
    assert len(said) == 1
    assert "\x1b" not in said[0]
    robot = adopted(tmp_path, finder)
    assert robot.cameras == ()
    assert set(robot.modules) == {"driver", "navigation", "mapping", "recorder"}


def test_a_kind_that_is_not_driven(tmp_path: Path) -> None:
    finder = found(FakeVehicle(kind=1))
    assert adopting.title(finder) == "fixed wing with ArduPilot 4.7.0"
    assert "Rune does not drive vehicles of this type: it only watches" in remarks(finder)
    assert adopted(tmp_path, finder).body.motions == ()


def test_only_unsafe_parameters_are_named() -> None:
    vehicle = vehicle_of(10, ROVER)
    vehicle.armed = True
    said = remarks(found(vehicle))
    assert [each for each in said if each.startswith("unsafe")] == [
        "unsafe: FS_GCS_ENABLE is 0 in place of 1: it goes on for 3 s or more when the ground "
        "station is silent"
    ]
    assert "it is armed now: its motors may move" in said


def test_lost_answers_are_asked_for_again() -> None:
    vehicle = vehicle_of(10, ROVER)
    vehicle.lost = {("AUTOPILOT_VERSION", 0), *(("PARAM_VALUE", place) for place in range(12))}
    finder = found(vehicle)
    assert finder.parameters.keys() == ROVER.keys()
    assert adopting.title(finder) == "rover with ArduPilot 4.7.0"


def test_a_vehicle_that_sends_and_does_not_answer() -> None:
    vehicle = vehicle_of(10, ROVER)
    vehicle.lost = {
        (name, place)
        for name in ("AUTOPILOT_VERSION", "PARAM_VALUE", "COMMAND_ACK")
        for place in range(1000)
    }
    assert any("does not answer" in each for each in remarks(found(vehicle)))


def test_one_of_several_vehicles_is_named(tmp_path: Path) -> None:
    one, other = vehicle_of(10, ROVER), FakeVehicle(kind=12, system=7)
    assert found(one, other).vehicle is None
    finder = found(one, other, system=7)
    assert "another vehicle is on this link: system 1, rover" in remarks(finder)
    assert adopted(tmp_path, finder).vehicle_system == 7


def test_several_vehicles_at_one_address() -> None:
    with served(vehicle_of(10, ROVER), FakeVehicle(kind=12, system=7)) as address:
        session = VehicleSession(address)
        with pytest.raises(VehicleSilentError, match=r"1 \(rover\), 7 \(sub\); give --system"):
            find_vehicle(session)
        with pytest.raises(VehicleSilentError, match=r"vehicle 3 is not at .*; there are: 1"):
            find_vehicle(session, 3, 0.5)
        session.close()


@given(
    st.dictionaries(
        st.sampled_from([*ROVER, *SUB, *BLIMP]),
        st.floats(width=32, allow_nan=True, allow_infinity=True),
    ),
    st.sampled_from([7, 10, 11, 12, 2, 1, 200]),
    st.text(max_size=30),
)
def test_any_parameters_give_a_file_without_mistakes(
    tmp_path_factory: pytest.TempPathFactory, values: dict[str, float], kind: int, uri: str
) -> None:
    vehicle = vehicle_of(kind, {name: (value, 9) for name, value in values.items()})
    vehicle.beats = [(100, 30, 8)]
    vehicle.streams = {100: uri}
    adopted(tmp_path_factory.mktemp("any"), found(vehicle))
