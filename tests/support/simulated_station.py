"""A ground station beside a simulated autopilot, with a clock of its own: no test waits."""

from collections.abc import Mapping

from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser, MavlinkFrame
from hub.robots.simulated_autopilot.autopilot import SimulatedAutopilot
from hub.robots.simulated_autopilot.kinds import AUTOPILOT_KINDS
from hub.robots.simulated_autopilot.motion import FittedMotion
from hub.robots.simulated_autopilot.parameters import ParameterStore

TICK = 0.02
NEUTRAL = {
    "rover": ("MANUAL_CONTROL", {"target": 1}),
    "sub": ("MANUAL_CONTROL", {"target": 1, "z": 500}),
    "blimp": (
        "RC_CHANNELS_OVERRIDE",
        {"target_system": 1, **{f"chan{place}_raw": 1500 for place in range(1, 9)}},
    ),
}


def blimp_sticks(**channels: int) -> tuple[str, dict[str, int]]:
    """RC_CHANNELS_OVERRIDE with the middle but for these: c1=1600."""
    name, fields = NEUTRAL["blimp"]
    return name, fields | {f"chan{each[1:]}_raw": value for each, value in channels.items()}


def velocity(vx: float = 0.0, yaw_rate: float = 0.0, **more: float) -> tuple[str, dict]:
    """A velocity of the body."""
    fields = {"coordinate_frame": 8, "type_mask": 0x5C7, "target_system": 1, "target_component": 1}
    return "SET_POSITION_TARGET_LOCAL_NED", fields | {"vx": vx, "yaw_rate": yaw_rate, **more}


class World:
    """A simulated vehicle and its time.

    Attributes:
        now: The time [s].
        autopilot: The vehicle.
    """

    def __init__(
        self,
        kind: str,
        *,
        fast: bool = True,
        depth: float = 0.0,
        settings: Mapping[str, float] | None = None,
    ) -> None:
        self.now = 100.0
        self.kind = kind
        self.motion = FittedMotion(kind, depth=depth)
        self.autopilot = SimulatedAutopilot(
            AUTOPILOT_KINDS[kind],
            self.motion,
            ParameterStore(kind, settings or {}),
            self.now,
            fast_start=fast,
        )
        self.stations: list[Station] = []

    def station(self, system: int = 255, number: int = 1) -> "Station":
        """Another station with a link of its own."""
        made = Station(self, system, number)
        self.stations.append(made)
        return made

    def wait(self, seconds: float) -> None:
        """Let time pass; the stations repeat what they were told to repeat."""
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.now = min(end, self.now + TICK)
            for station in self.stations:
                station.repeat()
            self.autopilot.step(self.now)


class Station:
    """One ground station.

    Attributes:
        frames: All that came.
        repeated: Messages that it repeats at 20 Hz, by name.
        alive: Whether it sends heartbeats.
        repeated_at: When it last did so [s].
    """

    def __init__(self, world: World, system: int, number: int) -> None:
        self._world = world
        self._packer, self._parser = FramePacker(system, 190), FrameParser()
        self.frames: list[MavlinkFrame] = []
        self.repeated: dict[str, dict] = {}
        self.alive = True
        self._beat = self.repeated_at = 0.0
        self.link = world.autopilot.connect(self._take, number)

    def _take(self, data: bytes) -> None:
        self.frames += self._parser.feed(data)

    def raw(self, data: bytes) -> None:
        """Send bytes."""
        self._world.autopilot.received(self.link, data)

    def send(self, name: str, fields: Mapping[str, object]) -> None:
        """Send a message."""
        self.raw(self._packer.pack(name, **fields))

    def stream(self, *messages: tuple[str, dict]) -> None:
        """Repeat these messages from now on, and no others."""
        self.repeated = dict(messages)
        self.repeated_at = 0.0

    def repeat(self) -> None:
        """Send what is due."""
        now = self._world.now
        if self.alive and now - self._beat >= 1.0:
            self._beat = now
            self.send("HEARTBEAT", {"type": 6, "autopilot": 8})
        if now - self.repeated_at >= 0.05 - 1e-9:
            self.repeated_at = now
            for name, fields in self.repeated.items():
                self.send(name, fields)

    def command(self, number: int, *values: float) -> int | None:
        """Send a COMMAND_LONG; returns the result, or None without an answer."""
        fields = {f"param{place}": value for place, value in enumerate(values, 1)}
        before = len(self.frames)
        target = {"target_system": 1, "target_component": 1}
        self.send("COMMAND_LONG", {"command": number, **fields, **target})
        self._world.wait(TICK)
        for frame in self.frames[before:]:
            if frame.name == "COMMAND_ACK" and frame["command"] == number:
                return frame["result"]
        return None

    def rate(self, name: str, hertz: float) -> int | None:
        """Ask for a message so often; returns the result."""
        return self.command(511, BY_NAME[name].number, 1e6 / hertz)

    def mode(self, number: int) -> int | None:
        """Ask for a mode; returns the result."""
        return self.command(176, 1, number)

    def arm(self) -> int | None:
        """Ask it to arm; returns the result."""
        return self.command(400, 1)

    def texts(self) -> list[str]:
        """All texts of the vehicle."""
        return [frame["text"] for frame in self.of("STATUSTEXT")]

    def of(self, name: str) -> list[MavlinkFrame]:
        """All messages of a name."""
        return [frame for frame in self.frames if frame.name == name]

    def beat(self) -> MavlinkFrame:
        """The last heartbeat."""
        return self.of("HEARTBEAT")[-1]
