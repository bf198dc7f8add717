"""Takes the frames that come: what the vehicle measures, says and answers; pure."""

from __future__ import annotations

import enum
from typing import Final

from hub.robots.mavlink.vehicle.identity import VehicleIdentity
from hub.robots.mavlink.vehicle.liveness import Liveness
from hub.robots.mavlink.vehicle.other_stations import OtherStations
from hub.robots.mavlink.vehicle.parameter_reads import ParameterReads, parameter_value
from hub.robots.mavlink.vehicle.telemetry import Telemetry
from hub.robots.mavlink.vehicle.texts import VehicleTexts
from hub.robots.mavlink.vehicle.twins import Start, TwinWatch
from hub.robots.mavlink.wire.frames import MavlinkFrame

_NS_PER_MS: Final = 1_000_000


class Heard(enum.Enum):
    """What a frame means for the phase of the vehicle.

    Attributes:
        NOTHING: Nothing.
        HEARTBEAT: It is the vehicle's heartbeat.
        ANSWER: It answers a command of this station.
        BOOTED: The vehicle was booted.
        ANOTHER: Another vehicle sends with its number.
    """

    NOTHING = ""
    HEARTBEAT = "it is alive"
    ANSWER = "it answers"
    BOOTED = "it was booted"
    ANOTHER = "another vehicle sends with its number"


class VehicleReception:
    """The frames of one vehicle; times are monotonic [s].

    Attributes:
        identity: Its number and kind, and who else is on its link.
        telemetry: What it measures.
        parameters: The parameters that were read.
        texts: Its texts.
        liveness: Its heartbeats and echoes.
        stations: Other ground stations on its link.
        twins: Whether two vehicles answer with its number.
        firmware: Its version, a byte each: major, minor, patch, kind; 0: not known.
        refused: Frames without a genuine signature, where this station has a key.
    """

    def __init__(self, station: int, system: int) -> None:
        """Wait for a vehicle.

        Args:
            station: Number of this station.
            system: Number of the vehicle; 0: the first one that is heard.
        """
        self.identity = VehicleIdentity(system)
        self.telemetry = Telemetry()
        self.parameters = ParameterReads()
        self.texts = VehicleTexts()
        self.liveness = Liveness()
        self.stations = OtherStations(station)
        self.twins = TwinWatch()
        self.firmware = self.refused = 0

    def take(self, frame: MavlinkFrame, now: float, *, silent: bool) -> Heard:
        """Take a frame of the link.

        Args:
            frame: The frame.
            now: The time.
            silent: Whether the vehicle is silent: then its number may get a new kind.
        """
        self.stations.received(frame, self.identity.system, now)
        if frame.name != "HEARTBEAT":
            return self._answer(frame, now) if self.identity.sent(frame) else Heard.NOTHING
        if self.identity.heartbeat(frame, silent=silent):
            return Heard.HEARTBEAT
        if self.identity.is_twin(frame):
            self.twins.sign(now)
        return Heard.NOTHING

    def forget(self) -> None:
        """Another vehicle is there, or this one was booted."""
        self.telemetry = Telemetry()
        self.parameters.forget()
        self.twins.forget()

    def _answer(self, frame: MavlinkFrame, now: float) -> Heard:
        """Take a frame of the vehicle's autopilot."""
        heard = Heard.NOTHING
        match frame.name:
            case "TIMESYNC" if frame["tc1"]:
                if self.liveness.echo(frame["ts1"], now):
                    heard = self._start("TIMESYNC", frame["tc1"] // _NS_PER_MS, now)
            case "COMMAND_ACK" if self.stations.is_asker(frame):
                self.stations.answered(frame, now)
                heard = Heard.ANSWER
            case "PARAM_VALUE":
                profile = self.identity.profile
                bytewise = profile is not None and profile.bytewise
                self.parameters.take(frame["param_id"], parameter_value(frame, bytewise=bytewise))
            case "STATUSTEXT":
                self.texts.add(
                    frame["severity"], frame["text"], frame["id"], frame["chunk_seq"], now
                )
            case "AUTOPILOT_VERSION":
                self.firmware = frame["flight_sw_version"]
                self.twins.board(frame["uid"], now)
            case "ATTITUDE":
                heard = self._start("ATTITUDE", frame["time_boot_ms"], now)
                self.telemetry.take(frame, now)
            case _:
                self.telemetry.take(frame, now)
        return heard

    def _start(self, clock: str, boot_ms: int, now: float) -> Heard:
        """Take the time since its start; after another start all is forgotten but this time."""
        start = self.twins.start(clock, boot_ms, now)
        if start is Start.SAME:
            return Heard.NOTHING
        self.forget()
        self.twins.start(clock, boot_ms, now)
        return Heard.BOOTED if start is Start.BOOTED else Heard.ANOTHER
