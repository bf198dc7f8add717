"""Which control of a real device is which: by usage, by profile, by a line of SDL's database."""

from __future__ import annotations

import pytest

from rune_tui.controls.hid.device_controls import DeviceDecoder
from rune_tui.controls.hid.sdl import roles_from_sdl
from rune_tui.layout.spec import ControlKind
from tests.console.controls.hid import writing as w
from tests.console.controls.hid.fixtures import NAMES, device
from tests.console.controls.hid.writing import RELATIVE, VARIABLE, application, axis, item
from tests.support.cases import for_each

AXIS_ROLES = {
    "3dconnexion_spacenavigator": "leftx=x lefty=y twist=rz",
    "8bitdo_sn30pro_plus_dinput": (
        "leftx=x lefty=y rightx=z righty=rz righttrigger=accelerator lefttrigger=brake"
    ),
    "dragonrise_0079_0011": "leftx=x#4 lefty=y",
    "google_stadia_ble": (
        "leftx=x lefty=y rightx=z righty=rz lefttrigger=brake righttrigger=accelerator"
    ),
    "ion_icade_bt": "",
    "logitech_f310_dinput": "leftx=x lefty=y rightx=z righty=rz",
    "nintendo_switch_pro_usb": "leftx=x lefty=y rightx=z righty=rz",
    "saitek_x52": "leftx=x lefty=y twist=rz throttle=z",
    "sony_buzz": "leftx=x lefty=y",
    "sony_dualsense_bt": "leftx=x lefty=y rightx=z righty=rz lefttrigger=rx righttrigger=ry",
    "sony_dualsense_usb": "leftx=x lefty=y rightx=z righty=rz lefttrigger=rx righttrigger=ry",
    "sony_dualshock4_v2_usb": "leftx=x lefty=y rightx=z righty=rz lefttrigger=rx righttrigger=ry",
    "thrustmaster_t16000m": "leftx=x lefty=y twist=rz throttle=slider",
    "xbox_elite2_1797_bt": (
        "leftx=x lefty=y rightx=z righty=rz lefttrigger=brake righttrigger=accelerator"
    ),
    "xbox_series_1914_ble": (
        "leftx=x lefty=y rightx=z righty=rz lefttrigger=brake righttrigger=accelerator"
    ),
}
_STICK = "dpdown:h0.4,dpleft:h0.8,dpright:h0.2,dpup:h0.1,leftx:a0,lefty:a1"
SDL = f"""\
# what is no line is skipped
050000004c050000e60c000000010000,elsewhere,a:b7,platform:Mac OS X,
05000000d11800000094000000010000,Stadia,a:b0,b:b1,back:b6,{_STICK},guide:b8,leftshoulder:b4,leftstick:b9,lefttrigger:a5,rightshoulder:b5,rightstick:b10,righttrigger:a4,rightx:a2,righty:a3,start:b7,x:b2,y:b3,platform:Linux,
03000000c82d00000260000011010000,8BitDo,a:b1,b:b0,back:b10,{_STICK},guide:b2,leftshoulder:b6,leftstick:b13,lefttrigger:a5,rightshoulder:b7,rightstick:b14,righttrigger:a4,rightx:a2,righty:a3,start:b11,x:b4,y:b3,platform:Linux,
030000006d04000016c2000010010000,F310,a:b1,b:b2,back:b8,{_STICK},leftshoulder:b4,leftstick:b10,lefttrigger:b6,rightshoulder:b5,rightstick:b11,righttrigger:b7,rightx:a2,righty:a3,start:b9,x:b0,y:b3,platform:Linux,
050000004c050000e60c000000810000,by hid-sony,a:b0,b:b1,x:b3,y:b2,platform:Linux,
050000004c050000e60c000000010000,DualSense,a:b1,b:b2,back:b8,{_STICK},guide:b12,leftshoulder:b4,leftstick:b10,lefttrigger:a3,misc1:b13,rightshoulder:b5,rightstick:b11,righttrigger:a4,rightx:a2,righty:a5,start:b9,x:b0,y:b3,platform:Linux,
050000005e040000130b000009050000,Series,a:b0,b:b1,back:b10,{_STICK},guide:b12,leftshoulder:b6,leftstick:b13,lefttrigger:a5,rightshoulder:b7,rightstick:b14,righttrigger:a4,rightx:a2,righty:a3,start:b11,x:b3,y:b4,platform:Linux,
""".splitlines()
"""Written after the database's lines for these devices."""
IN_SDL = [
    "google_stadia_ble",
    "8bitdo_sn30pro_plus_dinput",
    "logitech_f310_dinput",
    "sony_dualsense_bt",
    "xbox_series_1914_ble",
]


def decoder(*parts: bytes, usage: int = 4) -> DeviceDecoder:
    return DeviceDecoder(application(*parts, usage=usage), vid=0, pid=0)


def roles(of: DeviceDecoder) -> dict[str, str]:
    return {each.role: each.usage for each in of.controls if each.role}


@for_each("name", NAMES)
def test_axes_of_real_devices_have_their_roles(name: str) -> None:
    found = {
        each.role: each.usage
        for each in device(name).decoder().controls
        if each.role and each.kind is ControlKind.AXIS
    }
    assert found == dict(pair.split("=") for pair in AXIS_ROLES[name].split())


@for_each("name", NAMES)
def test_no_role_is_given_twice_and_indices_count_within_a_kind(name: str) -> None:
    controls = device(name).decoder().controls
    given = [each.role for each in controls if each.role]
    assert len(given) == len(set(given))
    for kind in ControlKind:
        own = [each.index for each in controls if each.kind is kind]
        assert own == list(range(len(own)))


@for_each("name", NAMES)
def test_what_grows_towards_the_operator_is_flipped(name: str) -> None:
    decoder = device(name).decoder()
    flipped = {each.role for each in decoder.controls if each.flipped and each.role}
    assert flipped == {"lefty", "righty", "throttle"} & roles(decoder).keys()


@for_each("name", IN_SDL)
def test_profiles_and_guesses_agree_with_the_database(name: str) -> None:
    each = device(name)
    own = each.decoder().controls
    unnamed = DeviceDecoder(each.descriptor, vid=0, pid=0).controls
    assert roles_from_sdl(SDL, unnamed, each.vid, each.pid, each.bus).controls == own


def test_buttons_without_a_name_have_their_number() -> None:
    x52 = device("saitek_x52").decoder()
    assert roles(x52)["button32"] == "button 32"
    assert "button33" not in roles(x52)


@pytest.mark.parametrize(
    ("usages", "wanted"),
    [
        ("x y z rz rx ry", "rightx=rx righty=ry lefttrigger=z righttrigger=rz"),
        ("x y rx ry", "rightx=rx righty=ry"),
        ("x y z rz", "rightx=z righty=rz"),
    ],
)
def test_right_stick_is_what_is_as_fine_as_the_left_one(usages: str, wanted: str) -> None:
    numbers = dict(zip(("x", "y", "z", "rx", "ry", "rz"), range(0x30, 0x36), strict=True))
    coarse = {"z", "rz"} if "rx" in usages else set()
    parts = [
        axis(numbers[name]) if name in coarse else axis(numbers[name], size=16, maximum=65535)
        for name in usages.split()
    ]
    expected = {"leftx": "x", "lefty": "y"} | dict(pair.split("=") for pair in wanted.split())
    assert roles(decoder(*parts, usage=5)) == expected


@for_each(
    ("usages", "wanted"),
    [
        ((0x30, 0x31, 0x35, 0x36), {"twist": "rz", "throttle": "slider"}),
        ((0x30, 0x31, 0x32), {"throttle": "z"}),
        ((0x30, 0x31, 0x35), {"twist": "rz"}),
        ((0x30, 0x31, 0x32, 0x35, 0x36), {"twist": "rz", "throttle": "z"}),
    ],
)
def test_flight_sticks_have_twist_and_throttle(
    usages: tuple[int, ...], wanted: dict[str, str]
) -> None:
    expected = {"leftx": "x", "lefty": "y"} | wanted
    assert roles(decoder(*map(axis, usages))) == expected


def test_pedals_and_wheel_of_a_car_are_triggers_and_stick() -> None:
    parts = [axis(usage, page=2) for usage in (0xC8, 0xC4, 0xC5)]
    assert roles(decoder(*parts)) == {
        "leftx": "steering",
        "righttrigger": "accelerator",
        "lefttrigger": "brake",
    }


def test_trigger_that_is_an_axis_and_a_button_is_the_axis() -> None:
    buttons = item(0x04, 9) + item(0x24, 1) + item(0x74, 1) + item(0x94, 8)
    buttons += item(0x18, 1) + item(0x28, 8) + item(0x80, VARIABLE)
    inner = application(buttons, axis(0xC4, page=2))
    pad = DeviceDecoder(inner, vid=0x046D, pid=0xC216)
    assert roles(pad)["righttrigger"] == "accelerator"
    assert roles(pad)["lefttrigger"] == "button 7"
    assert roles(pad)["button8"] == "button 8"


def test_profile_knows_which_of_two_axes_is_meant() -> None:
    inner = application(*map(axis, (0x30, 0x31, 0x32, 0x32, 0x35)))
    pad = DeviceDecoder(inner, vid=0x0079, pid=0x0006)
    assert roles(pad) == {"leftx": "x", "lefty": "y", "rightx": "z#2", "righty": "rz"}


def test_some_xbox_pads_have_view_and_guide_beside_the_numbered_buttons() -> None:
    elite = device("xbox_elite2_1797_bt")
    assert roles(elite.decoder())["back"] == "back"
    assert roles(elite.decoder())["guide"] == "button 13"
    numbered = [w.axis(number, page=9, size=1, maximum=1) for number in range(1, 16)]
    keys = [w.axis(usage, page=12, size=1, maximum=1) for usage in (0x224, 0x223)]
    inner = application(*numbered, *keys, usage=5)
    found = roles(DeviceDecoder(inner, vid=0x045E, pid=0x02FD))
    assert (found["back"], found["guide"], found["button11"]) == ("back", "home", "button 11")


def test_balls_have_no_role() -> None:
    assert roles(decoder(axis(0x30, flags=VARIABLE | RELATIVE))) == {}


def test_database_may_turn_an_axis_round_and_place_the_hat() -> None:
    buttons = item(0x04, 9) + item(0x24, 1) + item(0x74, 1) + item(0x94, 8)
    buttons += item(0x18, 1) + item(0x28, 8) + item(0x80, VARIABLE)
    pad = decoder(axis(0x30), axis(0x31), axis(0x36), axis(0x36), axis(0x39, maximum=7), buttons)
    line = "03000000341200007856000000010000,pad,lefttrigger:a3~,lefty:a0~,leftx:a1,"
    line += "righttrigger:+a2,a:b7,dpup:h0.1,rightx:a9,paddle1:b2,platform:Linux"
    changed = roles_from_sdl([line], pad.controls, 0x1234, 0x5678, 3).controls
    assert [(each.usage, each.role, each.flipped) for each in changed[:5]] == [
        ("x", "lefty", False),
        ("y", "leftx", False),
        ("slider", "", False),
        ("slider#2", "lefttrigger", True),
        ("hat switch", "dpad", False),
    ]
    assert [each.role for each in changed[5:]] == [*(f"button{n}" for n in range(1, 8)), "a"]


def test_without_a_line_for_it_a_device_keeps_its_roles() -> None:
    each = device("saitek_x52")
    controls = each.decoder().controls
    assert roles_from_sdl(SDL, controls, each.vid, each.pid, each.bus).controls == controls


def padded(*parts: str, name: str = "", guid: str = "") -> tuple[dict[str, str], tuple[str, ...]]:
    """Usages by role that a line gives a plain pad, and the roles that it cannot give."""
    buttons = item(0x04, 9) + item(0x24, 1) + item(0x74, 1) + item(0x94, 8)
    buttons += item(0x18, 1) + item(0x28, 8) + item(0x80, VARIABLE)
    axes = [axis(usage) for usage in (0x30, 0x31, 0x32, 0x35)]
    pad = decoder(*axes, axis(0x39, maximum=7), buttons, usage=5)
    numbers = (0, 0) if name else (0x1234, 0x5678)
    guid = guid or "03000000341200007856000000010000"
    line = ",".join((guid, "pad", *parts, "platform:Linux", ""))
    found = roles_from_sdl([line], pad.controls, *numbers, 3, name)
    roles_found = {each.role: each.usage for each in found.controls}
    named = {role: usage for role, usage in roles_found.items() if role and "button" not in role}
    return named, found.left_out


def test_every_form_of_a_line_gives_its_roles_or_keeps_the_guess_and_says_so() -> None:
    sticks = {"leftx": "x", "lefty": "y"}
    full = ("leftx:a0", "lefty:a1")
    assert padded(*full) == (sticks, ())
    assert padded("+leftx:+a1", "-leftx:-a1", "lefty:a0") == ({"leftx": "y", "lefty": "x"}, ())
    assert padded(*full, "dpup:h0.1", "dpleft:h0.8") == (sticks | {"dpad": "hat switch"}, ())
    assert padded(*full, "dpup:b0", "righttrigger:b1")[1] == ()
    odd = padded(*full, "dpup:-a1", "dpdown:+a1", "lefttrigger:+a2", "righttrigger:-a2")
    hat = {"dpad": "hat switch"}
    assert odd == (sticks | hat, ("dpup", "dpdown", "lefttrigger", "righttrigger"))
    guessed = {"rightx": "z", "righty": "rz"}
    assert padded(*full, "rightx:h0.2", "righty:b3") == (sticks | guessed, ("rightx", "righty"))
    assert padded("dpup:h0.2") == (sticks | {"dpad": "hat switch"}, ("dpup",))
    assert padded("dpup:-a1", "dpdown:+a1", "a:b0")[0] == {**sticks, **hat, "a": "button 1"}
    assert padded("a:b0", "x:b0")[1] == ("x",)
    assert padded(*full, "misc1:b2", "paddle1:b3", "crc:d0c3", "type:ps5") == (sticks, ())
    assert padded("leftx:a1", "hint:!SDL_GAMECONTROLLER_USE_BUTTON_LABELS:=1")[1] == ()


def test_a_device_without_numbers_has_its_line_by_the_name() -> None:
    name = "PLAYSTATION(R)3 Controller"
    guid = "0300abcd" + name[:11].encode().hex() + "00"
    swapped = ("leftx:a1", "lefty:a0")
    assert padded(*swapped, name=name, guid=guid)[0] == {"leftx": "y", "lefty": "x"}
    assert padded(*swapped, name="Other", guid=guid)[0]["leftx"] == "x"
    upper = "\ufeff03000000341200007856000000010000".upper()
    assert padded(*swapped, guid=upper)[0]["leftx"] == "y"
