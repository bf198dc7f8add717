"""`rune joytest` with virtual joysticks."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from rune_tui.controls.joystick.user_files import user_file
from tests.support import warm_start
from tests.support.fake_hid import VirtualBed, VirtualDevice, needs_virtual_devices
from tests.support.waiting import exit_code
from tests.system.harness import ConsoleProcess

pytestmark = needs_virtual_devices

_LAYOUT = """<rune>
  <robot name="magellan"/>
  <joystick name="pad">
    <control name="ahead" type="axis" role="lefty" invert="true" deadzone="0.2" expo="0.5"/>
  </joystick>
  <view xsize="9" ysize="9"/>
</rune>
"""
REST = bytes([128, 128, 128, 128, 8, 0, 0, 0])


@pytest.fixture
def pad(bed: VirtualBed) -> Iterator[VirtualDevice]:
    plugged = bed.plug("logitech_f310_dinput", serial="7")
    yield plugged
    plugged.unplug()


def joytest(bed: VirtualBed, *options: str) -> str:
    command = [sys.executable, "-m", "rune_tui", "joytest", *options]
    done = warm_start.run(command, environment=os.environ | bed.environment)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.usefixtures("pad")
def test_what_is_plugged_in_is_listed_with_its_controls(bed: VirtualBed) -> None:
    (device,) = json.loads(joytest(bed, "--list", "--json"))
    assert (device["vid"], device["pid"], device["serial"]) == ("046d", "c216", "7")
    assert device["trouble"] == ""
    stick = {"type": "axis", "index": 1, "usage": "y", "role": "lefty", "min": 0, "max": 255}
    assert stick in device["controls"]
    assert "12 of type button" in joytest(bed, "--list")
    assert 'KERNELS=="*:046D:C216.*"' in joytest(bed, "--udev")


@pytest.mark.usefixtures("pad")
def test_roles_are_those_of_the_users_own_file(bed: VirtualBed) -> None:
    path = user_file("gamecontrollerdb.txt")
    path.parent.mkdir(parents=True)
    path.write_text("030000006d04000016c2000010010000,mine,rightx:a1,platform:Linux\n")
    (device,) = json.loads(joytest(bed, "--list", "--json"))
    assert {each["usage"]: each["role"] for each in device["controls"]}["y"] == "rightx"


@pytest.mark.usefixtures("pad")
def test_a_file_of_roles_that_cannot_be_read_is_an_error_on_the_screen(bed: VirtualBed) -> None:
    user_file("gamecontrollerdb.txt").mkdir(parents=True)
    with closing(ConsoleProcess(["joytest"], environment=bed.environment, columns=200)) as shown:
        shown.wait(lambda: "it is no regular file" in shown.text, 20.0, "no error is shown")
        assert "reports a second" in shown.text
        shown.type("\x03")
        assert shown.wait_ended() == 0


def test_without_a_joystick_it_says_whether_the_system_lists_devices_at_all(
    bed: VirtualBed,
) -> None:
    for options in (("--list",), ("--udev",)):
        printed = joytest(bed, *options).removeprefix("# ")
        assert printed.startswith(
            "not known whether a joystick is plugged in: this system lists no"
        )
    assert json.loads(joytest(bed, "--json")) is None, "not known is not none"
    bed.plug("ion_icade_bt")  # a keyboard
    assert joytest(bed, "--list") == "no joystick is plugged in\n"
    assert json.loads(joytest(bed, "--json")) == []


def test_what_is_moved_is_seen_at_once_and_so_is_an_unplug(bed: VirtualBed) -> None:
    pad = bed.plug("logitech_f310_dinput")
    with closing(ConsoleProcess(["joytest"], environment=bed.environment)) as shown:
        shown.wait(lambda: "reports a second" in shown.text, 20.0, "the device is not there")
        pad.send(REST)
        pad.send(bytes([255, *REST[1:4], 2, *REST[5:]]))
        shown.wait(lambda: "255  ··········┃██████████ +1.00" in shown.text, 10.0)
        assert "leftx" in shown.text
        assert "right" in next(line for line in shown.screen.display if "dpad" in line)
        pad.unplug()
        shown.wait(lambda: "no joystick is plugged in" in shown.text, 10.0)
        shown.type("\x03")
        assert shown.wait_ended() == 0


def test_what_a_layout_makes_of_it_is_seen_with_its_dead_zone_and_curve(
    bed: VirtualBed, pad: VirtualDevice, tmp_path: Path
) -> None:
    layout = tmp_path / "layout.xml"
    layout.write_text(_LAYOUT)
    command = ["joytest", str(layout)]
    with closing(ConsoleProcess(command, environment=bed.environment, columns=160)) as shown:
        shown.wait(lambda: "reports a second" in shown.text, 20.0, "the device is not there")
        pad.send(REST)
        pad.send(bytes([128, 192, *REST[2:]]))
        half = "ahead          ··········┃██········ +0.2"
        shown.wait(lambda: half in shown.text, 10.0, "the stick is not seen")
        line = next(line for line in shown.screen.display if half in line)
        assert re.search(r"y +lefty +192 .* \+0\.\d\d of \+0\.\d\d  ····", line)
        assert "dead zone 0.20, expo 0.50" in line
        assert "not in the layout" in next(each for each in shown.screen.display if " rz " in each)
        shown.type("\x03")
        assert shown.wait_ended() == 0


def test_a_layout_without_a_joystick_is_refused_by_name(bed: VirtualBed, tmp_path: Path) -> None:
    layout = tmp_path / "layout.xml"
    layout.write_text(re.sub("(?s)<joystick.*</joystick>", "", _LAYOUT))
    command = ["joytest", str(layout)]
    with closing(ConsoleProcess(command, environment=bed.environment, columns=200)) as shown:
        assert shown.wait_ended() == 2
        assert "has no joystick" in shown.text


def test_what_is_moved_is_written_as_a_layout_has_it(bed: VirtualBed, pad: VirtualDevice) -> None:
    learning = warm_start.start(
        [sys.executable, "-m", "rune_tui", "joytest", "--learn"],
        environment=os.environ | bed.environment,
        stdout=subprocess.PIPE,
    )
    assert learning.stdout is not None
    with learning.stdout as said:
        pad.send(REST)
        pad.send(bytes([*REST[:4], 0x28, *REST[5:]]))
        lines = [said.readline() for _ in range(2)]
        learning.send_signal(signal.SIGINT)
        lines += said.readlines()
        assert exit_code(learning, 15.0) == 0
    assert lines == [
        b'<joystick name="pad" vid="046d" pid="c216">\n',
        b'  <control name="a" type="button" role="a"/>\n',
        b"</joystick>\n",
    ]
