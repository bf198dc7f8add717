"""A Sub's lights by buttons, and its camera."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.profiles.ardusub import BUTTON_FUNCTIONS
from hub.robots.mavlink.vehicle.button_lights import ButtonLight
from tests.support.mavlink_numbers import SUB
from tests.support.scripted_autopilot import ScriptedAutopilot, moves

BRIGHTER, DIMMER, ARM_BUTTON = 32.0, 33.0, 3.0
LAYOUT = {"BTN0_FUNCTION": ARM_BUTTON, "BTN13_FUNCTION": DIMMER, "BTN14_FUNCTION": BRIGHTER}
TURN_CAMERA = 1000


class Lamp:
    """Lights that a joystick steps, reported twice a second."""

    def __init__(self, steps=8, level=0):
        self.steps, self.level = steps, level
        self.held = 0
        self.now = 0.0
        self.pressed = []
        self.lights = ButtonLight(BRIGHTER)

    def run(self, seconds):
        reported, report_at = self.level / self.steps, self.now
        for _ in range(round(seconds * 20)):
            self.now += 0.05
            if self.now >= report_at:
                reported, report_at = self.level / self.steps, self.now + 0.5
            parameters = LAYOUT | {"JS_LIGHTS_STEPS": float(self.steps)}
            bits = self.lights.buttons(parameters, reported, self.now)
            self.pressed.append(bits)
            new = bits & ~self.held
            self.held = bits
            self.level += (new >> 14 & 1) - (new >> 13 & 1)
            self.level = max(0, min(self.steps, self.level))


@pytest.mark.parametrize(("before", "wanted"), [(0, 1.0), (8, 0.0), (3, 0.5), (4, 0.5)])
def test_lights_reach_a_brightness_by_single_presses(before, wanted):
    lamp = Lamp(level=before)
    lamp.lights.set(wanted, lamp.now)
    lamp.run(8.0)
    assert lamp.level == wanted * 8
    presses = sum(bits != 0 for bits in lamp.pressed)
    assert presses == abs(wanted * 8 - before)
    assert not any(
        one and other for one, other in zip(lamp.pressed, lamp.pressed[1:], strict=False)
    )
    assert {*lamp.pressed} <= {0, 1 << 13, 1 << 14}


def test_a_press_that_was_lost_is_made_up_for():
    lamp = Lamp()
    lamp.lights.set(0.5, lamp.now)
    lamp.run(0.2)
    lamp.level = 0
    lamp.run(6.0)
    assert lamp.level == 4


def test_an_order_ends_after_ten_seconds_and_never_without_a_report():
    lamp = Lamp()
    lamp.lights.set(0.5, lamp.now)
    assert lamp.lights.buttons(LAYOUT, math.nan, 1.0) == 0
    assert lamp.lights.buttons(LAYOUT, 0.0, 10.1) == 0


@given(st.dictionaries(st.sampled_from(BUTTON_FUNCTIONS), st.floats(-100, 100)), st.floats(0, 1))
def test_no_button_of_another_function_is_pressed(layout, wanted):
    lights = ButtonLight(BRIGHTER)
    lights.set(wanted, 0.0)
    for frame in range(30):
        bits = lights.buttons(layout, 0.5, frame * 0.1)
        pressed = {layout[name] for at, name in enumerate(BUTTON_FUNCTIONS) if bits >> at & 1}
        assert pressed <= {BRIGHTER, DIMMER}


def lit(**parameters):
    """A Sub whose lights and buttons are known."""
    bench = ScriptedAutopilot(SUB)
    bench.parameters |= LAYOUT | parameters
    bench.until(lambda: LAYOUT.keys() <= bench.vehicle.parameters.values.keys())
    bench.tell("NAMED_VALUE_FLOAT", name="Lights1", value=0.25)
    return bench


def test_buttons_go_with_the_sticks_and_the_state_comes_back():
    bench = lit()
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.DISARMED)
    assert bench.vehicle.telemetry.brightness(1) == 0.25
    since = bench.now
    bench.vehicle.lights.set(1, 0.5, bench.now)
    bench.run(1.0)
    pressed = [frame["buttons"] for at, frame in bench.sent if "buttons" in frame.fields]
    assert pressed.count(1 << 14) == 2
    assert not any(bench.moving(since))


def test_both_lights_are_stepped_by_buttons_of_their_own_at_the_same_time():
    second = {"BTN1_FUNCTION": 35.0, "BTN2_FUNCTION": 36.0}
    bench = lit(**second)
    bench.until(lambda: second.keys() <= bench.vehicle.parameters.values.keys())
    bench.tell("NAMED_VALUE_FLOAT", name="Lights2", value=0.5)
    assert bench.vehicle.telemetry.brightness(2) == 0.5
    since = bench.now
    bench.vehicle.lights.set(1, 0.5, bench.now)
    bench.vehicle.lights.set(2, 0.25, bench.now)
    bench.run(1.0)
    pressed = [frame["buttons"] for at, frame in bench.sent if "buttons" in frame.fields]
    assert pressed.count(1 << 14 | 1 << 2) == 2
    assert sum(map(bool, pressed)) == 2
    assert not any(bench.moving(since))


def test_the_camera_turns_at_a_rate_within_its_limits_and_stops():
    bench = ScriptedAutopilot(SUB).driving()
    half = math.radians(30.0)
    quaternion = (math.cos(half / 2), 0.0, math.sin(half / 2), 0.0)
    bench.tell("GIMBAL_DEVICE_ATTITUDE_STATUS", q=quaternion)
    assert bench.vehicle.telemetry.tilt == pytest.approx(half)
    since = bench.now
    bench.vehicle.tilt.turn(-0.5, -math.radians(45.0), math.radians(45.0), bench.now)
    bench.run(1.0)
    angles = [parameters[0] for parameters in bench.commands(TURN_CAMERA, since)]
    assert 8 <= len(angles) <= 12
    assert angles[-1] == pytest.approx(30.0 - math.degrees(0.5), abs=3.0)
    bench.run(5.0)
    assert bench.commands(TURN_CAMERA)[-1][0] == pytest.approx(-45.0)
    bench.vehicle.tilt.turn(0.0, -1.0, 1.0, bench.now)
    stopped = bench.now + 0.001
    bench.run(1.0)
    assert bench.commands(TURN_CAMERA, stopped) == []
    assert not any(moves(frame) for _, frame in bench.sent)


def test_the_camera_of_another_pilot_is_not_turned():
    bench = ScriptedAutopilot(SUB).driving()
    bench.mode = 19
    bench.until(lambda: bench.vehicle.phase is AutopilotPhase.ELSEWHERE)
    bench.vehicle.tilt.turn(0.5, -1.0, 1.0, bench.now)
    bench.run(1.0)
    assert bench.commands(TURN_CAMERA) == []
