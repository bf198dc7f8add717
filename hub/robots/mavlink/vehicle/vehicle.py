"""The vehicle as the driver sees it: a state machine with a clock; pure.

| phase | event | next phase |
| --- | --- | --- |
| LINKING | a heartbeat of an autopilot | LEARNING |
| any other | no heartbeat for 2.5 s, no echo for 1 s | GONE |
| GONE | heartbeats and echoes | LEARNING |
| any after LEARNING | it was booted, or its telemetry is silent | LEARNING |
| LEARNING | its streams and parameters were asked for | by its heartbeat, as below |
| DISARMED | `arm` | ARMING |
| ARMING | it refuses, or 5 s pass | DISARMED |
| any of these | its heartbeat: disarmed | DISARMED |
| any of these | armed, in a driving mode, and the operator asked to drive | DRIVING |
| any of these | armed otherwise | ELSEWHERE |

The operator's order to drive ends with each other mode, with a disarmed vehicle, and with a boot.
Another station that sets the driving mode again does not renew it.

| phase | sends |
| --- | --- |
| LINKING, GONE | heartbeats, echoes |
| LEARNING, ELSEWHERE | these; neutral sticks, if the present mode was asked for here |
| DISARMED, ARMING | these, neutral sticks |
| DRIVING | these, the velocity; until the first neutral one, a neutral one |
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.profile import NEUTRAL, Setpoint, VehicleProfile
from hub.robots.mavlink.profiles.table import profile_of
from hub.robots.mavlink.vehicle.learning import Learning
from hub.robots.mavlink.vehicle.liveness import Liveness
from hub.robots.mavlink.vehicle.mode_orders import ModeOrders
from hub.robots.mavlink.vehicle.requests import ParameterReads, RequestQueue
from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.robots.mavlink.vehicle.texts import VehicleTexts
from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker, MavlinkFrame

STATION_COMPONENT: Final = 190
"""The number of a mission planner in a ground station."""
_AUTOPILOT: Final = 1
"""The component that is the autopilot."""
_NO_AUTOPILOT: Final = 8
_ARMED: Final = 128
_BOOTING: Final = (0, 1, 2)
_FAILSAFE: Final = 5
_HEARTBEAT_S: Final = 1.0
_MOVING_S: Final = 0.05
_NEUTRAL_S: Final = 0.1
"""Time between two velocities while moving, and else [s]."""
_ARMING_S: Final = 5.0
_WAKING_S: Final = 0.4
"""Time of neutral sticks before the driving mode: without them a failsafe would end it [s]."""
_STARTS: Final = "it starts"
_BOOTED: Final = "it was booted"


class MavlinkVehicle:
    """One vehicle; used by one thread. Times are monotonic [s].

    Attributes:
        phase: What can be done with it.
        profile: The rules of its kind; None: it is not known.
        system: Its number; 0: not known yet.
        armed: Whether its motors may move.
        mode: Number of its mode; -1: not known.
        failsafe: Whether one of its failsafes acts.
        telemetry: What it measures.
        parameters: The parameters that were read.
        texts: Its texts.
        liveness: Its heartbeats and echoes.
        others: Numbers of other vehicles on this link.
        orders: The orders to arm it and to change its mode.
        learning: The questions to it.
    """

    def __init__(
        self, send: Callable[[bytes], None], packer: FramePacker, limits: Setpoint, system: int = 0
    ) -> None:
        """Wait for a vehicle.

        Args:
            send: Sends a frame at once, or drops it.
            packer: Packs the frames of this station.
            limits: The largest velocities.
            system: Number of the vehicle; 0: the first one that is heard.
        """
        self._send_frame, self._packer, self._limits = send, packer, limits
        self._wanted_system = system
        self.phase = AutopilotPhase.LINKING
        self.profile: VehicleProfile | None = None
        self.system = 0
        self.armed = False
        self.mode = -1
        self.failsafe = False
        self.telemetry = Telemetry()
        self.parameters = ParameterReads()
        self.texts = VehicleTexts()
        self.liveness = Liveness()
        self.others: set[int] = set()
        self._requests = RequestQueue()
        self.learning = Learning(self._requests, self.parameters)
        self.orders = ModeOrders(self._requests, self.texts)
        self._learns_because = ""
        self._velocity = NEUTRAL
        self._must_be_neutral = True
        self._arming_until = -math.inf
        self._sent_at = self._heartbeat_at = -math.inf

    # What the driver asks.

    def set_velocity(self, wanted: Setpoint, now: float) -> None:
        """Follow a velocity within the limits; NaN counts as 0. A new one leaves at once."""
        limited = Setpoint(
            ahead=_limited(wanted.ahead, self._limits.ahead),
            left=_limited(wanted.left, self._limits.left),
            up=_limited(wanted.up, self._limits.up),
            turn=_limited(wanted.turn, self._limits.turn),
        )
        if limited.neutral:
            if self.phase is AutopilotPhase.DRIVING:
                self._must_be_neutral = False
        elif self._must_be_neutral or self.phase is not AutopilotPhase.DRIVING:
            limited = NEUTRAL
        if limited != self._velocity:
            self._velocity = limited
            self._send_velocity(now)

    def arm(self, now: float) -> None:
        """Arm it in its driving mode; an order in another phase than DISARMED changes nothing."""
        if self.phase is not AutopilotPhase.DISARMED or self.profile is None:
            return
        self.phase = AutopilotPhase.ARMING
        self._arming_until = now + _ARMING_S
        self._ask_mode(self.profile, self.profile.drives, now, arm=self._arm)

    def disarm(self) -> None:
        """Switch its motors off."""
        self._velocity = NEUTRAL
        self.orders.disarm()

    def drive(self, now: float) -> None:
        """Ask for the mode that follows velocities; they begin with a neutral one."""
        if self.profile is not None and self.armed:
            self._ask_mode(self.profile, self.profile.drives, now, after=_WAKING_S)

    def set_mode(self, name: str, now: float) -> None:
        """Ask for a mode by its name; one that is not offered changes nothing."""
        number = self.profile.mode_number(name) if self.profile is not None else None
        if self.profile is not None and number is not None:
            drives = self.armed and number in self.profile.drives
            after = _WAKING_S if drives else 0.0
            self._ask_mode(self.profile, (number,), now, drives=drives, after=after)

    def left_alone(self, action: LeftAlone | None, now: float) -> None:
        """Do this without an operator; a mode that another chose is not changed."""
        if action is None or self.profile is None or not self.armed:
            return
        number = self.profile.alone.get(action)
        if number is not None and self.orders.chosen_here(self.mode, now):
            self._ask_mode(self.profile, (number,), now, drives=False)

    # Received and sent.

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""
        if frame.name == "HEARTBEAT":
            self._heartbeat(frame, now)
        elif frame.system == self.system and frame.component == _AUTOPILOT:
            self._from_autopilot(frame, now)

    def step(self, now: float) -> None:
        """Let time pass: change the phase, and send what is due."""
        self.texts.flush(now, late=True)
        self._change_phase(now)
        if now - self._heartbeat_at >= _HEARTBEAT_S:
            self._heartbeat_at = now
            self._send(
                "HEARTBEAT", type=6, autopilot=_NO_AUTOPILOT, system_status=4, mavlink_version=3
            )
        if self.system and (stamp := self.liveness.echo_due(now)):
            self._send("TIMESYNC", ts1=stamp)
        if now - self._sent_at >= (_NEUTRAL_S if self._velocity.neutral else _MOVING_S):
            self._send_velocity(now)
        self._send_requests(now)

    # State.

    @property
    def velocity(self) -> Setpoint:
        """The velocity that it is asked to follow now."""
        return self._velocity if self.phase is AutopilotPhase.DRIVING else NEUTRAL

    @property
    def must_be_neutral(self) -> bool:
        """Whether velocities wait for a neutral one."""
        return self._must_be_neutral

    @property
    def learns_because(self) -> str:
        """Why it is asked for everything again; empty: it was heard for the first time."""
        return self._learns_because

    def awaits(self, now: float) -> bool:
        """Whether an answer is on its way whose time matters."""
        return bool(self._requests) or self.liveness.awaits(now)

    # Inside.

    def _heartbeat(self, frame: MavlinkFrame, now: float) -> None:
        if frame["autopilot"] == _NO_AUTOPILOT or frame.component != _AUTOPILOT:
            return  # a ground station, a gimbal
        if frame.system != (self.system or self._wanted_system or frame.system):
            if len(self.others) < 64:
                self.others.add(frame.system)
            return
        self.system = frame.system
        self.profile = profile_of(frame["autopilot"], frame["type"])
        self.liveness.heartbeat(now)
        self.armed = bool(frame["base_mode"] & _ARMED)
        self.mode = frame["custom_mode"]
        self.failsafe = frame["system_status"] == _FAILSAFE
        booting = frame["system_status"] in _BOOTING
        if booting and self.phase not in (AutopilotPhase.LINKING, AutopilotPhase.GONE):
            self._learn(now, _STARTS)
        self._change_phase(now)

    def _from_autopilot(self, frame: MavlinkFrame, now: float) -> None:
        match frame.name:
            case "TIMESYNC" if frame["tc1"]:
                self.liveness.echo(frame["ts1"], now)
            case "COMMAND_ACK" if frame["target_system"] in (0, self._packer.system):
                self._requests.answer(frame["command"], frame["result"], now)
            case "PARAM_VALUE":
                self.parameters.take(frame["param_id"], frame["param_value"])
            case "STATUSTEXT":
                self.texts.add(
                    frame["severity"], frame["text"], frame["id"], frame["chunk_seq"], now
                )
            case "AUTOPILOT_VERSION":
                self.learning.firmware = frame["flight_sw_version"]
            case "ATTITUDE" if frame["time_boot_ms"] + 1000 < self.telemetry.boot_ms:
                self.telemetry = Telemetry()
                self.telemetry.take(frame, now)
                self._learn(now, _BOOTED)
            case _:
                self.telemetry.take(frame, now)

    def _change_phase(self, now: float) -> None:
        before = self.phase
        if self.system == 0:
            return
        if self.liveness.gone(now):
            self.phase = AutopilotPhase.GONE
        elif before in (AutopilotPhase.LINKING, AutopilotPhase.GONE):
            self._learn(now, "")
        elif before is AutopilotPhase.LEARNING:
            if self.learning.done(now):
                self._by_heartbeat(now)
        elif self.learning.is_silent(self.telemetry.measured, now):
            self._learn(now, "its telemetry is silent")
        else:
            self._by_heartbeat(now)
        if self.phase is not before:
            self._must_be_neutral = True
            self._velocity = NEUTRAL
            self._send_velocity(now)

    def _by_heartbeat(self, now: float) -> None:
        if not self.armed:
            if self.phase is AutopilotPhase.ARMING and now <= self._arming_until:
                return
            if self.phase is not AutopilotPhase.DISARMED:
                self.orders.end()
            self.phase = AutopilotPhase.DISARMED
            return
        drives = self.profile is not None and self.mode in self.profile.drives
        self.orders.seen(self.mode, now, drives=drives)
        drives = drives and self.orders.follows
        self.phase = AutopilotPhase.DRIVING if drives else AutopilotPhase.ELSEWHERE

    def _learn(self, now: float, because: str) -> None:
        """Ask for everything: a vehicle that was booted knows nothing of this station."""
        if because in (_STARTS, _BOOTED):
            self.orders.forget()
        self.phase, self._learns_because = AutopilotPhase.LEARNING, because
        self._velocity, self._must_be_neutral = NEUTRAL, True
        self.learning.begin(self.profile, now)

    def _ask_mode(
        self,
        profile: VehicleProfile,
        numbers: Sequence[int],
        now: float,
        *,
        drives: bool = True,
        after: float = 0.0,
        arm: Callable[[], None] | None = None,
    ) -> None:
        """Ask for a mode; the velocities begin with a neutral one."""
        self._velocity, self._must_be_neutral = NEUTRAL, True
        self.orders.change(profile, numbers, now, drives=drives, after=after, arm=arm)

    def _arm(self) -> None:
        self.orders.arm(refused=self._not_armed)

    def _not_armed(self) -> None:
        if self.phase is AutopilotPhase.ARMING:
            self.phase = AutopilotPhase.DISARMED

    def _sticks(self, now: float) -> bool:
        """Whether sticks are sent: else a pilot or another station has the vehicle."""
        match self.phase:
            case AutopilotPhase.DISARMED | AutopilotPhase.ARMING | AutopilotPhase.DRIVING:
                return True
            case AutopilotPhase.LEARNING | AutopilotPhase.ELSEWHERE:
                return self.orders.chosen_here(self.mode, now)
            case _:
                return False

    def _send_velocity(self, now: float) -> None:
        if self.profile is None or not self._sticks(now):
            return
        self._sent_at = now
        setpoint = self.profile.setpoint(self.velocity, self.parameters.values, self.telemetry.gain)
        for name, fields in setpoint:
            self._send(name, **fields)

    def _send_requests(self, now: float) -> None:
        if not self.system or self.phase is AutopilotPhase.GONE:
            return
        request = self._requests.due(now)
        if request is not None:
            values = {f"param{place}": value for place, value in enumerate(request.parameters, 1)}
            self._send("COMMAND_LONG", command=request.command, **values)
        if name := self.parameters.due(now):
            self._send("PARAM_REQUEST_READ", param_index=-1, param_id=name)

    def _send(self, name: str, **fields: object) -> None:
        names = {field.name for field in BY_NAME[name].fields}
        if "target_system" in names and name != "TIMESYNC":
            fields |= {"target_system": self.system, "target_component": _AUTOPILOT}
        elif "target" in names:
            fields["target"] = self.system
        self._send_frame(self._packer.pack(name, **fields))


def _limited(value: float, limit: float) -> float:
    """A velocity within its limit; one that is no number is 0."""
    return max(-limit, min(limit, value)) if math.isfinite(value) else 0.0
