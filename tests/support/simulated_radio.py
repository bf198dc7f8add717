"""A driver's vehicle and a simulated autopilot, joined by a radio that loses and delays frames.

All is on one simulated clock. An operator pushes a stick; while velocities wait for a neutral one,
it lets go for a second.
"""

import random
from collections import Counter, deque
from collections.abc import Callable

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.profiles.profile import NEUTRAL, Setpoint
from hub.robots.mavlink.vehicle.reasons import why
from hub.robots.mavlink.vehicle.vehicle import MavlinkVehicle
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from tests.support.simulated_station import World

TICK_S = 0.025
DRIVER_S = 0.05
"""Time between two steps of the driver [s]."""
SAFE = {
    "rover": {
        "SIM_RC_FAIL": 1,
        "FS_GCS_ENABLE": 1,
        "FS_GCS_TIMEOUT": 2,
        "FS_THR_ENABLE": 1,
        "FS_TIMEOUT": 0.1,
        "FS_ACTION": 2,
        "RC_OVERRIDE_TIME": 0.5,
    },
    "sub": {
        "SIM_RC_FAIL": 1,
        "FS_PILOT_INPUT": 1,
        "FS_PILOT_TIMEOUT": 0.5,
        "FS_GCS_ENABLE": 4,
        "FS_GCS_TIMEOUT": 2,
    },
    "blimp": {"SIM_RC_FAIL": 1, "RC_OVERRIDE_TIME": 0.5, "FS_THR_ENABLE": 1},
}
"""Parameters that make a vehicle without a receiver safe."""
_RELEASED_S = 1.0


class _Way:
    """One direction of the radio; what comes keeps its order."""

    def __init__(self, chance: random.Random, take: Callable[[bytes], None]) -> None:
        self.loss, self.delay = 0.0, 0.0
        self._chance, self._take = chance, take
        self._air: deque[tuple[float, bytes]] = deque()

    def send(self, frame: bytes, now: float) -> None:
        if self._chance.random() >= self.loss:
            self._air.append((now + self.delay, frame))

    def step(self, now: float) -> None:
        while self._air and self._air[0][0] <= now:
            self._take(self._air.popleft()[1])


class RadioDrive:
    """A vehicle that is driven by radio.

    Attributes:
        world: The simulated vehicle.
        vehicle: The driver's end.
        up: The way to the vehicle; its `loss` and `delay` [s] may change.
        down: The way back.
        wanted: The velocity that the operator pushes for.
        phases: Steps in each phase.
        learnt: Why it went to LEARNING, each time.
        travelled: Way of the simulated vehicle along its nose [m].
    """

    def __init__(self, kind: str, seed: int, *, depth: float = 0.0) -> None:
        self.world = World(kind, depth=depth, settings=SAFE[kind])
        limits = Setpoint(ahead=1.0, left=1.0, up=1.0, turn=1.0)
        packer = FramePacker(255, 190)
        self.vehicle = MavlinkVehicle(lambda frame: self.up.send(frame, self.now), packer, limits)
        chance, parser = random.Random(seed), FrameParser()
        link = self.world.autopilot.connect(
            lambda frame: self.down.send(frame, self.now), 1, datagrams=True
        )
        self.up = _Way(chance, lambda frame: self.world.autopilot.received(link, frame))
        self.down = _Way(
            chance,
            lambda data: [self.vehicle.received(each, self.now) for each in parser.datagram(data)],
        )
        self.wanted = NEUTRAL
        self.phases: Counter[AutopilotPhase] = Counter()
        self.learnt: list[str] = []
        self.travelled = 0.0
        self._driver_at = self.now
        self._released_until = 0.0

    @property
    def now(self) -> float:
        """The time [s]."""
        return self.world.now

    @property
    def why(self) -> str:
        """Why it does not follow velocities."""
        return why(self.vehicle, self.now)

    def step(self) -> None:
        """Let a tick pass."""
        self.world.wait(TICK_S)
        self.travelled += self.world.motion.state.ahead * TICK_S
        self.up.step(self.now)
        self.down.step(self.now)
        if self.now < self._driver_at:
            return
        self._driver_at = max(self.now, self._driver_at + DRIVER_S)
        before = self.vehicle.phase
        self.vehicle.set_velocity(self._pushed(), self.now)
        self.vehicle.step(self.now)
        self.phases[self.vehicle.phase] += 1
        if self.vehicle.phase is AutopilotPhase.LEARNING is not before:
            self.learnt.append(self.vehicle.learns_because)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        end = self.now + seconds
        while self.now < end:
            self.step()

    def until(self, phase: AutopilotPhase, longest: float = 60.0) -> None:
        """Let time pass until a phase begins."""
        end = self.now + longest
        while self.vehicle.phase is not phase:
            assert self.now < end, f"never {phase.name}: {self.vehicle.phase.name}, {self.why}"
            self.step()

    def drive(self) -> "RadioDrive":
        """Arm, and drive; the operator presses again where nothing follows."""
        self.until(AutopilotPhase.DISARMED)
        end = self.now + 120.0
        while self.vehicle.phase is not AutopilotPhase.DRIVING:
            assert self.now < end, f"never driven: {self.vehicle.phase.name}, {self.why}"
            if self.vehicle.phase is AutopilotPhase.DISARMED:
                self.vehicle.arm(self.now)
            elif self.vehicle.phase is AutopilotPhase.ELSEWHERE:
                self.vehicle.drive(self.now)
            self.run(3.0)
        self.phases.clear()
        self.learnt.clear()
        return self

    def share(self, phase: AutopilotPhase) -> float:
        """Part of the time in a phase, since it drives."""
        return self.phases[phase] / max(1, self.phases.total())

    def _pushed(self) -> Setpoint:
        if self.vehicle.must_be_neutral and self.now >= self._released_until:
            self._released_until = self.now + _RELEASED_S
        return NEUTRAL if self.now < self._released_until else self.wanted
