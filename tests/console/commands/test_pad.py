"""`rune pad` as a person types it: which joystick, which hub, and how it ends without one."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path

import pytest

from hub.command_line import ExitCode
from hub.gateways.curve.curve_gateway import curve_gateway
from hub.gcm.pad import PadState
from hub.ipc.broker.central import Central
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from rune_tui import cli
from rune_tui.cli import main
from rune_tui.commands import joytest, pad
from rune_tui.commands.pad import Agent, Choice
from rune_tui.controls.devices import hid_reader, local_devices
from rune_tui.controls.devices.device_reader import Gone, News, Opened, Refused, Scanned
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.joystick_set import MOST_FAULTS
from rune_tui.controls.remote_pad.pad_sender import PadSender
from rune_tui.errors import DeviceChoiceError
from tests.console.controls.joystick.pads import LEFT_Y, PAD, A, device
from tests.console.controls.test_joystick_set import FakeReader
from tests.support.cases import for_each

ONE = device("/dev/hidraw1", name="Logitech F310", pid=1, port="1")
TWO = device("/dev/hidraw2", name="Logitech F710", pid=2, port="2")
MOUSE = device("/dev/hidraw0", name="Logitech Mouse", joystick=False)


@for_each(
    ("wanted", "chosen"),
    [("", ONE), ("1", ONE), ("2", TWO), ("f710", TWO), ("*310", ONE), ("mouse", None)],
)
def test_a_joystick_is_chosen_by_its_place_or_its_name(
    wanted: str, chosen: DeviceInfo | None
) -> None:
    assert Choice(wanted, [ONE, TWO]).of([MOUSE, TWO, ONE]) == chosen


def test_the_one_that_was_chosen_is_waited_for_and_no_other_of_its_name_taken() -> None:
    choice = Choice("", [])
    assert choice.of([MOUSE]) is None
    assert choice.of([TWO]) == TWO
    assert choice.of([ONE, TWO]) == TWO
    again = device("/dev/hidraw9", name="Logitech F710", pid=2, port="2")
    assert choice.of([ONE, again]) == again
    assert Choice("2", [ONE, TWO]).of([ONE]) is None


def test_the_numbers_are_those_that_joytest_lists(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hid_reader, "plugged_in", lambda: (MOUSE, TWO, ONE))
    monkeypatch.setattr(joytest, "controls_of", lambda _: ())
    lines = joytest.listed(as_json=False).splitlines()[::2]
    told = json.loads(joytest.listed(as_json=True))
    for number, chosen in ((1, TWO), (2, ONE)):
        assert lines[number - 1].startswith(f"{number}  046d:{chosen.pid:04x} ")
        assert (told[number - 1]["number"], told[number - 1]["name"]) == (number, chosen.name)
        assert Choice(str(number), local_devices.joysticks_here()).of([ONE, TWO]) == chosen


@pytest.mark.parametrize("wanted", ["0", "3"])
def test_a_place_where_none_is_is_refused(wanted: str) -> None:
    with pytest.raises(DeviceChoiceError, match=f"no joystick {wanted}; `rune joytest --list`"):
        Choice(wanted, [ONE, TWO])


class Desk:
    """An agent, the device that it reads, and what it sends."""

    def __init__(self) -> None:
        self.states: list[PadState] = []
        self.reader = FakeReader()
        self.sender = PadSender(lambda _: None, self.states.append)
        self.agent = Agent(Choice("", []), self.reader, self.sender)

    def turn(self, *news: News) -> None:
        self.reader.told += news
        self.agent.turn()


def test_what_a_device_reports_before_it_is_known_to_be_open_is_sent_afterwards() -> None:
    desk = Desk()
    desk.turn(Scanned((ONE,)))
    desk.reader.inboxes[ONE.path].put(((LEFT_Y, 77), (A, 1)))
    desk.turn()
    assert desk.states == []
    desk.turn(Opened(ONE.path, PAD, b""))
    assert desk.states[-1].values[[LEFT_Y, A]].tolist() == [77, 1]


def test_a_device_that_is_gone_is_let_go_of_and_read_again_when_it_is_back() -> None:
    desk = Desk()
    desk.turn(Scanned((ONE,)))
    desk.turn(Opened(ONE.path, PAD, b""))
    desk.turn(Gone(ONE.path))
    assert (desk.states[-1].values.size, desk.agent.device) == (0, None)
    desk.turn(Scanned((ONE,)))
    assert desk.reader.asked == [ONE.path] * 2
    desk.turn(Refused(ONE.path, "may not", forbidden=True))
    assert desk.agent.why.startswith("may not; put into /etc/udev/rules.d/")


def test_a_device_that_falls_silent_again_and_again_is_left_alone_until_it_is_plugged_in_anew() -> (
    None
):
    desk = Desk()
    for _ in range(9):
        desk.turn(Scanned((ONE,)), Gone(ONE.path))
    desk.turn(Scanned((ONE,)))
    assert len(desk.reader.asked) == MOST_FAULTS + 1
    assert "plug it in again" in desk.agent.why
    desk.turn(Scanned(()), Scanned((ONE,)))
    assert len(desk.reader.asked) == MOST_FAULTS + 2


@pytest.fixture(autouse=True)
def nothing_plugged_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cli, "log_to_file", lambda: None)
    monkeypatch.setattr(hid_reader, "plugged_in", lambda: ())
    monkeypatch.setattr(pad, "CONNECT_S", 0.2)


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ([], ExitCode.USAGE, "say where the robot's hub is: `rune pad HOST`"),
        (["--ssh", "robot", "--keys", "k"], ExitCode.USAGE, "leave out one of --ssh and --keys"),
        (["--ssh", "a b"], ExitCode.NO_HUB, "'a b' is no USER@HOST"),
        (["robot:1481"], ExitCode.USAGE, "without keys only this machine"),
        (
            ["robot:1481"],
            ExitCode.USAGE,
            "use `rune run --ssh`, or --keys FILE from `rune-hub keys make NAME --role operate`",
        ),
        (["127.0.0.1", "--device", "1"], ExitCode.USAGE, "there is no joystick 1"),
        (["ipc:///nobody/there"], ExitCode.NO_HUB, "no hub answers at ipc:///nobody/there"),
        (
            ["ipc:///nobody/there"],
            ExitCode.NO_HUB,
            "to reach the robot through ssh, add --ssh USER@",
        ),
    ],
)
def test_what_cannot_be_done_is_said_in_one_sentence(
    arguments: list[str], code: ExitCode, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        ended = main(["pad", *arguments])
    except SystemExit as usage:
        ended = int(usage.code or 0)
    assert ended == code
    complaint = capsys.readouterr().err
    assert said in complaint
    assert complaint.count("\n") == 1


def test_a_key_that_may_only_watch_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    keyring = Keyring(tmp_path / "keys")
    gateway = curve_gateway("tcp://127.0.0.1:0", keyring)
    central = Central([f"ipc://{tmp_path}/c"], gateways=[gateway])
    with closing(central):
        where = [central.endpoints[1], "--keys", str(keyring.make("wall", Role.OBSERVE))]
        assert main(["pad", *where]) == ExitCode.USAGE
    said = capsys.readouterr().err
    assert "wall has a key to observe and may not send GCM_Pad_State" in said


def test_where_no_gateway_is_the_key_is_named_as_one_of_the_reasons(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    key = Keyring(tmp_path / "keys").make("alice", Role.OPERATE)
    assert main(["pad", "ipc:///nobody/there", "--keys", str(key)]) == ExitCode.NO_HUB
    said = capsys.readouterr().err
    assert f"to the key in {key}; is that its gateway's port" in said
    assert "through ssh, add --ssh USER@HOST" in said


def test_a_hub_that_does_not_answer_behind_ssh_is_named_as_the_robot_knows_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    class Way:
        """Leads to a machine without a hub."""

        def __init__(self, destination: str, hub: str) -> None:
            del hub
            self.destination, self.endpoint = destination, f"ipc://{tmp_path}/hub"

        def open(self) -> None:
            """At once."""

        def close(self) -> None:
            """There is nothing to do."""

    monkeypatch.setattr(pad, "tunnel_to", Way)
    assert main(["pad", "--ssh", "alice@robot"]) == ExitCode.NO_HUB
    said = capsys.readouterr().err
    why = "no hub answers at ssh alice@robot; is rune-hub running there?"
    assert said == f"rune: {why}\n"
