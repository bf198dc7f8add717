"""Gamepads of the kernel's input layer, written as HID."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.hid.device_controls import DeviceDecoder, hat_direction
from rune_tui.controls.hid.kernel_codes import EV_ABS, EV_KEY, KernelPad
from rune_tui.layout.spec import ControlKind
from tests.support.fake_evdev import AXES, BUTTONS

ENDS = st.tuples(st.integers(-(2**31), 2**31 - 2), st.integers(1, 2**31)).map(
    lambda pair: (pair[0], min(2**31 - 1, pair[0] + pair[1]))
)
PADS = st.builds(
    KernelPad.of,
    st.dictionaries(st.integers(0, 0x3F), ENDS).map(
        lambda axes: {0: (-128, 127), 1: (0, 255)} | axes
    ),
    st.frozensets(st.integers(0x100, 0x2FF), max_size=40).map(lambda keys: keys | {0x130}),
)


def decoder(pad: KernelPad) -> DeviceDecoder:
    return DeviceDecoder(pad.descriptor, vid=0x045E, pid=0x028E)


def test_an_xbox_pad_has_the_roles_of_any_gamepad() -> None:
    pad = KernelPad.of(AXES, frozenset(BUTTONS))
    assert pad is not None
    roles = {control.role for control in decoder(pad).controls}
    sticks = {"leftx", "lefty", "rightx", "righty", "lefttrigger", "righttrigger", "dpad"}
    buttons = {"a", "b", "x", "y", "leftshoulder", "rightshoulder", "back", "start", "guide"}
    assert roles == sticks | buttons | {"leftstick", "rightstick"}


@given(PADS, st.data())
def test_a_report_tells_all_that_the_kernel_told(pad: KernelPad, data: st.DataObject) -> None:
    axes = {(EV_ABS, code): data.draw(st.integers(*ends)) for code, ends in pad.axes.items()}
    keys = {(EV_KEY, code): data.draw(st.integers(0, 2)) for code in pad.buttons}
    right, down = data.draw(st.tuples(st.integers(-1, 1), st.integers(-1, 1)))
    state = {**axes, **keys, (EV_ABS, 0x10): right, (EV_ABS, 0x11): down}
    made = decoder(pad)
    values = dict(made.decode(pad.report(state)))
    assert len(values) == len(made.controls)
    raws = {
        kind: [values[at] for at, control in enumerate(made.controls) if control.kind is kind]
        for kind in ControlKind
    }
    assert raws[ControlKind.AXIS] == list(axes.values())
    assert raws[ControlKind.BUTTON] == [int(value > 0) for value in keys.values()]
    if pad.hat:
        (hat,) = [control for control in made.controls if control.kind is ControlKind.HAT]
        assert hat_direction(raws[ControlKind.HAT][0], hat) == (right, -down)


@given(st.dictionaries(st.integers(0, 0x3F), ENDS), st.frozensets(st.integers(0, 0x2FF)))
def test_what_is_no_joystick_is_none(
    axes: dict[int, tuple[int, int]], keys: frozenset[int]
) -> None:
    pad = KernelPad.of(axes, keys)
    is_joystick = {0, 1} <= axes.keys() and any(0x120 <= key < 0x140 for key in keys)
    assert (pad is not None) == is_joystick
