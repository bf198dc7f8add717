"""Reading and writing parameters of a vehicle, in simulated time."""

from __future__ import annotations

import math
import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import ParameterFileError
from hub.robots.mavlink.asking.parameter_file import keep_parameters, read_parameters
from hub.robots.mavlink.asking.parameters import (
    MOST_PARAMETERS,
    Parameter,
    ParameterReading,
    ParameterWriting,
    shown,
)
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from tests.support.fake_vehicle import FakeVehicle, Sent, asked

FLOAT, BYTE = 9, 2


def vehicle(count: int = 300) -> FakeVehicle:
    made = FakeVehicle()
    made.parameters = {f"P_{place}": (place / 10, FLOAT) for place in range(count)}
    return made


def written(to: FakeVehicle, **values: float) -> ParameterWriting:
    changes = [Parameter(name=name, value=value, kind=FLOAT) for name, value in values.items()]
    writing = ParameterWriting(to.system, changes)
    assert asked(writing, to)
    return writing


def test_all_are_read_though_a_third_is_lost() -> None:
    one = vehicle()
    one.lost = {("PARAM_VALUE", place) for place in range(0, 300, 3)}
    reading = ParameterReading(1)
    assert asked(reading, one)
    assert reading.complete
    values = {name: each.value for name, each in reading.values.items()}
    assert values == pytest.approx({f"P_{place}": place / 10 for place in range(300)})


def test_named_ones_are_read_and_unknown_names_are_missing() -> None:
    reading = ParameterReading(1, ["P_7", "NOPE", "P_9"])
    assert asked(reading, vehicle())
    assert {name: each.value for name, each in reading.values.items()} == pytest.approx(
        {"P_7": 0.7, "P_9": 0.9}
    )
    assert reading.missing == ["NOPE"]
    assert not reading.complete


def test_a_part_that_never_comes_ends_the_reading() -> None:
    one = vehicle(20)
    one.lost = {("PARAM_VALUE", place) for place in range(10, 1000)}
    reading = ParameterReading(1)
    assert asked(reading, one)
    assert (len(reading.values), reading.total, reading.complete) == (10, 20, False)


def test_whole_numbers_of_px4_are_bits() -> None:
    one = FakeVehicle()
    one.parameters = {"COM_RC_IN_MODE": (struct.unpack("<f", struct.pack("<i", 3))[0], 6)}
    reading = ParameterReading(1, ["COM_RC_IN_MODE"], autopilot=12)
    assert asked(reading, one)
    assert reading.values["COM_RC_IN_MODE"].value == 3.0


def test_a_flood_of_parameters_is_bounded() -> None:
    reading = ParameterReading(1)
    packer, parser = FramePacker(1, 1), FrameParser()
    for place in range(MOST_PARAMETERS + 500):
        frame = packer.pack(
            "PARAM_VALUE",
            param_id=f"Q{place}",
            param_value=1.0,
            param_type=FLOAT,
            param_count=65535,
            param_index=place,
        )
        for each in parser.feed(frame):
            reading.received(each, 0.0)
    assert len(reading.values) == MOST_PARAMETERS
    assert reading.done


def test_values_are_set_and_read_back() -> None:
    one = vehicle()
    writing = written(one, P_1=5.0, P_2=0.25)
    assert (writing.written, writing.failed) == (["P_1", "P_2"], {})
    assert one.parameters["P_1"][0] == 5.0
    assert one.heard == ["PARAM_SET", "PARAM_REQUEST_READ"] * 2


def test_lost_messages_are_sent_again() -> None:
    one = vehicle()
    one.lost = {("PARAM_VALUE", place) for place in (0, 1, 3)}
    assert written(one, P_1=5.0).written == ["P_1"]


def test_a_parameter_that_keeps_its_value_fails_and_the_next_is_set() -> None:
    one = vehicle()
    one.frozen = {"P_1"}
    writing = written(one, P_1=5.0, P_2=6.0)
    assert writing.written == ["P_2"]
    assert writing.failed == {"P_1": "it keeps 0.1"}


def test_a_silent_vehicle_fails() -> None:
    one = vehicle()
    one.lost = {("PARAM_VALUE", place) for place in range(100)}
    assert written(one, P_1=5.0).failed == {"P_1": "it does not answer"}


def test_nothing_is_set_any_more_when_it_is_armed() -> None:
    class ArmsSoon(FakeVehicle):
        def answer(self, frame: MavlinkFrame) -> list[Sent]:
            self.armed = len(self.heard) >= 1
            self.lost |= {("PARAM_VALUE", place) for place in range(2, 100)}
            return super().answer(frame)

    one = ArmsSoon()
    one.parameters = {"P_1": (0.0, FLOAT), "P_2": (0.0, FLOAT)}
    writing = written(one, P_1=1.0, P_2=2.0)
    assert writing.failed == {"P_2": "it was armed"}
    assert writing.written == ["P_1"]


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_shown_values_are_exact(value: float) -> None:
    assert struct.pack("<f", float(shown(value))) == struct.pack("<f", value)


@pytest.mark.parametrize(
    ("value", "text"), [(180.0, "180"), (0.10000000149, "0.1"), (math.nan, "nan"), (-3.0, "-3")]
)
def test_shown_values_are_short(value: float, text: str) -> None:
    assert shown(value) == text


def test_kept_values_can_be_read_and_no_file_is_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    old = [Parameter(name="FS_TIMEOUT", value=1.5, kind=FLOAT)]
    paths = {keep_parameters("../x", "rover", old) for _ in range(3)}
    assert len(paths) == 3
    assert {path.parent for path in paths} == {tmp_path / "vehicle-parameters"}
    assert [read_parameters(path) for path in paths] == [{"FS_TIMEOUT": 1.5}] * 3


def test_files_of_ground_stations_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.param"
    path.write_text("# Onboard\nFS_ACTION      2.000000\nFS_TIMEOUT,0.1 # s\n\n")
    assert read_parameters(path) == {"FS_ACTION": 2.0, "FS_TIMEOUT": 0.1}


QGROUNDCONTROL = """# Onboard parameters for Vehicle 1
#
# Vehicle-Id Component-Id Name Value Type
1\t1\tFS_ACTION\t2\t2
1\t1\tFS_TIMEOUT\t0.100000001490116119\t9
1\t154\tFS_ACTION\t7\t6
"""


@pytest.mark.parametrize(
    "data",
    [
        QGROUNDCONTROL.encode(),
        QGROUNDCONTROL.encode("utf-8-sig"),
        QGROUNDCONTROL.replace("\n", "\r\n").encode("utf-16"),
        b"#NOTE: 2026\r\nFS_ACTION,2\r\nFS_TIMEOUT,0.1\r\n",
        b"FS_ACTION,0x2 # hold \xe9\nFS_TIMEOUT , 0.1 # Mission Planner\n\n",
        b"# MAVProxy\nFS_ACTION        0X02\nFS_TIMEOUT       0.100000\n",
        b"\xef\xbb\xbfFS_ACTION\t2\nFS_TIMEOUT\t1e-1\n",
    ],
)
def test_files_of_all_ground_stations_are_read(tmp_path, data):
    path = tmp_path / "all.params"
    path.write_bytes(data)
    assert read_parameters(path) == pytest.approx({"FS_ACTION": 2.0, "FS_TIMEOUT": 0.1})


@pytest.mark.parametrize(
    "line", ["1 1 FS_ACTION 2", "1 1 FS_ACTION 2 9 9", "FS_ACTION,0,1", "A 0x", "A 0x1.8", "a,1"]
)
def test_a_line_of_no_ground_station_is_refused_with_its_number(tmp_path, line):
    path = tmp_path / "odd.params"
    path.write_text(f"FS_TIMEOUT,0.1\n{line}\n")
    with pytest.raises(ParameterFileError, match="line 2"):
        read_parameters(path)


@pytest.mark.parametrize("line", ["FS_ACTION", "fs,1", "FS_ACTION nan", "FS_ACTION,1e99", "A,1,2"])
def test_a_line_that_is_no_parameter_is_named(tmp_path: Path, line: str) -> None:
    path = tmp_path / "a.param"
    path.write_text(f"GOOD,1\n{line}\n")
    with pytest.raises(ParameterFileError, match=r"line 2: .* is no name with a value"):
        read_parameters(path)


def test_more_parameters_than_any_vehicle_has_are_not_read() -> None:
    reading = ParameterReading(1)
    packer, parser = FramePacker(1, 1), FrameParser()
    for place in range(MOST_PARAMETERS + 10):
        name = f"P{place}"
        data = packer.pack("PARAM_VALUE", param_id=name, param_index=place, param_count=65535)
        for frame in parser.feed(data):
            reading.received(frame, 1.0)
    assert reading.done
    assert reading.has_more
    assert len(reading.values) == MOST_PARAMETERS
