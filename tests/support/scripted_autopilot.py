"""An autopilot on the wire whose answers a test chooses, with a clock of the test's own."""

import math
from collections.abc import Iterator

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.profiles.profile import Setpoint
from hub.robots.mavlink.vehicle.reasons import why
from hub.robots.mavlink.vehicle.vehicle import MavlinkVehicle
from hub.robots.mavlink.wire.definitions import BY_NUMBER
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from tests.support.mavlink_numbers import BLIMP, ROVER, SUB

PARAMETERS = {
    ROVER: {"FS_GCS_ENABLE": 1.0, "FS_TIMEOUT": 0.1, "MAV_GCS_SYSID": 255.0},
    SUB: {
        "PILOT_SPEED": 50.0,
        "PILOT_SPEED_UP": 50.0,
        "PILOT_SPEED_DN": 0.0,
        "ACRO_YAW_P": 3.375,
        "JS_GAIN_DEFAULT": 0.5,
        "MAV_GCS_SYSID": 255.0,
    },
    BLIMP: {"MAX_VEL_XY": 0.2, "MAX_VEL_Z": 0.2, "MAX_VEL_YAW": 0.4, "MAV_GCS_SYSID": 255.0},
}
STEP_S = 0.02
READY = 0x10000000


class ScriptedAutopilot:
    """A vehicle and the autopilot that a test scripts, joined without a link.

    Attributes:
        now: The time [s].
        vehicle: What is tested.
        sent: Each frame that the vehicle sent, with its time.
        armed: Whether the autopilot is armed; a test may set this and what follows.
        mode: Its mode.
        status: Its system_status.
        mute: Whether it sends nothing.
        deaf: Whether it receives nothing.
        bare: Whether it sends heartbeats only.
        refused: Results of commands that it refuses, by command and first two parameters.
        texts: Texts that it sends before such a refusal.
        forgets: How many accepted modes it forgets.
        parameters: Its parameters.
        position: Whether it knows its place.
        booted: When it was booted [s].
        silent: Names of streams that it does not send.
        moves: Its speed to the north [m/s].
    """

    def __init__(self, kind=ROVER, *, autopilot=3, system=0, mode=0, armed=False, status=3):
        self.now = 100.0
        self.kind, self.autopilot = kind, autopilot
        self.sent: list[tuple[float, MavlinkFrame]] = []
        limits = Setpoint(ahead=1.0, left=0.5, up=0.5, turn=1.0)
        self.vehicle = MavlinkVehicle(self._take, FramePacker(255, 190), limits, system)
        self.armed, self.mode, self.status = armed, mode, status
        self.mute = self.deaf = self.bare = False
        self.refused: dict[tuple[int, float, float], int] = {}
        self.texts: list[str] = []
        self.forgets = 0
        self.parameters = dict(PARAMETERS.get(kind, {}))
        self.position = True
        self.silent: set[str] = set()
        self.booted = self.now - 60.0
        self.moves = 0.0
        self._parser = FrameParser()
        self._inbox: list[MavlinkFrame] = []
        self._streams: dict[str, float] = {}
        self._due: dict[str, float] = {}
        self._shown: tuple[bool, int, int] | None = None

    # What a test does.

    def run(self, seconds):
        """Let time pass."""
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.now += STEP_S
            self._obey()
            if not self.mute:
                self._report()
            self.vehicle.step(self.now)

    def until(self, condition, longest=30.0):
        """Let time pass until a condition of no arguments holds."""
        end = self.now + longest
        while not condition():
            assert self.now < end, f"it never holds: phase {self.vehicle.phase.name}"
            self.run(STEP_S)

    def tell(self, name, /, system=1, component=1, **fields):
        """Let the vehicle hear a message of any sender."""
        packed = FramePacker(system, component).pack(name, **fields)
        (frame,) = FrameParser().feed(packed)
        self.hear(frame)

    def hear(self, frame):
        """Let the vehicle hear a frame."""
        self.vehicle.received(frame, self.now)

    def heartbeat(self, **fields):
        """Let the vehicle hear a heartbeat of the autopilot; fields replace its own."""
        own = {
            "type": self.kind,
            "autopilot": self.autopilot,
            "base_mode": 1 | 128 * self.armed,
            "custom_mode": self.mode,
            "system_status": self.status,
        }
        self.tell("HEARTBEAT", **(own | fields))

    def on_sent(self, frame):
        """Keep a frame that the vehicle sent."""
        self.sent.append((self.now, frame))

    def boot(self):
        """Start anew: disarmed, without streams."""
        self.booted = self.now
        self.armed = False
        self._streams.clear()

    def velocity(self, ahead=0.0, left=0.0, up=0.0, turn=0.0):
        """Ask the vehicle for a velocity."""
        self.vehicle.set_velocity(Setpoint(ahead=ahead, left=left, up=up, turn=turn), self.now)

    def driving(self):
        """Arm and drive, with a neutral stick."""
        self.until(lambda: self.vehicle.phase.name == "DISARMED")
        self.vehicle.arm(self.now)
        self.until(lambda: self.vehicle.phase.name == "DRIVING")
        self.velocity()
        return self

    # What a test sees.

    def names(self, since=-math.inf):
        """Names of the messages that were sent from a time on."""
        return [frame.name for at, frame in self.sent if at >= since]

    def commands(self, number, since=-math.inf):
        """The parameters of the commands of a number that were sent."""
        return [
            tuple(frame[f"param{place}"] for place in range(1, 4))
            for at, frame in self.sent
            if at >= since and frame.name == "COMMAND_LONG" and frame["command"] == number
        ]

    def moving(self, since=-math.inf) -> Iterator[MavlinkFrame]:
        """The frames that move a vehicle."""
        return (frame for at, frame in self.sent if at >= since and moves(frame))

    # Inside.

    def _take(self, data):
        frames = self._parser.feed(data)
        for frame in frames:
            self.on_sent(frame)
        if not self.deaf:
            self._inbox += frames

    def _obey(self):
        frames, self._inbox = self._inbox, []
        for frame in frames:
            if frame.name == "TIMESYNC" and not self.mute:
                self.tell("TIMESYNC", tc1=int((self.now - self.booted) * 1e9) + 1, ts1=frame["ts1"])
            elif frame.name == "PARAM_REQUEST_READ" and frame["param_id"] in self.parameters:
                self._tell_parameter(frame["param_id"])
            elif frame.name == "COMMAND_LONG":
                self._command(frame)

    def _command(self, frame):
        key = (frame["command"], frame["param1"], frame["param2"])
        result = self.refused.get(key, 0)
        if result:
            for text in self.texts:
                self.tell("STATUSTEXT", severity=2, text=text)
        elif key[0] == 176:
            if self.forgets:
                self.forgets -= 1
            else:
                self.mode = int(key[2])
        elif key[0] == 400:
            self.armed = bool(key[1])
        elif key[0] == 511:
            self._streams[BY_NUMBER[int(key[1])].name] = key[2] / 1e6
        if not self.mute:
            self.tell(
                "COMMAND_ACK",
                command=key[0],
                result=result,
                target_system=255,
                target_component=190,
            )

    def _tell_parameter(self, name):
        if not self.mute:
            self.tell("PARAM_VALUE", param_id=name, param_value=self.parameters[name], param_type=9)

    def _report(self):
        shown = (self.armed, self.mode, self.status)
        if shown != self._shown or self.now >= self._due.get("HEARTBEAT", 0.0):
            self._shown, self._due["HEARTBEAT"] = shown, self.now + 1.0
            self.heartbeat()
        if self.bare:
            return
        boot_ms = int((self.now - self.booted) * 1e3)
        contents = {
            "ATTITUDE": {"time_boot_ms": boot_ms},
            "LOCAL_POSITION_NED": {"time_boot_ms": boot_ms, "vx": self.moves},
            "SYS_STATUS": {"onboard_control_sensors_health": READY},
            "EKF_STATUS_REPORT": {"flags": 831 if self.position else 167},
        }
        for name, every in list(self._streams.items()):
            if (
                name in contents
                and name not in self.silent
                and self.now >= self._due.get(name, 0.0)
            ):
                self._due[name] = self.now + every
                self.tell(name, **contents[name])


def moves(frame):
    """Whether a frame moves a vehicle: a velocity, or a stick that is not in its middle."""
    if frame.name == "SET_POSITION_TARGET_LOCAL_NED":
        return any(frame[field] for field in ("vx", "vy", "vz", "yaw_rate"))
    if frame.name == "MANUAL_CONTROL":
        return bool(frame["x"] or frame["y"] or frame["r"] or frame["z"] not in (0, 500))
    if frame.name == "RC_CHANNELS_OVERRIDE":
        return any(frame[f"chan{place}_raw"] not in (0, 1500, 65535) for place in range(1, 9))
    return False


def in_phase(bench: ScriptedAutopilot, phase: AutopilotPhase) -> ScriptedAutopilot:
    """A vehicle, once it is in a phase."""
    bench.until(lambda: bench.vehicle.phase is phase)
    return bench


def reason(bench: ScriptedAutopilot) -> str:
    """Why it does not follow velocities."""
    return why(bench.vehicle, bench.now)
