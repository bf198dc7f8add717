"""What differs between the simulated rover, Sub and blimp: modes, flags, rates; pure.

Measured on ArduPilot 4.7.0-dev. The names of the modes stand in the profiles of these vehicles.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from hub.robots.mavlink.profiles.ardublimp import BLIMP
from hub.robots.mavlink.profiles.ardurover import ROVER
from hub.robots.mavlink.profiles.ardusub import SUB
from hub.robots.mavlink.profiles.profile import VehicleProfile
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AutopilotKind:
    """One kind of vehicle.

    Attributes:
        name: "rover", "sub" or "blimp".
        type: Its MAV_TYPE.
        profile: Its table, with the names of its modes.
        boots_in: Mode while it starts.
        starts_in: Mode after its start.
        loop_hz: Rate of its main loop [Hz].
        flags: Flags of base_mode in all modes.
        manual: Modes with the flag of manual input, where not all have it.
        guided: Modes with the flag of guidance.
        needs_place: Modes that an armed vehicle enters only if it knows its place.
        always_needs_place: Modes that it never enters without.
        never: Modes that it refuses here, with the texts before the refusal.
        not_armable: Modes in which it does not arm.
        arms_without_place: Modes in which it arms without knowing its place.
        hold: Mode that stops it after a failsafe; None: none does.
        guided_mode: Mode that follows setpoints; None: none does.
        armed_text: Said when it arms.
        disarmed_text: Said when it disarms.
        sensors: Flags of SYS_STATUS: present, enabled.
        capabilities: Flags of AUTOPILOT_VERSION.
        version: Line in which it names itself.
    """

    name: str
    type: int
    profile: VehicleProfile
    boots_in: int
    starts_in: int
    loop_hz: float
    flags: int
    manual: frozenset[int]
    guided: frozenset[int]
    needs_place: frozenset[int]
    always_needs_place: frozenset[int]
    never: Mapping[int, tuple[str, ...]]
    not_armable: frozenset[int]
    arms_without_place: frozenset[int]
    hold: int | None
    guided_mode: int | None
    armed_text: str
    disarmed_text: str
    sensors: tuple[int, int]
    capabilities: int
    version: str


_MOTORS: Final = ("Arming motors", "Disarming motors")
SIMULATED_ROVER: Final = AutopilotKind(
    name="rover",
    type=10,
    profile=ROVER,
    boots_in=16,
    starts_in=0,
    loop_hz=50.0,
    flags=1,
    manual=frozenset({0, 1, 3, 7, 16}),
    guided=frozenset({5, 6, 8, 9, 10, 11, 12, 15}),
    needs_place=frozenset(range(5, 16)),
    always_needs_place=frozenset({11, 12}),
    never={
        6: (),
        8: ("Dock: target not acquired",),
        10: ("No Mission. Can't set AUTO.",),
        16: (),
    },
    not_armable=frozenset({11, 12}),
    arms_without_place=frozenset({0, 1, 3, 4}),
    hold=4,
    guided_mode=15,
    armed_text="Throttle armed",
    disarmed_text="Throttle disarmed",
    sensors=(0x1331DC2F, 0x1321DC2F),
    capabilities=61935,
    version="ArduRover V4.7.0-dev (2598e9d4)",
)
SIMULATED_SUB: Final = AutopilotKind(
    name="sub",
    type=12,
    profile=SUB,
    boots_in=19,
    starts_in=19,
    loop_hz=400.0,
    flags=1 | 16 | 64,
    manual=frozenset(),
    guided=frozenset({3, 4, 7, 16}),
    needs_place=frozenset(),
    always_needs_place=frozenset({3, 4, 7, 16}),
    never={3: ()},
    not_armable=frozenset(),
    arms_without_place=frozenset(range(32)),
    hold=2,
    guided_mode=4,
    armed_text=_MOTORS[0],
    disarmed_text=_MOTORS[1],
    sensors=(0x1331FC2F, 0x1321FC2F),
    capabilities=63975,
    version="ArduSub V4.7.0-dev (2598e9d4)",
)
SIMULATED_BLIMP: Final = AutopilotKind(
    name="blimp",
    type=7,
    profile=BLIMP,
    boots_in=1,
    starts_in=3,
    loop_hz=50.0,
    flags=1 | 16 | 64,
    manual=frozenset(),
    guided=frozenset(),
    needs_place=frozenset(),
    always_needs_place=frozenset(),
    never={},
    not_armable=frozenset(),
    arms_without_place=frozenset({1}),
    hold=None,
    guided_mode=None,
    armed_text=_MOTORS[0],
    disarmed_text=_MOTORS[1],
    sensors=(0x1321FC2F, 0x13219C2F),
    capabilities=14831,
    version="Blimp V4.7.0-dev (2598e9d4)",
)
AUTOPILOT_KINDS: Final[Mapping[str, AutopilotKind]] = {
    each.name: each for each in (SIMULATED_ROVER, SIMULATED_SUB, SIMULATED_BLIMP)
}


def robot_file(name: str) -> Path:
    """The robot file for a hub that drives this vehicle in an arena."""
    return Path(__file__).parent / f"{name}.toml"
