"""What the messages of batteries mean, as their drivers fill them in."""

import math

import pytest

from hub.gcm.battery import PowerSupplyStatus
from hub.ros.battery import BatteryReader
from hub.ros.values import NamedValue

EMPTY = {"stamp": {"sec": 1, "nanosec": 0}, "frame_id": ""}


def message(percentage, voltage=12.0, status=PowerSupplyStatus.DISCHARGING):
    return NamedValue(
        "sensor_msgs/msg/BatteryState",
        {
            "header": EMPTY,
            "percentage": percentage,
            "voltage": voltage,
            "power_supply_status": int(status),
            "present": True,
            **dict.fromkeys(("temperature", "current", "charge", "capacity"), math.nan),
        },
    )


def shares(*said, percent=False):
    reader = BatteryReader(percent=percent)
    return [reader.read(message(each)).percentage for each in said]


@pytest.mark.parametrize(
    ("said", "means"),
    [
        ((1.0, 0.9, 0.1), (1.0, 0.9, 0.1)),
        ((80.0, 3.0, 1.0, 0.5), (0.8, 0.03, 0.01, 0.005)),
        ((1.13, 1.0), (math.nan, 1.0)),
        ((math.nan, -1.0, 101.0, 255.0, math.inf), (math.nan,) * 5),
    ],
)
def test_a_percentage_is_a_share_or_percent(said, means):
    assert shares(*said) == pytest.approx(list(means), nan_ok=True)


def test_a_topic_that_counts_to_100_may_begin_empty():
    assert shares(1.0, 0.5, 1.2, percent=True) == pytest.approx([0.01, 0.005, 0.012])


def test_nothing_is_known_of_a_battery_that_is_not_measured_yet():
    read = BatteryReader().read(message(0.0, voltage=0.0))
    assert math.isnan(read.percentage)
    assert math.isnan(read.voltage)
    assert BatteryReader().read(message(0.0)).percentage == 0.0


@pytest.mark.parametrize(
    ("voltage", "status", "believed"),
    [
        (12.0, PowerSupplyStatus.DISCHARGING, False),
        (12.1, PowerSupplyStatus.UNKNOWN, False),
        (math.nan, PowerSupplyStatus.UNKNOWN, False),
        (12.0, PowerSupplyStatus.CHARGING, True),
        (12.0, PowerSupplyStatus.FULL, True),
        (12.6, PowerSupplyStatus.DISCHARGING, True),
    ],
)
def test_a_jump_up_is_believed_with_a_reason_only(voltage, status, believed):
    reader = BatteryReader()
    for _ in range(2):
        reader.read(message(0.02))
    jumped = reader.read(message(1.0, voltage, status))
    assert jumped.percentage == pytest.approx(1.0 if believed else 0.02)
    assert bool(reader.doubt) is not believed
    assert reader.read(message(0.03)).percentage == pytest.approx(0.03)
    assert not reader.doubt
