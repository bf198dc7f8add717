"""The message of the battery, sensor_msgs/BatteryState, field for field."""

from __future__ import annotations

import enum
import math
from dataclasses import field
from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt

from hub.gcm.fields import Name, ShareIfKnown
from hub.gcm.standard import Header
from hub.ipc.definition import MessageDefinition
from hub.ipc.formats.ranges import Most, Range
from hub.ipc.formats.wire_types import FLOAT32, Sequence, Wire
from hub.values import dataclass

MOST_CELLS = 256
"""Most cells of a battery."""

_Volts: TypeAlias = Annotated[float, Range(-1000.0, 1000.0, unit="V", nan=True), FLOAT32]
_Celsius = Range(-300.0, 1000.0, unit="deg C", nan=True)
_Charge: TypeAlias = Annotated[float, Range(-1e6, 1e6, unit="A h", nan=True), FLOAT32]


class PowerSupplyStatus(enum.IntEnum):
    """What the battery does.

    Attributes:
        UNKNOWN: Not known.
        CHARGING: It is charged.
        DISCHARGING: It drives the robot.
        NOT_CHARGING: It is on the charger, and not charged.
        FULL: It is full.
    """

    UNKNOWN = 0
    CHARGING = 1
    DISCHARGING = 2
    NOT_CHARGING = 3
    FULL = 4


def _no_cells() -> npt.NDArray[np.float32]:
    return _NO_CELLS


_NO_CELLS = np.empty(0, np.float32)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatteryState:
    """sensor_msgs/BatteryState.

    Attributes:
        header: When it was measured.
        voltage: [V]; NaN: not measured.
        temperature: [deg C]; NaN: not measured.
        current: [A], negative while it discharges; NaN: not measured.
        charge: Present charge [A h]; NaN: not measured.
        capacity: Charge when it is full now [A h]; NaN: not known.
        design_capacity: Charge when it was full as new [A h]; NaN: not known.
        percentage: Charge left, 0 to 1 despite its name; NaN: not known.
        power_supply_status: What it does.
        power_supply_health: As sensor_msgs numbers it; 0: not known.
        power_supply_technology: As sensor_msgs numbers it; 0: not known.
        present: Whether there is a battery.
        cell_voltage: Of each cell [V], shape (n,).
        cell_temperature: Of each cell [deg C], shape (n,).
        location: Its place on the robot.
        serial_number: Its number.
    """

    ros_type = "sensor_msgs/msg/BatteryState"

    header: Header = Header()
    voltage: _Volts = math.nan
    temperature: Annotated[float, _Celsius, FLOAT32] = math.nan
    current: Annotated[float, Range(-1e5, 1e5, unit="A", nan=True), FLOAT32] = math.nan
    charge: _Charge = math.nan
    capacity: _Charge = math.nan
    design_capacity: _Charge = math.nan
    percentage: Annotated[ShareIfKnown, FLOAT32] = math.nan
    power_supply_status: Annotated[PowerSupplyStatus, Wire("ubyte")] = PowerSupplyStatus.UNKNOWN
    power_supply_health: Annotated[int, Range(0, 255), Wire("ubyte")] = 0
    power_supply_technology: Annotated[int, Range(0, 255), Wire("ubyte")] = 0
    present: bool = True
    cell_voltage: Annotated[
        npt.NDArray[np.float32],
        Range(-1000.0, 1000.0, unit="V", nan=True),
        Sequence(),
        Most(MOST_CELLS),
    ] = field(default_factory=_no_cells)
    cell_temperature: Annotated[npt.NDArray[np.float32], _Celsius, Sequence(), Most(MOST_CELLS)] = (
        field(default_factory=_no_cells)
    )
    location: Name = ""
    serial_number: Name = ""


BATTERY = MessageDefinition(name="GCM_Battery", type=BatteryState, rate_hz=1.0)

MESSAGES = (BATTERY,)
