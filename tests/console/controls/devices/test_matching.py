from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.devices.matching import assigned, is_meant
from rune_tui.controls.devices.udev_rules import udev_rule, udev_rules
from tests.console.controls.joystick.pads import device, joystick
from tests.support.cases import for_each


@for_each(
    ("wanted", "fits"),
    [
        ({}, True),
        ({"vid": 0x046D}, True),
        ({"vid": 0x046D, "pid": 0xC216}, True),
        ({"vid": 0x046D, "pid": 0xC215}, False),
        ({"vid": 0x054C}, False),
        ({"serial": "7"}, True),
        ({"serial": "8"}, False),
        ({"device": "logitech*"}, True),
        ({"device": "*Pad"}, True),
        ({"device": "Sony*"}, False),
    ],
)
def test_a_layout_names_a_device_by_its_numbers_or_its_name(
    wanted: dict[str, Any], *, fits: bool
) -> None:
    plugged = device(serial="7", name="Logitech Pad")
    assert is_meant(joystick(**wanted), plugged) == fits


def test_a_keyboard_is_only_meant_where_it_is_named() -> None:
    keyboard = device(joystick=False)
    assert not is_meant(joystick(), keyboard)
    assert is_meant(joystick(vid=0x046D), keyboard)


ONE, TWO = joystick(name="one"), joystick(name="two")


def test_two_of_a_kind_go_to_a_joystick_each() -> None:
    here = [device("a", port="1"), device("b", port="2")]
    found = assigned([ONE, TWO], here, {})
    assert (found["one"].path, found["two"].path) == ("a", "b")
    assert [*assigned([ONE, TWO], here[1:], {})] == ["one"]


def test_the_particular_joystick_gets_its_device_before_the_one_that_takes_any() -> None:
    here = [device("a", serial="7"), device("b")]
    found = assigned([ONE, joystick(name="two", serial="7")], here, {})
    assert (found["one"].path, found["two"].path) == ("b", "a")


@pytest.mark.parametrize("known_by", ["serial", "port"])
def test_twins_that_are_plugged_in_again_keep_their_joysticks(known_by: str) -> None:
    before = {"one": device("a", **{known_by: "A"}), "two": device("b", **{known_by: "B"})}
    again_b, again_a = device("c", **{known_by: "B"}), device("d", **{known_by: "A"})
    assert assigned([ONE, TWO], [again_b], before) == {"two": again_b}
    assert assigned([ONE, TWO], [again_b, again_a], before) == {"one": again_a, "two": again_b}


def test_a_joystick_whose_twin_stays_gets_the_one_that_comes_back_at_another_port() -> None:
    stays = device("a", port="1")
    back = device("c", port="9")
    before = {"one": device("b", port="2"), "two": stays}
    assert assigned([ONE, TWO], [stays, back], before) == {"one": back, "two": stays}


DEVICES = st.lists(
    st.builds(
        device,
        st.sampled_from("abcdef"),
        serial=st.sampled_from(["", "1", "2"]),
        port=st.sampled_from(["", "p", "q"]),
        joystick=st.booleans(),
    ),
    unique_by=lambda each: each.path,
)


@given(DEVICES, DEVICES)
def test_no_device_has_two_joysticks_and_none_is_idle_while_one_waits(
    first: Any, then: Any
) -> None:
    specs = [ONE, TWO, joystick(name="three", serial="1")]
    before = assigned(specs, first, {})
    found = assigned(specs, then, before)
    assert len({each.path for each in found.values()}) == len(found)
    left = [each for each in then if each not in found.values()]
    waiting = [spec for spec in specs if spec.name not in found]
    assert not any(is_meant(spec, each) for spec in waiting for each in left)
    kept = {name: each for name, each in before.items() if each in then}
    assert kept.items() <= found.items()


def test_the_rule_for_a_device_names_it_as_the_kernel_does() -> None:
    rule = udev_rule(device(vid=0x054C, pid=0x0CE6))
    assert 'KERNELS=="*:054C:0CE6.*"' in rule
    assert 'TAG+="uaccess"' in rule
    twins = udev_rules([device("a"), device("b")])
    assert twins.count("KERNEL==") == 1


def test_of_several_the_one_at_this_machine_comes_first_and_machines_are_not_mixed_up() -> None:
    near, far = device("b", port="2"), device("a", port="1", machine="desk")
    assert assigned([ONE], [far, near], {})["one"] == near
    assert assigned([ONE], [far], {"one": near}) == {}
    assert assigned([ONE], [near], {"one": far}) == {}
    again = device("c", port="1", machine="desk")
    assert assigned([ONE], [near, again], {"one": far})["one"] == again


def test_a_copy_that_a_program_made_comes_after_the_real_pad() -> None:
    copy = device("/dev/input/event3", virtual=True)
    no_port = device("/dev/input/event4")
    real = device("/dev/input/event9", port="usb-1")
    spec = joystick()
    assert assigned([spec], [copy, no_port, real], {}) == {"pad": real}
    assert assigned([spec], [copy, no_port], {}) == {"pad": no_port}
    assert assigned([spec], [copy], {}) == {"pad": copy}
    assert assigned([spec], [copy, real], {"pad": copy}) == {"pad": copy}, "it keeps what it has"
