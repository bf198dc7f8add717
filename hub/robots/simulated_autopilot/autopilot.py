"""A simulated autopilot: takes the bytes of stations, lets time pass, answers; pure.

| who | is obeyed in |
| --- | --- |
| the station MAV_GCS_SYSID | everything; its heartbeats and sticks are a sign of life |
| another station | commands, parameters, setpoints, not sticks; with MAV_OPTIONS 1 nothing |

With a key, link 0 takes frames without a signature, and the others drop them in silence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from hub.robots.mavlink.wire.frames import MavlinkFrame
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from hub.robots.simulated_autopilot.buttons import JoystickButtons
from hub.robots.simulated_autopilot.commands import (
    ACCEPTED,
    CALIBRATE,
    CALIBRATING_S,
    FAILED,
    RESTART,
    answer,
)
from hub.robots.simulated_autopilot.condition import INFO, VehicleCondition
from hub.robots.simulated_autopilot.failsafes import FAILSAFES, Failsafes
from hub.robots.simulated_autopilot.kinds import AutopilotKind
from hub.robots.simulated_autopilot.motion import VehicleMotion
from hub.robots.simulated_autopilot.parameters import ParameterStore
from hub.robots.simulated_autopilot.pilot import demand, take_setpoint, take_sticks
from hub.robots.simulated_autopilot.questions import answer_question, send_parameter
from hub.robots.simulated_autopilot.reports import (
    REPORTS,
    default_rates,
    heartbeat,
    named_values,
)
from hub.robots.simulated_autopilot.startup import Startup
from hub.robots.simulated_autopilot.station_link import COMPONENT, StationLink

STEP: Final = 0.02
"""Length of a step of the main loop [s]."""
_BEHIND: Final = 0.5
"""Time that is skipped after a pause of the process [s]."""
_DOWN_S: Final = 0.3
"""Time without power in a restart [s]."""
_CHUNK: Final = 50
"""Longest text of one STATUSTEXT."""
_PREARM_S: Final = 30.0
_FIRST_PREARM_S: Final = 30.8
_ELEVATION_S: Final = 1.05
_ONLY_STATION: Final = 1
_KEY: Final = 32
_NEWEST: Final = 1 << 47
"""Largest stamp of a key."""
_LIFE: Final = frozenset({"HEARTBEAT", "MANUAL_CONTROL", "RC_CHANNELS_OVERRIDE"})


class SimulatedAutopilot:
    """One vehicle with its links.

    Attributes:
        vehicle: Its state.
        parameters: Its parameters.
    """

    def __init__(
        self,
        kind: AutopilotKind,
        motion: VehicleMotion,
        parameters: ParameterStore,
        now: float,
        *,
        fast_start: bool = False,
    ) -> None:
        """Start the vehicle.

        Args:
            kind: What it is.
            motion: Moves it.
            parameters: Its parameters.
            now: Monotonic time [s].
            fast_start: Whether it starts in a second.
        """
        self.parameters = parameters
        self._kind, self._motion, self._fast = kind, motion, fast_start
        self._links: list[StationLink] = []
        self._key: bytes | None = None
        self._time = now
        self._clock = SigningClock()
        self._text_number = 0
        self._restart_at = math.inf
        self._restarted: Callable[[], None] = lambda: None
        self._later: list[tuple[float, StationLink, MavlinkFrame]] = []
        self._begin(now)

    def on_restart(self, act: Callable[[], None]) -> None:
        """Call this at each restart, when all connections end."""
        self._restarted = act

    def connect(
        self, send: Callable[[bytes], None], number: int, *, datagrams: bool = False
    ) -> StationLink:
        """Add a link.

        Args:
            send: Sends a frame, without waiting.
            number: Of the link; 0 needs no signatures.
            datagrams: Whether each piece of data is a datagram.
        """
        link = StationLink(send, number, datagrams=datagrams)
        self._links.append(link)
        self._begin_link(link)
        return link

    def disconnect(self, link: StationLink) -> None:
        """Remove a link."""
        if link in self._links:
            self._links.remove(link)

    def received(self, link: StationLink, data: bytes) -> None:
        """Take the bytes of a link."""
        if self._restart_at < math.inf:
            return
        for frame in link.frames(data):
            self._take(link, frame)

    def step(self, now: float) -> None:
        """Let time pass, up to a monotonic time [s], in whole steps."""
        if now - self._time > _BEHIND:
            self._time = now - _BEHIND
        while self._time + STEP <= now:
            self._time += STEP
            self._step()

    # Its start.

    def _begin(self, now: float) -> None:
        startup = Startup(self._kind.name, now, fast=self._fast)
        self._time = now
        self.vehicle = VehicleCondition(self._kind, self.parameters, self._motion.state, startup)
        self._buttons = JoystickButtons(self.vehicle)
        self._failsafes: Failsafes = FAILSAFES[self._kind.name](self.vehicle)
        self._heartbeat_at = now + startup.times.heard * (0.1 if self._fast else 1.0)
        self._prearm_at = now + _FIRST_PREARM_S
        self._elevation_at = self._sync_at = now + 10.0
        for link in self._links:
            self._begin_link(link)

    def _begin_link(self, link: StationLink) -> None:
        signer = Signer(self._key, self._clock, link.number) if self._key else None
        system = max(1, min(255, int(self.parameters["MAV_SYSID"])))
        link.begin(system, signer, default_rates(self._kind.name))

    def _restart(self) -> None:
        self._later.clear()
        self._restart_at = math.inf
        self._restarted()
        self._begin(self._time)

    # Time.

    def _step(self) -> None:
        vehicle, now = self.vehicle, self._time
        if now >= self._restart_at:
            self._restart()
            return
        if self._restart_at < math.inf:
            return
        vehicle.step(now)
        lasting = self.parameters["RC_OVERRIDE_TIME"]
        fresh = vehicle.radio.step(now, lasting, receiver=vehicle.receiver)
        self._failsafes.step(fresh=fresh)
        self._motion.step(demand(vehicle), STEP)
        self._say_more()
        if now >= self._heartbeat_at:
            self._heartbeat_at += 1.0
            vehicle.mode_shown = False
        self._show_mode()
        for link in self._links:
            self._report(link)
        self._send_texts()
        for each in [each for each in self._later if each[0] <= now]:
            self._later.remove(each)
            _acknowledge(each[1], each[2], ACCEPTED)

    def _show_mode(self) -> None:
        """Send a heartbeat where one is due; a change of the mode does not wait for the next."""
        if not self.vehicle.mode_shown:
            self.vehicle.mode_shown = True
            for link in self._links:
                link.send("HEARTBEAT", **heartbeat(self.vehicle))

    def _report(self, link: StationLink) -> None:
        vehicle = self.vehicle
        for name in link.due(self._time):
            if name == "NAMED_VALUE_FLOAT":
                for key, value in named_values(vehicle).items():
                    link.send(name, time_boot_ms=vehicle.age_ms, name=key, value=value)
                continue
            fields = REPORTS[name](vehicle)
            if fields is not None:
                link.send(name, **fields)
        for name, index in link.parameters_due():
            send_parameter(self.parameters, link, name, index)

    def _say_more(self) -> None:
        """Say what it repeats: why it does not arm, its height, its time."""
        vehicle, now = self.vehicle, self._time
        if now >= self._prearm_at:
            self._prearm_at = now + _PREARM_S
            if not vehicle.armed:
                for text in vehicle.arm_refusals():
                    vehicle.say(2, f"PreArm: {text}")
        if now >= self._elevation_at:
            self._elevation_at = now + _ELEVATION_S
            if not vehicle.armed and vehicle.has_origin and self._kind.name != "sub":
                vehicle.say(INFO, "Field Elevation Set: 0m")
        if now >= self._sync_at:
            self._sync_at = now + 10.0
            for link in self._links:
                link.send("TIMESYNC", ts1=vehicle.age_ms * 1_000_000)

    def _send_texts(self) -> None:
        for severity, text in self.vehicle.take_texts():
            chunks = [text[at : at + _CHUNK] for at in range(0, len(text), _CHUNK)]
            number = 0
            if len(chunks) > 1:
                self._text_number = number = self._text_number % 65_535 + 1
            for place, chunk in enumerate(chunks):
                for link in self._links:
                    link.send(
                        "STATUSTEXT", severity=severity, text=chunk, id=number, chunk_seq=place
                    )

    # What stations send.

    def _take(self, link: StationLink, frame: MavlinkFrame) -> None:
        ours = frame.system == int(self.parameters["MAV_GCS_SYSID"])
        if not ours and int(self.parameters["MAV_OPTIONS"]) & _ONLY_STATION:
            return
        fields = frame.fields
        system = int(self.parameters["MAV_SYSID"])
        target = fields.get("target_system", fields.get("target", 0))
        if frame.name != "TIMESYNC" and target not in (0, system):
            return
        if fields.get("target_component", 0) not in (0, COMPONENT):
            return
        if ours and frame.name in _LIFE:
            self._take_life(frame, addressed=target == system)
        elif frame.name in ("COMMAND_LONG", "COMMAND_INT"):
            self._command(link, frame)
        elif frame.name not in _LIFE:
            self._take_order(link, frame)

    def _take_life(self, frame: MavlinkFrame, *, addressed: bool) -> None:
        """Take what shows that the vehicle's own station is there: its heartbeat, its sticks."""
        vehicle, fields = self.vehicle, frame.fields
        if frame.name == "HEARTBEAT":
            vehicle.station_heard = self._time
        elif addressed:
            vehicle.station_heard = self._time
            if frame.name == "RC_CHANNELS_OVERRIDE":
                for channel in range(1, 9):
                    vehicle.radio.override(channel, fields[f"chan{channel}_raw"], self._time)
                return
            take_sticks(vehicle, fields)
            if self._kind.name == "sub":
                self._buttons.take(fields["buttons"])

    def _take_order(self, link: StationLink, frame: MavlinkFrame) -> None:
        vehicle, fields = self.vehicle, frame.fields
        match frame.name:
            case "SET_POSITION_TARGET_LOCAL_NED":
                take_setpoint(vehicle, fields)
            case "TIMESYNC" if not fields["tc1"]:
                since_start = vehicle.age_ms * 1_000_000 + 1  # 0 is a question
                link.send("TIMESYNC", tc1=since_start, ts1=fields["ts1"])
            case "SET_MODE" if fields["base_mode"] & 1:
                vehicle.ask_mode(fields["custom_mode"])
                self._show_mode()
            case "SET_GPS_GLOBAL_ORIGIN":
                vehicle.set_origin()
            case "VISION_POSITION_ESTIMATE":
                vehicle.saw_place()
            case "PARAM_SET":
                if self.parameters.set(fields["param_id"], fields["param_value"]):
                    for each in self._links:
                        send_parameter(self.parameters, each, fields["param_id"])
            case "SETUP_SIGNING" if not vehicle.armed:
                self._set_key(fields)
            case _:
                answer_question(vehicle, link, frame)

    def _command(self, link: StationLink, frame: MavlinkFrame) -> None:
        fields, vehicle = frame.fields, self.vehicle
        command = fields["command"]
        values = tuple(fields[f"param{place}"] for place in range(1, 5))
        if command == RESTART and values[0] == 1.0:
            _acknowledge(link, frame, FAILED if vehicle.armed else ACCEPTED)
            if not vehicle.armed:
                self._restart_at = self._time + _DOWN_S
        elif command == CALIBRATE and values[0] == 1.0 and not vehicle.armed:
            self._later.append((self._time + CALIBRATING_S, link, frame))
        else:
            _acknowledge(link, frame, answer(vehicle, link, command, values))
            self._show_mode()

    def _set_key(self, fields: Mapping[str, Any]) -> None:
        key = bytes(fields["secret_key"])[:_KEY]
        self._key = key if any(key) else None
        self._clock.heard(min(fields["initial_timestamp"], _NEWEST))
        for link in self._links:
            rates = {name: 1.0 / every for name, every in link.rates.items()}
            self._begin_link(link)
            link.rates = {name: 1.0 / rate if rate else math.inf for name, rate in rates.items()}


def _acknowledge(link: StationLink, frame: MavlinkFrame, result: int) -> None:
    """Answer to the sender."""
    link.send(
        "COMMAND_ACK",
        command=frame.fields["command"],
        result=result,
        target_system=frame.system,
        target_component=frame.component,
    )
