"""What the parts of a simulated autopilot share: mode, arming, place, sticks, texts; pure.

| mode or arming asked for | answer |
| --- | --- |
| a mode while it starts | accepted, and forgotten |
| a mode that it does not have, or never enters | failed, with a text |
| a mode that needs the place, armed or one that always needs it, without the place | failed |
| another mode | accepted |
| arming, without a refusal | accepted; the next heartbeat shows it |
| arming otherwise | failed, with texts |
| disarming | accepted |
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from hub.robots.simulated_autopilot.kinds import AutopilotKind
from hub.robots.simulated_autopilot.motion import SimulatedState
from hub.robots.simulated_autopilot.parameters import ParameterStore
from hub.robots.simulated_autopilot.radio_input import RadioInput
from hub.robots.simulated_autopilot.startup import Startup

CRITICAL: Final = 2
WARNING: Final = 4
INFO: Final = 6
_MOST_TEXTS: Final = 200
_BY_GPS: Final = 3.0
_BY_VISION: Final = 6.0
"""Values of EK3_SRC1_POSXY."""
_PLACE_LOST_S: Final = 8.0
"""Time after the last measurement in which it knows its place [s]."""
_PLACE_FOUND_S: Final = 0.6
"""Time after the first measurement until it knows its place [s]."""
_MEASURED_S: Final = 0.5
"""Longest time between two measurements of the place [s]."""


class VehicleCondition:
    """The state of one vehicle.

    Attributes:
        kind: What it is.
        parameters: Its parameters, which last over a restart.
        motion: Its place and motion.
        now: Monotonic time of the last step [s].
        startup: Its start.
        radio: Its radio channels.
        mode: Number of its mode.
        armed: Whether its motors have power.
        station_heard: Monotonic time of the last sign of its ground station [s]; -inf: none.
        in_failsafe: Whether a failsafe acts.
        radio_lost: Whether it misses sticks.
        setpoint: Velocity ahead, right, down [m/s], and clockwise [rad/s].
        setpoint_at: Monotonic time of the last setpoint [s].
        gain: Share of the sticks' effect, of a Sub.
        lights: The first and the second of a Sub, 0 to 1.
        tilt: Of the camera, up [rad].
        mode_shown: Whether a heartbeat has shown its mode.
    """

    def __init__(
        self,
        kind: AutopilotKind,
        parameters: ParameterStore,
        motion: SimulatedState,
        startup: Startup,
    ) -> None:
        self.kind, self.parameters, self.motion, self.startup = kind, parameters, motion, startup
        self.now = startup.began
        self.radio = RadioInput(self.now)
        self.mode = kind.boots_in
        self.armed = False
        self.station_heard = -math.inf
        self.in_failsafe = self.radio_lost = False
        self.setpoint = (0.0, 0.0, 0.0, 0.0)
        self.setpoint_at = -math.inf
        self.gain = max(0.0, min(1.0, parameters["JS_GAIN_DEFAULT"]))
        self.lights, self.tilt = [0.0, 0.0], 0.0
        self.mode_shown = True
        self._texts: list[tuple[int, str]] = []
        self._started = False
        self._origin_set = False
        self._place_since = self._place_at = -math.inf
        self._placed = False

    # Its start and its place.

    @property
    def age_ms(self) -> int:
        """Time since its start [ms]."""
        return max(0, int((self.now - self.startup.began) * 1e3))

    @property
    def receiver(self) -> bool:
        """Whether a radio receiver is connected."""
        return not self.parameters["SIM_RC_FAIL"]

    @property
    def has_origin(self) -> bool:
        """Whether its coordinates have an origin."""
        return self._origin_set or (self._gps and self._age >= self.startup.times.origin)

    @property
    def has_place(self) -> bool:
        """Whether it knows its place."""
        return self._placed

    @property
    def filter_flags(self) -> int:
        """Flags of EKF_STATUS_REPORT."""
        if self._placed:
            return 831
        if self._age < self.startup.times.initialised:
            return 1024
        return 167 if self._age >= self.startup.times.attitude else 0

    def set_origin(self) -> None:
        """Take an origin from a station; one that is there stays."""
        if self._age >= self.startup.times.attitude:
            self._origin_set = True

    def saw_place(self) -> None:
        """Take a place that a camera measured."""
        if (
            self.parameters["VISO_TYPE"]
            and self.parameters["EK3_SRC1_POSXY"] == _BY_VISION
            and self._origin_set
        ):
            self._measured_place()

    def step(self, now: float) -> None:
        """Let time pass."""
        self.now = now
        for severity, text in self.startup.texts(now):
            self.say(severity, text)
        if not self._started and self._age >= self.startup.times.ready:
            self._started = True
            self.set_mode(self.kind.starts_in)
        if self._gps and self._age >= self.startup.times.place:
            self._measured_place()
        lost = self.now - self._place_at > _PLACE_LOST_S
        found = self.now - self._place_since >= _PLACE_FOUND_S or self._gps
        self._placed = not lost and (self._placed or found)

    @property
    def _age(self) -> float:
        return self.startup.age(self.now)

    @property
    def _gps(self) -> bool:
        parameters = self.parameters
        return bool(parameters["SIM_GPS1_ENABLE"]) and parameters["EK3_SRC1_POSXY"] == _BY_GPS

    def _measured_place(self) -> None:
        if self.now - self._place_at > _MEASURED_S:
            self._place_since = self.now
        self._place_at = self.now

    # What it says.

    def say(self, severity: int, text: str) -> None:
        """Say a text to all stations, with the next step."""
        if len(self._texts) < _MOST_TEXTS:
            self._texts.append((severity, text))

    def take_texts(self) -> list[tuple[int, str]]:
        """Severities and texts since the last call."""
        texts, self._texts = self._texts, []
        return texts

    # Modes and arming.

    @property
    def base_mode(self) -> int:
        """Flags of the heartbeat."""
        kind = self.kind
        flags = kind.flags | (128 if self.armed else 0)
        flags |= 64 if self.mode in kind.manual else 0
        return flags | (8 if self.mode in kind.guided else 0)

    @property
    def status(self) -> int:
        """MAV_STATE of the heartbeat."""
        if self._age < self.startup.times.ready:
            return {"rover": 2, "sub": 5, "blimp": 1}[self.kind.name]
        if self.in_failsafe:
            return 5
        if self.kind.name == "rover":
            return 3 if self.mode == self.kind.hold else 4
        return 3 if self.kind.name == "sub" and not self.armed else 4

    def ask_mode(self, number: int) -> bool:
        """Change the mode as a station asks; returns whether that was accepted."""
        if not self._started:
            return True
        refusals = self._mode_refusals(number)
        if refusals is not None:
            for text in refusals:
                self.say(WARNING, text)
            return False
        if number == 21 and self.kind.name == "sub":
            self.say(INFO, "waiting for a rangefinder reading")
        self.set_mode(number)
        return True

    def set_mode(self, number: int) -> None:
        """Change the mode; the next step tells it."""
        self.mode, self.mode_shown = number, False
        self.setpoint, self.setpoint_at = (0.0, 0.0, 0.0, 0.0), -math.inf

    def ask_arm(self, *, force: bool) -> bool:
        """Arm as a station asks; returns whether that was accepted."""
        if self.armed:
            return True
        refusals = [] if force else list(self.arm_refusals())
        for text in refusals:
            self.say(CRITICAL, f"Arm: {text}")
        if refusals:
            return False
        self.armed = True
        self.say(INFO, self.kind.armed_text)
        return True

    def disarm(self) -> None:
        """Switch the motors off."""
        if self.armed:
            self.armed = False
            self.say(INFO, self.kind.disarmed_text)

    def arm_refusals(self) -> Iterator[str]:
        """Why it does not arm now."""
        refused = False
        for text in self.startup.refusals(self.now):
            refused = True
            yield text
        if refused and not self._started:
            return
        if self.mode in self.kind.not_armable:
            yield "Mode not armable"
        if self.kind.name == "rover" and self.radio_lost:
            yield "Radio failsafe on"
        no_place = not self.has_place and self.mode not in self.kind.arms_without_place
        if no_place and "AHRS: not using configured AHRS type" not in self.startup.refusals(
            self.now
        ):
            yield "Need Position Estimate"

    def _mode_refusals(self, number: int) -> tuple[str, ...] | None:
        """The texts of a refusal; None: the mode is possible."""
        kind = self.kind
        name = kind.profile.modes.get(number)
        failed = "Flight mode change failed"
        if name is None:
            return (f"No such mode {number}",)
        title = name.upper().replace("POSITION HOLD", "POSHOLD")
        needs = number in kind.always_needs_place or (self.armed and number in kind.needs_place)
        if needs and not self.has_place:
            sub = kind.name == "sub"
            return (f"Mode change failed: {title} requires position" if sub else failed,)
        if number in kind.never:
            failed += f" {title}" if kind.name == "sub" else ""
            return (*kind.never[number], failed)
        return None
