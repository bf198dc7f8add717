"""The vehicle as the driver sees it: a state machine with a clock; pure.

| phase | event | next phase |
| --- | --- | --- |
| LINKING | a heartbeat of an autopilot | LEARNING |
| any other | no heartbeat for 2.5 s, no question of the last 1 s was answered | GONE |
| GONE | heartbeats and echoes; it was not learnt before, or has started since | LEARNING |
| GONE | the same, else; its telemetry comes within 1.5 s | as below |
| any after LEARNING | it starts, it was booted, or its telemetry is silent | LEARNING |
| LEARNING | it does not start, its streams and parameters were asked for | as below |
| DISARMED | `arm` | ARMING |
| ARMING | it refuses, or 5 s pass | DISARMED |
| any of these | its heartbeat: disarmed | DISARMED |
| any of these | armed, in a driving mode, and the operator asked to drive | DRIVING |
| any of these | armed otherwise; one that flies, on the ground | ELSEWHERE |

A Sub that drives in depth hold without a place gets position hold when it knows its place.
The operator's order to drive ends with the order to stay, with each other mode, with a disarmed
vehicle, and with a boot. A Sub stays in depth hold, which is a driving mode too. Another station
that sets the driving mode again does not renew it. While two vehicles answer with one number, the
phase is LEARNING. After a pause of this process velocities wait for a neutral one.

| phase | sends |
| --- | --- |
| LINKING | heartbeats |
| GONE | heartbeats, echoes, the order to disarm; once a neutral velocity, if it was driven |
| GONE, 3 s at most, while heartbeats come | these, neutral sticks, if its mode was asked for here |
| LEARNING, ELSEWHERE | these, all orders; neutral sticks, if the present mode was asked for here |
| DISARMED, ARMING | these, neutral sticks |
| DRIVING | these, the velocity; until the first neutral one, a neutral one |
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.profile import NEUTRAL, Setpoint, VehicleProfile
from hub.robots.mavlink.vehicle.alone_order import AloneOrder
from hub.robots.mavlink.vehicle.better_mode import BetterMode
from hub.robots.mavlink.vehicle.camera_tilt import CameraTilt
from hub.robots.mavlink.vehicle.learning import Learning, Return
from hub.robots.mavlink.vehicle.mode_orders import ModeOrder, ModeOrders
from hub.robots.mavlink.vehicle.reception import Heard, VehicleReception
from hub.robots.mavlink.vehicle.requests import RequestQueue
from hub.robots.mavlink.vehicle.sender import VehicleSender
from hub.robots.mavlink.vehicle.stick_stream import StickStream
from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.robots.mavlink.vehicle.velocity_gate import VelocityGate
from hub.robots.mavlink.wire.frames import FramePacker, MavlinkFrame

_ARMED: Final = 128
_BOOTING: Final = (0, 1, 2)
_FAILSAFE: Final = 5
_WAKING_S: Final = 0.4
"""Time of neutral sticks before the driving mode: without them a failsafe would end it [s]."""
_PAUSE_S: Final = 0.5
"""Time between two steps from which on what waited on the link is old [s]."""
_AWAY: Final = (AutopilotPhase.LINKING, AutopilotPhase.GONE)
_FOLLOWED: Final = (AutopilotPhase.DISARMED, AutopilotPhase.ARMING, AutopilotPhase.DRIVING)
_BESIDE: Final = (AutopilotPhase.LEARNING, AutopilotPhase.ELSEWHERE)
_TWINS: Final = "two vehicles answer with its number: give one of them another number"
_STARTS: Final = "it starts"
_SILENT: Final = "its telemetry is silent"


class MavlinkVehicle:
    """One vehicle; used by one thread. Times are monotonic [s].

    Attributes:
        phase: What can be done with it.
        heard: Its frames; `identity`, `parameters` and others are parts of it.
        armed: Whether its motors may move.
        mode: Number of its mode; -1: not known.
        failsafe: Whether one of its failsafes acts.
        orders: The orders to arm it and to change its mode.
        learning: The questions to it.
        lights: Its lights.
        tilt: Its camera.
        better: The change to a better driving mode.
        signs: Whether this station has a signing key.
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
        self.heard = VehicleReception(packer.system, system)
        self.identity, self.parameters = self.heard.identity, self.heard.parameters
        self.texts, self.liveness = self.heard.texts, self.heard.liveness
        self.stations, self._twins = self.heard.stations, self.heard.twins
        self._sender, self.signs = VehicleSender(send, packer, self.stations), packer.signs
        self._sticks, self.tilt = StickStream(self._sender), CameraTilt(self._sender)
        self._gate, self.lights = VelocityGate(limits), self._sticks.lights
        self.phase, self.mode, self.learns_because = AutopilotPhase.LINKING, -1, ""
        self.armed = self.failsafe = self._starts = False
        self._requests = RequestQueue()
        self.learning = Learning(self._requests, self.parameters)
        self.orders = ModeOrders(self._requests, self.texts)
        self._stepped, self._alone, self.better = math.inf, AloneOrder(), BetterMode()

    # What the driver asks.

    def set_velocity(self, wanted: Setpoint, now: float) -> None:
        """Follow a velocity within the limits; NaN counts as 0. A new one leaves at once."""
        driven = self.phase is AutopilotPhase.DRIVING and self._alone.action is None
        if self._gate.take(wanted, driven=driven):
            self._send_velocity(now)

    def arm(self, now: float) -> None:
        """Arm it in its driving mode; an order in another phase than DISARMED changes nothing."""
        profile = self.profile
        if self.phase is AutopilotPhase.DISARMED and profile is not None and not profile.flies:
            self.phase = AutopilotPhase.ARMING
            place = self.telemetry.position
            self._change_mode(ModeOrder.driving(profile, place=place, arms=True), now)

    def disarm(self, now: float) -> None:
        """Switch its motors off."""
        self._alone.action = None
        self.orders.disarm(now)
        self.stop_driving(now)

    def drive(self, now: float) -> None:
        """Ask for the mode that follows velocities; they begin with a neutral one."""
        if self.profile is not None and self.armed and self._can_change and not self.grounded:
            place = self.telemetry.position
            self._change_mode(ModeOrder.driving(self.profile, place=place), now)

    def stay(self, now: float) -> None:
        """Ask for the mode in which it stays; there it is not driven, even if it could be."""
        profile, drives = self.profile, self.phase is AutopilotPhase.DRIVING
        if profile is not None and drives and profile.coasts(self.parameters.values):
            self.left_alone(LeftAlone.STAND, now)
        else:
            self._ask_mode(profile.holds if profile is not None else None, now)

    def set_mode(self, name: str, now: float) -> None:
        """Ask for a mode by its name; one that is not offered changes nothing."""
        number = self.profile.mode_number(name) if self.profile is not None else None
        self._ask_mode(number, now, drives=self.armed and not self.grounded)

    def left_alone(self, action: LeftAlone | None, now: float) -> None:
        """Do this without an operator, once it stands; None: one is there. Another's mode stays."""
        self._alone.begin(action, now)
        if action is not None:
            self._rest(now)
        self._do_alone(now)

    def stop_driving(self, now: float) -> None:
        """End the motion at once; where the order to drive is not valid, the phase too."""
        if self.phase is AutopilotPhase.DRIVING and not self.orders.follows:
            self.phase = AutopilotPhase.ELSEWHERE
        self._rest(now)

    # Received and sent.

    def received(self, frame: MavlinkFrame, now: float) -> None:
        """Take a frame of the link."""
        before = self.profile
        match self.heard.take(frame, now, silent=self.phase in _AWAY):
            case Heard.HEARTBEAT:
                if self.profile is not before:
                    self.heard.forget()
                    self.orders.forget()
                    self.learning.forget("")
                self._heartbeat(frame, now)
            case Heard.ANSWER:
                self._requests.answer(frame["command"], frame["result"], now)
            case (Heard.BOOTED | Heard.ANOTHER) as start:
                self._learn_again(now, start.value)

    def another_sender(self, now: float) -> None:
        """Frames come from another place from now on: perhaps it is another vehicle."""
        if self.system:
            self.heard.forget()
            self._learn_again(now, Heard.ANOTHER.value)

    def step(self, now: float) -> None:
        """Let time pass: change the phase, and send what is due."""
        if now - self._stepped > _PAUSE_S:
            self._gate.close()
            self.liveness.paused(now)
        self._stepped = now
        self.texts.step(now)
        self.telemetry.step(now)
        self._change_phase(now)
        self.orders.step(self.mode, now, armed=self.armed)
        self._do_alone(now)
        self._do_better(now)
        self._sender.heartbeat(now)
        if self.system and (stamp := self.liveness.echo_due(now)):
            self._sender.message("TIMESYNC", ts1=stamp)
        if self._sticks.due(self._gate.velocity, now, lossy=self.liveness.lossy):
            self._send_velocity(now)
        self.tilt.step(self.telemetry.tilt, now, allowed=self._sends_sticks(now))
        if self.system:
            self.learning.send(self._sender, now, reads=self.phase is not AutopilotPhase.GONE)

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
    def telemetry(self) -> Telemetry:
        """What it measures; another object after each of its starts."""
        return self.heard.telemetry

    @property
    def twin(self) -> bool:
        """Whether two vehicles answer with its number."""
        return self._twins.seen(self._stepped)

    @property
    def grounded(self) -> bool:
        """Whether it flies, and is on the ground: Rune does not take off."""
        return self.profile is not None and self.profile.flies and not self.telemetry.in_air

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

    @property
    def _can_change(self) -> bool:
        """Whether it can be asked for a mode: one that starts would forget it."""
        return self.phase not in _AWAY and not self._starts and not self.twin

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

    def _change_phase(self, now: float) -> None:
        before = self.phase
        if self.system == 0:
            return
        if self.liveness.gone(now, was=before is AutopilotPhase.GONE):
            if before is not AutopilotPhase.GONE:
                self._rest(now)
                self.orders.gone()
                self._twins.gone()
                self.learning.gone()
            self.phase = AutopilotPhase.GONE
        elif before in _AWAY:
            self._come_back(now)
        elif self._twins.seen(now) is not (self.learns_because == _TWINS):
            self._learn_again(now, "")
        elif before is AutopilotPhase.LEARNING:
            if self.learning.done(now) and not self._starts and not self._twins.seen(now):
                self.learning.learnt = True
                self._by_heartbeat(now)
        elif self.learning.is_silent(self.telemetry.measured, now):
            self._learn(now, _SILENT)
        else:
            self._by_heartbeat(now)
        if self.phase is not before:
            self._rest(now)

    def _come_back(self, now: float) -> None:
        """It is there: go on with a vehicle that is known, as soon as its telemetry shows that."""
        back = self.learning.back(self.telemetry.measured, now)
        if self._starts or self._twins.seen(now) or back is Return.LEARN:
            self._learn(now, _STARTS if self._starts else self.learning.because)
        elif back is Return.GO_ON:
            self.learning.go_on()
            self._by_heartbeat(now)

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

    def _rest(self, now: float) -> None:
        """Send a neutral velocity; the next ones begin with one. A link may keep older ones."""
        self._gate.close()
        self._send_velocity(now)

    def _learn_again(self, now: float, because: str) -> None:
        self._rest(now)
        self.orders.forget()
        self.learning.forget(because)
        if self.phase not in _AWAY:
            self._learn(now, because)

    def _learn(self, now: float, because: str) -> None:
        """Ask for everything: a vehicle that was booted knows nothing of this station."""
        if because == _STARTS or self.phase is AutopilotPhase.ARMING:
            self.orders.forget()
        self.phase = AutopilotPhase.LEARNING
        self.learning.forget(because)
        self.learns_because = _TWINS if self._twins.seen(now) else because
        self._gate.close()
        self.learning.begin(self.profile, now)

    def _ask_mode(self, number: int | None, now: float, *, drives: bool = False) -> None:
        """Ask for a mode, if there is one; `drives`: to drive in it, where that is possible."""
        if self.profile is not None and number is not None and self._can_change:
            order = ModeOrder.to(self.profile, number, drives=drives)
            if self.armed or self.telemetry.position or not order.needs_place:
                self._change_mode(order, now)
            else:
                self.orders.refuse_without_place(order, now)

    def _change_mode(self, order: ModeOrder, now: float) -> None:
        """Ask for a mode; the velocities begin with a neutral one."""
        self._alone.action = None
        self.orders.change(order, now, _WAKING_S if order.drives and self.armed else 0.0)
        self.stop_driving(now)

    def _do_alone(self, now: float) -> None:
        """Ask for the mode of a vehicle without an operator, as soon as it can be asked."""
        if self.phase is not AutopilotPhase.LEARNING and self._can_change:
            driven = self.phase is AutopilotPhase.DRIVING
            number = self._alone.mode(self.profile, self.telemetry, now, driven=driven)
            if self.armed and self.orders.chosen_here(self.mode, now):
                self._ask_mode(number, now)

    def _do_better(self, now: float) -> None:
        """Ask for the best driving mode once it can be had; the operator has asked to drive."""
        profile, place, rests = self.profile, self.telemetry.position, self._gate.velocity.neutral
        drives = self.phase is AutopilotPhase.DRIVING and self._alone.action is None
        drives = drives and not self.orders.changing(now)
        self.better.waits = False
        if profile is None or not drives or self.orders.named:
            return
        if self.better.due(profile, self.mode, now, place=place, rests=rests):
            self._change_mode(ModeOrder.driving(profile, place=True), now)

    def _sends_sticks(self, now: float) -> bool:
        """Whether sticks are sent: else a pilot or another station has the vehicle."""
        if self.phase in _FOLLOWED:
            return True
        beside = self.phase in _BESIDE or (
            self.phase is AutopilotPhase.GONE and self.armed and self.liveness.answered_lately(now)
        )
        return beside and self.orders.chosen_here(self.mode, now)

    def _send_velocity(self, now: float) -> None:
        if self.profile is None or not self._sends_sticks(now):
            return
        values, read = self.parameters.values, self.telemetry
        self._sticks.send(self.profile, self.mode, self.velocity, values, read, now)
