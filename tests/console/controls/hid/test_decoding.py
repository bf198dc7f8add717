"""Reports to values: what each kind of field, each odd device and each bad report gives."""

from __future__ import annotations

import pytest

from rune_tui.controls.hid.channels import MAX_CONTROLS, MAX_ELEMENTS
from rune_tui.controls.hid.device_controls import DeviceDecoder
from rune_tui.errors import DescriptorError
from rune_tui.layout.spec import ControlKind
from tests.console.controls.hid import writing as w
from tests.console.controls.hid.fixtures import NAMES, by_role, by_usage, control, device
from tests.console.controls.hid.writing import application, axis, item, padding
from tests.support.cases import for_each


def decoder(*parts: bytes, usage: int = 4) -> DeviceDecoder:
    return DeviceDecoder(application(*parts, usage=usage), vid=0, pid=0)


def array(first: int, last: int, *, size: int = 8, count: int = 2, minimum: int = 1) -> bytes:
    """Elements that name pressed buttons."""
    inner = item(w.PAGE, 9) + w.signed_item(w.MINIMUM, minimum)
    inner += w.signed_item(w.MAXIMUM, minimum + last - first) + item(w.SIZE, size)
    inner += item(w.COUNT, count) + item(w.USAGE_MINIMUM, first) + item(w.USAGE_MAXIMUM, last)
    return inner + item(w.INPUT, 0)


def test_fields_need_not_begin_at_bytes() -> None:
    device = decoder(
        axis(0x30, size=10, maximum=1023), axis(0x31, size=11, minimum=-1024, maximum=1023)
    )
    assert dict(device.decode(w.report([(1000, 10), (-700, 11)]))) == {0: 1000, 1: -700}


@for_each("size", [1, 2, 7, 8, 12, 16, 24, 31, 32])
def test_values_of_every_size_come_back(size: int) -> None:
    device = decoder(padding(3), axis(size=size, maximum=2**size - 1))
    for value in (0, 1, 2 ** (size - 1), 2**size - 1):
        assert device.decode(w.report([(0, 3), (value, size)])) == ((0, value),)
    if size > 1:
        half = 1 << (size - 1)
        device = decoder(padding(3), axis(size=size, minimum=-half, maximum=half - 1))
        for value in (-half, -1, 0, half - 1):
            assert device.decode(w.report([(0, 3), (value, size)])) == ((0, value),)


def test_longer_fields_are_no_controls() -> None:
    assert decoder(axis(0x30, size=33), axis(0x31)).controls[0].usage == "y"


def test_padding_and_vendor_fields_are_no_controls() -> None:
    device = decoder(padding(8), axis(1, page=0xFF00), axis(0x31))
    assert device.decode(b"\x01\x02\x03") == ((0, 3),)


@for_each(("least", "most"), [(0, 7), (1, 8), (0, 3), (-4, 3)])
def test_hat_has_a_value_only_within_its_range(least: int, most: int) -> None:
    for flags in (w.VARIABLE, w.VARIABLE | w.NULL):
        device = decoder(axis(0x39, size=5, minimum=least, maximum=most, flags=flags))
        assert device.decode(w.report([(least, 5)])) == ((0, least),)
        assert device.decode(w.report([(most, 5)])) == ((0, most),)
        assert device.decode(w.report([(most + 1, 5)])) == ((0, None),)


def test_axis_has_no_value_out_of_range_only_if_it_says_so() -> None:
    flags = w.VARIABLE | w.NULL
    assert decoder(axis(maximum=200, flags=flags)).decode(b"\xc9") == ((0, None),)
    assert decoder(axis(maximum=200, flags=flags)).decode(b"\xc8") == ((0, 200),)
    assert decoder(axis(maximum=200)).decode(b"\xc9") == ((0, 201),)


def test_empty_range_means_all_that_fits() -> None:
    device = decoder(axis(0x30, minimum=0, maximum=0), axis(0x31, size=4, minimum=-1, maximum=-1))
    assert [(each.minimum, each.maximum) for each in device.controls] == [(0, 255), (-8, 7)]


def test_arrays_name_the_buttons_that_are_down() -> None:
    device = decoder(array(1, 4))
    assert [each.usage for each in device.controls] == [f"button {n}" for n in range(1, 5)]
    assert [value for _, value in device.decode(b"\x00\x00")] == [0, 0, 0, 0]
    assert [value for _, value in device.decode(b"\x03\x01")] == [1, 0, 1, 0]
    assert [value for _, value in device.decode(b"\x02\x02")] == [0, 1, 0, 0]
    assert [value for _, value in device.decode(b"\x63\x04")] == [0, 0, 0, 1]


def test_values_of_arrays_may_be_negative() -> None:
    device = decoder(array(1, 3, size=4, minimum=-1))
    assert [value for _, value in device.decode(w.report([(-1, 4), (1, 4)]))] == [1, 0, 1]


def test_relative_axes_are_balls() -> None:
    flags = w.VARIABLE | w.RELATIVE
    device = decoder(axis(0x38, minimum=-127, maximum=127, flags=flags), axis(0x30), axis(0x31))
    assert [each.kind for each in device.controls] == [
        ControlKind.BALL,
        ControlKind.AXIS,
        ControlKind.AXIS,
    ]
    assert [each.index for each in device.controls] == [0, 0, 1]
    assert dict(device.decode(b"\xfe\x00\x00"))[0] == -2


def test_second_of_the_same_usage_has_a_number() -> None:
    device = decoder(axis(0x30), axis(0x36), axis(0x36), axis(0x36))
    assert [each.usage for each in device.controls] == ["x", "slider", "slider#2", "slider#3"]


def test_two_joysticks_of_one_device_are_told_apart() -> None:
    both = application(item(w.REPORT_ID, 1), axis(0x30)) + application(
        item(w.REPORT_ID, 2), axis(0x30)
    )
    device = DeviceDecoder(both, vid=0, pid=0)
    assert [each.usage for each in device.controls] == ["x", "x#2"]
    assert [each.role for each in device.controls] == ["leftx", ""]
    assert device.decode(b"\x01\x07") == ((0, 7),)
    assert device.decode(b"\x02\x09") == ((1, 9),)


@for_each(("page", "usage"), [(1, 2), (1, 6), (12, 1), (0xFF00, 1), (1, 1)])
def test_other_devices_are_no_joysticks(page: int, usage: int) -> None:
    other = application(axis(0x30), axis(0x31), usage=usage, page=page)
    device = DeviceDecoder(other, vid=0, pid=0)
    assert not device.joystick
    assert device.controls == ()
    assert device.decode(b"\x01\x02") == ()
    assert device.unread == 0


def test_keyboard_beside_a_joystick_is_left_out() -> None:
    both = application(item(w.REPORT_ID, 1), axis(0x30), usage=6)
    both += application(item(w.REPORT_ID, 2), axis(0x31))
    device = DeviceDecoder(both, vid=0, pid=0)
    assert [each.usage for each in device.controls] == ["y"]
    assert (device.decode(b"\x01\x05"), device.unread) == ((), 0)


def test_short_report_gives_what_it_holds() -> None:
    device = decoder(axis(0x30), axis(0x31, size=16, maximum=65535), axis(0x32), array(1, 2))
    whole = device.decode(bytes(range(1, 8)))
    assert len(whole) == 5
    assert device.decode(b"\x01\x02\x03\x04") == whole[:3]
    assert device.decode(b"\x01\x02") == whole[:1]
    assert device.unread == 0


def test_longer_report_is_read_as_far_as_it_is_known() -> None:
    device = decoder(axis(0x30), axis(0x31))
    assert device.decode(b"\x01\x02" + bytes(4096)) == device.decode(b"\x01\x02")


def test_report_that_makes_no_sense_is_counted() -> None:
    device = decoder(item(w.REPORT_ID, 7), axis(0x30, size=16))
    assert [device.decode(report) for report in (b"", b"\x08\x01\x02", b"\x07", b"\x07\x01")] == [
        ()
    ] * 4
    assert device.unread == 4
    assert device.decode(b"\x07\x01\x02") == ((0, 0x201),)
    assert device.unread == 4


def test_more_controls_than_any_device_has_are_refused() -> None:
    inner = item(w.PAGE, 9) + item(w.MAXIMUM, 1) + item(w.SIZE, 1) + item(w.COUNT, MAX_CONTROLS)
    inner += item(w.USAGE_MINIMUM, 1) + item(w.USAGE_MAXIMUM, 0xFFFF)
    assert len(decoder(inner, item(w.INPUT, w.VARIABLE)).controls) == MAX_CONTROLS
    with pytest.raises(DescriptorError, match="controls"):
        decoder(inner, item(w.INPUT, w.VARIABLE), axis(0x30))


@pytest.mark.parametrize("flags", [0, w.VARIABLE])
def test_more_elements_than_any_device_has_are_refused(flags: int) -> None:
    inner = item(w.PAGE, 1) + item(w.MAXIMUM, 1) + item(w.SIZE, 1)
    inner += item(w.COUNT, MAX_ELEMENTS + 1) + item(w.USAGE, 1) + item(w.INPUT, flags)
    with pytest.raises(DescriptorError, match="elements"):
        decoder(inner)


# Real devices.


@for_each("name", NAMES)
def test_every_recorded_report_is_read(name: str) -> None:
    each = device(name)
    decoder = each.decoder()
    assert decoder.joystick == (name != "ion_icade_bt")
    for report in each.reports:
        assert bool(decoder.decode(report)) == decoder.joystick or report[0] == 4, report.hex()
    assert decoder.unread == 0


def test_space_navigator_sends_deflections_though_it_says_changes() -> None:
    navigator = device("3dconnexion_spacenavigator").decoder()
    assert {each.kind for each in navigator.controls[:6]} == {ControlKind.AXIS}
    assert by_usage(navigator, bytes.fromhex("020000e2ff0000")) == {"rx": 0, "ry": -30, "rz": 0}
    assert by_usage(navigator, bytes.fromhex("030100")) == {"button 1": 1, "button 2": 0}
    assert [each.usage for each in navigator.controls if each.flipped] == ["y", "z"]


def test_dragonrise_names_its_hat_nothing_and_has_x_where_x_is_said_the_fourth_time() -> None:
    pad = device("dragonrise_0079_0011").decoder()
    assert control(pad, "hat switch").kind is ControlKind.HAT
    values = by_role(pad, bytes([127, 127, 127, 200, 50, 0x02, 0, 0, 0]))
    assert (values["leftx"], values["lefty"], values["dpad"]) == (200, 50, 2)


STATE = bytes((10, 20, 30, 40, 0x28, 0x21, 0x01, 50, 60))
"""Sticks, hat centred with cross, L1 with options, PS, triggers, as a DualShock 4 orders them."""
MEANT = {
    "leftx": 10,
    "lefty": 20,
    "rightx": 30,
    "righty": 40,
    "lefttrigger": 50,
    "righttrigger": 60,
    "dpad": None,
    "a": 1,
    "b": 0,
    "x": 0,
    "y": 0,
    "leftshoulder": 1,
    "start": 1,
    "back": 0,
    "guide": 1,
    "rightstick": 0,
}


def test_dualshock_4_says_over_bluetooth_what_it_says_over_usb() -> None:
    each = device("sony_dualshock4_v2_usb")
    wired = each.decoder()
    radio = DeviceDecoder(each.descriptor, vid=each.vid, pid=each.pid, bus=5)
    assert by_role(wired, b"\x01" + STATE + bytes(54)).items() >= MEANT.items()
    for report_id in range(0x11, 0x1A):
        report = bytes([report_id, 0xC0, 0x00]) + STATE + bytes(66)
        assert sorted(radio.decode(report)) == sorted(wired.decode(b"\x01" + STATE))
    assert (radio.unread, wired.unread) == (0, 0)


def test_dualshock_4_report_that_holds_sound_moves_nothing() -> None:
    each = device("sony_dualshock4_v2_usb")
    radio = DeviceDecoder(each.descriptor, vid=each.vid, pid=each.pid, bus=5)
    assert radio.decode(bytes([0x14, 0x40, 0xA0]) + STATE + bytes(66)) == ()
    assert radio.unread == 0


def test_dualsense_says_in_its_own_report_what_it_says_in_the_simple_one() -> None:
    radio = device("sony_dualsense_bt").decoder()
    state = STATE[:4] + STATE[7:] + b"\x99" + STATE[4:7] + b"\x00"
    simple = radio.decode(b"\x01" + STATE)
    assert sorted(radio.decode(b"\x31\x01" + state + bytes(66))) == sorted(simple)
    assert by_role(radio, b"\x31\x01" + state + bytes(66)).items() >= MEANT.items()
    wired = device("sony_dualsense_usb").decoder()
    assert by_role(wired, b"\x01" + state + bytes(53)).items() >= MEANT.items()


def switch_report(buttons: int = 0, *sticks: int) -> bytes:
    """Timer, battery, three bytes of buttons, four values of 12 bits."""
    parts = [(0x55, 8), (0x8E, 8), (buttons, 24)]
    return w.report([*parts, *((value, 12) for value in sticks)], 0x30) + bytes(50)


def test_switch_pro_sends_its_own_report_under_the_id_of_another() -> None:
    pad = device("nintendo_switch_pro_usb").decoder()
    values = by_role(pad, switch_report(1 << 2 | 1 << 22, 0, 4095, 4095, 2048))
    assert values["leftx"] == 0
    assert values["lefty"] == 0, "its sticks grow up"
    assert values["rightx"] == 4095 << 4
    assert values["righty"] == 2047 << 4
    assert [role for role, value in values.items() if value == 1] == ["a", "leftshoulder"]
    assert pad.unread == 0


SWITCH_BUTTONS = (
    dict(zip(("x", "y", "a", "b"), range(4), strict=True))
    | {"rightshoulder": 6, "righttrigger": 7, "leftshoulder": 22, "lefttrigger": 23}
    | {"back": 8, "start": 9, "rightstick": 10, "leftstick": 11, "guide": 12, "button14": 13}
)


@for_each("role", SWITCH_BUTTONS)
def test_switch_pro_has_every_button_where_its_driver_looks_for_it(role: str) -> None:
    pad = device("nintendo_switch_pro_usb").decoder()
    values = by_role(pad, switch_report(1 << SWITCH_BUTTONS[role], 0, 0, 0, 0))
    assert [role for role, value in values.items() if value == 1] == [role]


@for_each(
    ("bits", "hat"),
    [(0, None), (2, 0), (6, 1), (4, 2), (5, 3), (1, 4), (9, 5), (8, 6), (10, 7), (3, None)],
)
def test_switch_pro_has_a_button_for_each_direction(bits: int, hat: int | None) -> None:
    pad = device("nintendo_switch_pro_usb").decoder()
    assert by_role(pad, switch_report(bits << 16, 0, 0, 0, 0))["dpad"] == hat


def test_switch_pro_with_a_hat_of_other_directions_has_none_in_its_own_report() -> None:
    each = device("nintendo_switch_pro_usb")
    odd = each.descriptor.replace(b"\x15\x00\x25\x07", b"\x15\x00\x25\x01")
    pad = DeviceDecoder(odd, vid=each.vid, pid=each.pid)
    assert control(pad, "hat switch").maximum == 1
    assert "dpad" not in by_role(pad, switch_report(8 << 16, 0, 0, 0, 0))


def test_other_makers_reports_with_the_same_ids_are_not_taken_for_these() -> None:
    descriptor = device("sony_dualsense_bt").descriptor
    other = DeviceDecoder(descriptor, vid=0x1234, pid=0x0CE6, bus=5)
    assert other.decode(b"\x31" + bytes(77)) == ()
