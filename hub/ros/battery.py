"""What the messages of a robot's battery mean, as their drivers fill them in; pure.

sensor_msgs/BatteryState counts `percentage` from 0 to 1. Drivers do not all follow it:

| the driver says | it means |
| --- | --- |
| 0 to 1 | that share; where the topic counts to 100, percent |
| more than 1.5, up to 100 | percent, and from then on the topic counts to 100 |
| more than 1, up to 1.5 | not known, until the topic counts to 100 |
| NaN, below 0, more than 100 | not known |
| 0 without a voltage | not known: the driver has not measured yet |
| a voltage of 0 | not known |
| a jump up by more than 0.25, without charging or more voltage | the share is as before |
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final

import numpy as np
import numpy.typing as npt

from hub.gcm.battery import MOST_CELLS, BatteryState, PowerSupplyStatus
from hub.plain_text import plain
from hub.ros import messages
from hub.ros.messages import known_number
from hub.ros.values import RosValue

_SURELY_PERCENT: Final = 1.5
"""A percentage above this counts to 100: estimates of a full battery reach 1.13."""
_WHOLE: Final = 100.0
_JUMP: Final = 0.25
"""Smallest rise of the share that needs a reason."""
_RISE: Final = 1.02
"""Smallest rise of the voltage that is a reason: another battery, or the end of a load."""
_SURE: Final = 2
"""Number of messages after which a share counts as known before a jump."""
_LONGEST: Final = 64
"""Longest text [characters]."""
_CHARGES: Final = (PowerSupplyStatus.CHARGING, PowerSupplyStatus.FULL)


class BatteryReader:
    """Reads the messages of one battery in the order of time.

    Attributes:
        percent: Whether its `percentage` counts to 100.
        doubt: Why its share is not believed, in words; empty: it is.
    """

    def __init__(self, *, percent: bool = False) -> None:
        """Know the scale, or learn it: `percent` says that it counts to 100."""
        self.percent = percent
        self.doubt = ""
        self._share = self._voltage = math.nan
        self._messages = 0

    def restart(self) -> None:
        """Forget the last share, as after a jump in a recording."""
        self.doubt = ""
        self._share = self._voltage = math.nan
        self._messages = 0

    def read(self, value: RosValue) -> BatteryState:
        """The next message, a sensor_msgs/BatteryState."""
        voltage = _voltage(value)
        status = int(value.get("power_supply_status"))
        said = BatteryState(
            header=messages.header(value.get("header")),
            voltage=voltage,
            # Before Noetic the message had no temperatures.
            temperature=_number(value, "temperature", -300.0, 1000.0),
            current=known_number(value, "current", -1e5, 1e5),
            charge=known_number(value, "charge", -1e6, 1e6),
            capacity=known_number(value, "capacity", -1e6, 1e6),
            design_capacity=_number(value, "design_capacity", -1e6, 1e6),
            percentage=self._scaled(value, voltage),
            power_supply_status=PowerSupplyStatus(
                status if 0 <= status <= PowerSupplyStatus.FULL else 0
            ),
            power_supply_health=int(value.field("power_supply_health") or 0) & 0xFF,
            power_supply_technology=int(value.field("power_supply_technology") or 0) & 0xFF,
            present=bool(value.get("present")) or voltage > 0.0,
            cell_voltage=_numbers(value, "cell_voltage", -1000.0, 1000.0),
            cell_temperature=_numbers(value, "cell_temperature", -300.0, 1000.0),
            location=_word(value, "location"),
            serial_number=_word(value, "serial_number"),
        )
        return dataclasses.replace(said, percentage=self._believed(said))

    def _scaled(self, value: RosValue, voltage: float) -> float:
        """The share that a percentage means; NaN: not known."""
        said = float(value.get("percentage"))
        self.percent = self.percent or counts_to_100(value)
        share = said / _WHOLE if self.percent else said
        if not 0.0 <= share <= 1.0 or (share == 0.0 and math.isnan(voltage)):
            return math.nan
        return share

    def _believed(self, said: BatteryState) -> float:
        """The share, or the last one where a jump from it has no reason."""
        share, before = said.percentage, self._share
        jumps = self._messages >= _SURE and share - before > _JUMP
        charged = said.power_supply_status in _CHARGES or said.voltage > _RISE * self._voltage
        if jumps and not charged:
            self.doubt = (
                f"its charge jumped from {before:.0%} to {share:.0%} without charging: "
                f"{before:.0%} counts; start the hub again if the battery was changed"
            )
            return before
        if not math.isnan(share):
            self.doubt = ""
            self._messages += 1
            self._share, self._voltage = share, said.voltage
        return share


def counts_to_100(value: RosValue) -> bool:
    """Whether a sensor_msgs/BatteryState shows that its topic counts to 100."""
    return _SURELY_PERCENT < float(value.get("percentage")) <= _WHOLE


def _number(value: RosValue, name: str, least: float, most: float) -> float:
    """A number that the message may lack; NaN: not known."""
    return math.nan if value.field(name) is None else known_number(value, name, least, most)


def _numbers(value: RosValue, name: str, least: float, most: float) -> npt.NDArray[np.float32]:
    """The numbers of the cells, shape (n,); NaN: not known."""
    said = value.field(name)
    with np.errstate(over="ignore"):
        found = np.array(() if said is None else said, np.float32)[:MOST_CELLS]
    return np.where((found >= least) & (found <= most), found, np.float32(np.nan))


def _word(value: RosValue, name: str) -> str:
    return plain(str(value.field(name) or ""))[:_LONGEST]


def _voltage(value: RosValue) -> float:
    """The voltage [V]; NaN: not known."""
    voltage = known_number(value, "voltage", -1000.0, 1000.0)
    return voltage if voltage else math.nan
