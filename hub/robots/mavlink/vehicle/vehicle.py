"""The vehicle as the driver sees it: a state machine with a clock; pure.

| phase | event | next phase |
| --- | --- | --- |
| LINKING | a heartbeat of an autopilot | LEARNING |
| any other | no heartbeat for 2.5 s, no echo for 1 s | GONE |
| GONE | heartbeats and echoes | LEARNING |
| any after LEARNING | it starts, it was booted, or its telemetry is silent | LEARNING |
| LEARNING | it does not start, its streams and parameters were asked for | as below |
| DISARMED | `arm` | ARMING |
| ARMING | it refuses, or 5 s pass | DISARMED |
| any of these | its heartbeat: disarmed | DISARMED |
| any of these | armed, in a driving mode, and the operator asked to drive | DRIVING |
| any of these | armed otherwise; one that flies, on the ground | ELSEWHERE |

The operator's order to drive ends with each other mode, with a disarmed vehicle, and with a boot.
Another station that sets the driving mode again does not renew it.

| phase | sends |
| --- | --- |
| LINKING | heartbeats |
| GONE | heartbeats, echoes, the order to disarm |
| LEARNING, ELSEWHERE | these, all orders; neutral sticks, if the present mode was asked for here |
| DISARMED, ARMING | these, neutral sticks |
| DRIVING | these, the velocity; until the first neutral one, a neutral one |
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.profile import NEUTRAL, Setpoint, VehicleProfile
from hub.robots.mavlink.vehicle.button_lights import ButtonLights
from hub.robots.mavlink.vehicle.camera_tilt import CameraTilt
from hub.robots.mavlink.vehicle.identity import VehicleIdentity
from hub.robots.mavlink.vehicle.learning import Learning
from hub.robots.mavlink.vehicle.liveness import Liveness
from hub.robots.mavlink.vehicle.mode_orders import ModeOrder, ModeOrders
from hub.robots.mavlink.vehicle.parameter_reads import ParameterReads, parameter_value
from hub.robots.mavlink.vehicle.requests import RequestKind, RequestQueue
from hub.robots.mavlink.vehicle.sender import VehicleSender
from hub.robots.mavlink.vehicle.stick_stream import StickStream
from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.robots.mavlink.vehicle.texts import VehicleTexts
from hub.robots.mavlink.vehicle.velocity_gate import VelocityGate
from hub.robots.mavlink.wire.frames import FramePacker, MavlinkFrame

_ARMED: Final = 128
_BOOTING: Final = (0, 1, 2)
_FAILSAFE: Final = 5
_WAKING_S: Final = 0.4
"""Time of neutral sticks before the driving mode: without them a failsafe would end it [s]."""
_AWAY: Final = (AutopilotPhase.LINKING, AutopilotPhase.GONE)
_STARTS: Final = "it starts"
_BOOTED: Final = "it was booted"
_SILENT: Final = "its telemetry is silent"


class MavlinkVehicle:
    """One vehicle; used by one thread. Times are monotonic [s].

    Attributes:
        phase: What can be done with it.
        identity: Its number and kind, and who else is on its link.
        armed: Whether its motors may move.
        mode: Number of its mode; -1: not known.
        failsafe: Whether one of its failsafes acts.
        telemetry: What it measures.
        parameters: The parameters that were read.
        texts: Its texts.
        liveness: Its heartbeats and echoes.
        orders: The orders to arm it and to change its mode.
        learning: The questions to it.
        lights: Its lights.
        tilt: Its camera.
        learns_because: Why it is asked for everything again; empty: it is heard for the first time.
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
        self._sender = VehicleSender(send, packer)
        self._sticks = StickStream(self._sender)
        self._gate = VelocityGate(limits)
        self.lights, self.tilt = ButtonLights(), CameraTilt(self._sender)
        self.phase = AutopilotPhase.LINKING
        self.identity = VehicleIdentity(system)
        self.armed = False
        self.mode = -1
        self.failsafe = False
        self.telemetry = Telemetry()
        self.parameters = ParameterReads()
        self.texts = VehicleTexts()
        self.liveness = Liveness()
        self._requests = RequestQueue()
        self.learning = Learning(self._requests, self.parameters)
        self.orders = ModeOrders(self._requests, self.texts)
        self.learns_because = ""
        self._starts = False
        self._alone: LeftAlone | None = None

    # What the driver asks.

    def set_velocity(self, wanted: Setpoint, now: float) -> None:
        """Follow a velocity within the limits; NaN counts as 0. A new one leaves at once."""
        if self._gate.take(wanted, driven=self.phase is AutopilotPhase.DRIVING):
            self._send_velocity(now)

    def arm(self, now: float) -> None:
        """Arm it in its driving mode; an order in another phase than DISARMED changes nothing."""
        profile = self.profile
        if self.phase is AutopilotPhase.DISARMED and profile is not None and not profile.flies:
            self.phase = AutopilotPhase.ARMING
            self._change_mode(self._driving_order(profile, arms=True), now)

    def disarm(self, now: float) -> None:
        """Switch its motors off."""
        self._alone = None
        self.orders.disarm(now)
        self._stop_driving(now)

    def drive(self, now: float) -> None:
        """Ask for the mode that follows velocities; they begin with a neutral one."""
        if self.profile is not None and self.armed and self._can_change and not self.grounded:
            self._change_mode(self._driving_order(self.profile), now)

    def set_mode(self, name: str, now: float) -> None:
        """Ask for a mode by its name; one that is not offered changes nothing."""
        profile = self.profile
        number = profile.mode_number(name) if profile is not None else None
        if profile is None or number is None or not self._can_change:
            return
        drives = self.armed and number in profile.drives and not self.grounded
        self._change_mode(ModeOrder(profile=profile, numbers=(number,), drives=drives), now)

    def left_alone(self, action: LeftAlone | None, now: float) -> None:
        """Do this without an operator, if need be later; None: an operator is there again.

        A mode that another chose is not changed.
        """
        self._alone = action
        self._do_alone(now)

    # Received and sent.

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""
        if frame.name == "HEARTBEAT":
            before = self.profile
            if self.identity.heartbeat(frame, silent=self.phase in _AWAY):
                if self.profile is not before:
                    self._forget()
                self._heartbeat(frame, now)
        elif self.identity.sent(frame):
            self._from_autopilot(frame, now)

    def step(self, now: float) -> None:
        """Let time pass: change the phase, and send what is due."""
        self.texts.step(now)
        self._change_phase(now)
        self.orders.step(self.mode, now, armed=self.armed)
        self._do_alone(now)
        self._sender.heartbeat(now)
        if self.system and (stamp := self.liveness.echo_due(now)):
            self._sender.message("TIMESYNC", ts1=stamp)
        if self._sticks.due(self._gate.velocity, now):
            self._send_velocity(now)
        self.tilt.step(self.telemetry.tilt, now, allowed=self._sends_sticks(now))
        self._send_requests(now)

    # State.

    @property
    def profile(self) -> VehicleProfile | None:
        """The rules of its kind; None: it is not known."""
        return self.identity.profile

    @property
    def system(self) -> int:
        """Its number; 0: not known yet."""
        return self.identity.system

    @property
    def others(self) -> set[int]:
        """Numbers of other vehicles on its link."""
        return self.identity.others

    @property
    def grounded(self) -> bool:
        """Whether it flies, and is on the ground: Rune does not take off."""
        flies = self.profile is not None and self.profile.flies
        return flies and not self.telemetry.in_air

    @property
    def velocity(self) -> Setpoint:
        """The velocity that it is asked to follow now."""
        return self._gate.velocity if self.phase is AutopilotPhase.DRIVING else NEUTRAL

    @property
    def must_be_neutral(self) -> bool:
        """Whether velocities wait for a neutral one."""
        return self._gate.shut

    def awaits(self, now: float) -> bool:
        """Whether an answer is on its way whose time matters."""
        return bool(self._requests) or self.liveness.awaits(now)

    # Inside.

    @property
    def _can_change(self) -> bool:
        """Whether it can be asked for a mode: one that starts would forget it."""
        return self.phase not in _AWAY and not self._starts

    def _driving_order(self, profile: VehicleProfile, *, arms: bool = False) -> ModeOrder:
        numbers = profile.drives_with(place=self.telemetry.position)
        return ModeOrder(profile=profile, numbers=numbers, drives=True, arms=arms)

    def _heartbeat(self, frame: MavlinkFrame, now: float) -> None:
        self._sender.system = frame.system
        self.liveness.heartbeat(now)
        self.armed = bool(frame["base_mode"] & _ARMED)
        self.mode = frame["custom_mode"]
        self.failsafe = frame["system_status"] == _FAILSAFE
        started = self._starts
        self._starts = frame["system_status"] in _BOOTING
        if self._starts is not started and self.phase not in _AWAY:
            self._learn(now, _STARTS)
        self._change_phase(now)

    def _from_autopilot(self, frame: MavlinkFrame, now: float) -> None:
        match frame.name:
            case "TIMESYNC" if frame["tc1"]:
                self.liveness.echo(frame["ts1"], now)
            case "COMMAND_ACK" if self._sender.is_asker(frame):
                self._requests.answer(frame["command"], frame["result"], now)
            case "PARAM_VALUE":
                bytewise = self.profile is not None and self.profile.bytewise
                self.parameters.take(frame["param_id"], parameter_value(frame, bytewise=bytewise))
            case "STATUSTEXT":
                self.texts.add(
                    frame["severity"], frame["text"], frame["id"], frame["chunk_seq"], now
                )
            case "AUTOPILOT_VERSION":
                self.learning.firmware = frame["flight_sw_version"]
            case "ATTITUDE" if frame["time_boot_ms"] + 1000 < self.telemetry.boot_ms:
                self._forget()
                self.telemetry.take(frame, now)
                if self.phase not in _AWAY:
                    self._learn(now, _BOOTED)
            case _:
                self.telemetry.take(frame, now)

    def _change_phase(self, now: float) -> None:
        before = self.phase
        if self.system == 0:
            return
        if self.liveness.gone(now):
            self.phase = AutopilotPhase.GONE
            if before is not self.phase:
                self.orders.gone()
                self._requests.drop(RequestKind.QUESTION)
        elif before in _AWAY:
            self._learn(now, _STARTS if self._starts else "")
        elif before is AutopilotPhase.LEARNING:
            if self.learning.done(now) and not self._starts:
                self._by_heartbeat(now)
        elif self.learning.is_silent(self.telemetry.measured, now):
            self._learn(now, _SILENT)
        else:
            self._by_heartbeat(now)
        if self.phase is not before:
            self._gate.close()
            self._send_velocity(now)

    def _by_heartbeat(self, now: float) -> None:
        """The phase of a vehicle that was learnt."""
        if not self.armed:
            if self.phase is AutopilotPhase.ARMING and self.orders.arming(now):
                return
            if self.phase is not AutopilotPhase.DISARMED:
                self.orders.release()
            self.phase = AutopilotPhase.DISARMED
            return
        profile = self.profile
        drives = profile is not None and self.mode in profile.drives
        self.orders.seen(self.mode, now, drives=drives)
        drives = drives and self.orders.follows and not self.grounded
        self.phase = AutopilotPhase.DRIVING if drives else AutopilotPhase.ELSEWHERE

    def _forget(self) -> None:
        """Another vehicle is there, or this one was booted."""
        self.telemetry = Telemetry()
        self.parameters.values.clear()
        self.orders.forget()

    def _learn(self, now: float, because: str) -> None:
        """Ask for everything: a vehicle that was booted knows nothing of this station."""
        if because == _STARTS or self.phase is AutopilotPhase.ARMING:
            self.orders.forget()
        self.phase, self.learns_because = AutopilotPhase.LEARNING, because
        self._gate.close()
        self.learning.begin(self.profile, now)

    def _change_mode(self, order: ModeOrder, now: float) -> None:
        """Ask for a mode; the velocities begin with a neutral one."""
        self.orders.change(order, now, _WAKING_S if order.drives and self.armed else 0.0)
        self._stop_driving(now)

    def _stop_driving(self, now: float) -> None:
        """End the motion at once; where the order to drive is not valid, the phase too."""
        if self.phase is AutopilotPhase.DRIVING and not self.orders.follows:
            self.phase = AutopilotPhase.ELSEWHERE
        self._gate.close()
        self._send_velocity(now)

    def _do_alone(self, now: float) -> None:
        """Ask for the mode of a vehicle without an operator, as soon as it can be asked."""
        profile, learns = self.profile, self.phase is AutopilotPhase.LEARNING
        if self._alone is None or profile is None or learns or not self._can_change:
            return
        number, self._alone = profile.alone.get(self._alone), None
        if number is not None and self.armed and self.orders.chosen_here(self.mode, now):
            self._change_mode(ModeOrder(profile=profile, numbers=(number,)), now)

    def _sends_sticks(self, now: float) -> bool:
        """Whether sticks are sent: else a pilot or another station has the vehicle."""
        match self.phase:
            case AutopilotPhase.DISARMED | AutopilotPhase.ARMING | AutopilotPhase.DRIVING:
                return True
            case AutopilotPhase.LEARNING | AutopilotPhase.ELSEWHERE:
                return self.orders.chosen_here(self.mode, now)
            case _:
                return False

    def _send_velocity(self, now: float) -> None:
        if self.profile is None or not self._sends_sticks(now):
            return
        values, read = self.parameters.values, self.telemetry
        buttons = self.lights.buttons(values, read.brightness, now)
        self._sticks.send(self.profile, self.velocity, values, read.gain, buttons, now)

    def _send_requests(self, now: float) -> None:
        if not self.system:
            return
        request = self._requests.due(now)
        if request is not None:
            self._sender.command(request)
        if self.phase is not AutopilotPhase.GONE and (name := self.parameters.due(now)):
            self._sender.message("PARAM_REQUEST_READ", param_index=-1, param_id=name)
