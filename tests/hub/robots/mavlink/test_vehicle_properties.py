"""Whatever comes over the link, in any order: nothing moves without the operator's order."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.left_alone import LeftAlone
from hub.robots.mavlink.profiles.profile import Setpoint
from hub.robots.mavlink.profiles.table import PROFILES
from hub.robots.mavlink.vehicle.reasons import warnings, why
from hub.robots.mavlink.wire.definitions import BY_NAME
from hub.robots.mavlink.wire.frames import MavlinkFrame
from tests.support.mavlink_definitions import READ
from tests.support.mavlink_numbers import ARM, BLIMP, ROVER, SET_MODE, SUB
from tests.support.scripted_autopilot import ScriptedAutopilot, moves

CHANGING_S = 3.5
"""Longest time of a change of mode, with the time of its first request [s]."""
ORDER_S = 12.0
"""Longest time in which an order is carried out [s]."""
DRIVING = {ROVER: {15}, SUB: {2, 16}, BLIMP: {2}}


class WatchedAutopilot(ScriptedAutopilot):
    """Judges each frame that is sent by what the vehicle said and the operator asked."""

    def __init__(self, kind):
        self.asked = self.neutral = False
        self.asked_at = self.armed_at = self.mode_at = -math.inf
        self.said = None
        super().__init__(kind)

    def hear(self, frame):
        ours = frame.name == "HEARTBEAT" and (frame.system, frame.component) == (1, 1)
        if ours and (frame["autopilot"], frame["type"]) == (3, self.kind):
            self.said = bool(frame["base_mode"] & 128), frame["custom_mode"]
            late = self.now - self.asked_at > CHANGING_S
            if late and (not self.said[0] or self.said[1] not in DRIVING[self.kind]):
                self.asked = False
        super().hear(frame)

    def ask(self, *, drives, arms=False):
        """The operator gives an order."""
        self.asked, self.asked_at = drives, self.now
        self.mode_at = self.now
        if arms:
            self.armed_at = self.now

    def look(self):
        """See whether a new neutral velocity is needed."""
        if self.vehicle.phase is not AutopilotPhase.DRIVING:
            self.neutral = False

    def on_sent(self, frame):
        self.look()
        if moves(frame):
            assert self.vehicle.phase is AutopilotPhase.DRIVING
            assert self.asked, "it moves without an order"
            assert self.neutral, "it moves without a neutral stick"
            assert self.said is not None
            assert self.said[0], "it moves a disarmed vehicle"
            assert self.said[1] in DRIVING[self.kind], "it moves a vehicle in another mode"
        if frame.name == "COMMAND_LONG" and frame["command"] == SET_MODE:
            assert self.now - self.mode_at < ORDER_S, "it changes the mode without an order"
        if frame.name == "COMMAND_LONG" and frame["command"] == ARM and frame["param1"]:
            assert self.now - self.armed_at < ORDER_S, "it arms without an order"
        assert frame.name not in {"PARAM_SET", "SET_MODE"}


class AnyOrder(RuleBasedStateMachine):
    """Everything that may happen around a vehicle."""

    @initialize(kind=st.sampled_from([ROVER, SUB, BLIMP]))
    def begin(self, kind):
        self.bench = WatchedAutopilot(kind)
        self.bench.run(3.0)

    @rule(seconds=st.sampled_from([0.02, 0.1, 0.5, 1.0, 4.0]))
    def wait(self, seconds):
        for _ in range(round(seconds / 0.02)):
            self.bench.run(0.02)
            self.bench.look()

    @rule()
    def arm(self):
        if self.bench.vehicle.phase is AutopilotPhase.DISARMED:
            self.bench.ask(drives=True, arms=True)
        self.bench.vehicle.arm(self.bench.now)

    @rule()
    def drive(self):
        if self.bench.vehicle.armed:
            self.bench.ask(drives=True)
        self.bench.vehicle.drive(self.bench.now)

    @rule(place=st.integers(0, 4))
    def set_mode(self, place):
        profile = self.bench.vehicle.profile
        number = profile.offered[place % len(profile.offered)]
        self.bench.ask(drives=number in profile.drives)
        self.bench.vehicle.set_mode(profile.mode_name(number), self.bench.now)
        self.bench.look()

    @rule()
    def disarm(self):
        self.bench.vehicle.disarm(self.bench.now)
        self.bench.asked = False

    @rule(action=st.sampled_from([None, *LeftAlone]))
    def left_alone(self, action):
        self.bench.vehicle.left_alone(action, self.bench.now)
        self.bench.mode_at = math.inf if action is not None else self.bench.mode_at

    @rule(ahead=st.sampled_from([0.3, -9.0]), turn=st.sampled_from([0.0, math.nan, 1e300]))
    def move(self, ahead, turn):
        self.bench.velocity(ahead=ahead, turn=turn)

    @rule()
    def release(self):
        if self.bench.vehicle.phase is AutopilotPhase.DRIVING:
            self.bench.neutral = True
        self.bench.velocity()

    @rule()
    def push(self):
        self.release()
        self.move(0.3, 0.0)
        self.wait(0.1)

    @rule(mode=st.sampled_from([2, 15, 16]) | st.integers(0, 21), armed=st.booleans())
    def another_station(self, mode, armed):
        self.bench.mode, self.bench.armed = mode, armed
        self.wait(0.1)

    @rule(status=st.sampled_from([0, 1, 2, 3, 4, 5, 6]))
    def status(self, status):
        self.bench.status = status

    @rule(armed=st.booleans())
    def boot(self, armed):
        self.bench.boot()
        self.bench.armed = armed

    @rule(mute=st.booleans(), deaf=st.booleans(), bare=st.booleans(), position=st.booleans())
    def silence(self, mute, deaf, bare, position):
        self.bench.mute, self.bench.deaf, self.bench.bare = mute, deaf, bare
        self.bench.position = position

    @rule(command=st.sampled_from([SET_MODE, ARM]), result=st.integers(0, 6))
    def refuse(self, command, result):
        for first in (1.0, 0.0):
            for second in range(22):
                self.bench.refused[command, first, float(second)] = result
        self.bench.forgets = result

    @rule(
        name=st.sampled_from(sorted(READ)),
        payload=st.binary(min_size=1, max_size=255),
        system=st.sampled_from([0, 1, 1, 2, 255]),
        component=st.sampled_from([1, 1, 154, 190, 191]),
    )
    def any_frame(self, name, payload, system, component):
        self.bench.hear(
            MavlinkFrame(
                name=name,
                system=system,
                component=component,
                sequence=0,
                signed=False,
                fields=BY_NAME[name].values(payload),
                raw=payload,
            )
        )
        self.bench.look()

    @invariant()
    def words_and_memory_are_bounded(self):
        if not hasattr(self, "bench"):
            return
        vehicle = self.bench.vehicle
        assert len(why(vehicle, self.bench.now)) <= 1000
        assert all(len(text) <= 1000 for text in warnings(vehicle, self.bench.now))
        assert len(vehicle.identity.others) <= 64
        assert len(vehicle.telemetry.named) <= 64
        assert len(vehicle.texts.since(-math.inf)) <= 50
        assert len(vehicle.parameters.values) <= 64


TestAnyOrder = AnyOrder.TestCase
TestAnyOrder.settings = settings(
    max_examples=60,
    stateful_step_count=40,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)

NUMBERS = st.floats(allow_nan=False, width=32, min_value=-1e9, max_value=1e9)
SPEEDS = st.floats(-3.0, 3.0)


@pytest.mark.parametrize(
    "profile", [each for _, each in PROFILES], ids=lambda each: f"{each.autopilot} {each.name}"
)
@given(st.data(), SPEEDS, SPEEDS, SPEEDS, SPEEDS, st.floats(0.0, 1.0) | st.just(math.nan))
@settings(max_examples=100, deadline=None)
def test_a_setpoint_of_any_parameters_can_be_packed(profile, data, ahead, left, up, turn, gain):
    bench = ScriptedAutopilot()
    parameters = {
        name: data.draw(NUMBERS) for name in data.draw(st.sets(st.sampled_from(profile.parameters)))
    }
    wanted = Setpoint(ahead=ahead, left=left, up=up, turn=turn)
    for name, fields in profile.setpoint(wanted, parameters, gain):
        bench.tell(name, **fields)
        if name == "MANUAL_CONTROL" and profile.name == "sub":
            assert fields["x"] * ahead >= 0
            assert fields["y"] * left <= 0
            assert (fields["z"] - 500) * up >= 0
            assert fields["r"] * turn <= 0
    zero, cut = profile.stops(parameters, abs(ahead), receiver=bool(up > 0))
    assert zero >= 0.0 or math.isnan(zero)
    assert cut != -math.inf
