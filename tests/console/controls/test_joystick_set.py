"""What the console learns of joysticks as devices come and go."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rune_tui.controls.devices.device_reader import Gone, Opened, Refused, Scanned
from rune_tui.controls.devices.hid_reader import HidMissingError
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.joystick.calibration import TIME_TO_ACT_S, Calibration
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.controls.joystick_set import Joysticks
from rune_tui.layout.spec import JoystickSpec
from rune_tui.model.joystick_state import JoystickPhase, JoystickState
from tests.console.controls.joystick.fake_reader import FakeReader
from tests.console.controls.joystick.pads import (
    ALL,
    LEFT_X,
    LEFT_Y,
    PAD,
    REST,
    A,
    control,
    device,
    joystick,
    told,
)


class Table:
    """Joysticks of a layout and devices that are plugged in and out."""

    def __init__(self, *specs: JoystickSpec) -> None:
        self.reader = FakeReader()
        self.joysticks = Joysticks(specs or (ALL,), self.reader, CalibrationStore())
        self.woken = 0
        self.joysticks.start(self.wake)
        self.now = 0.0

    def wake(self) -> None:
        self.woken += 1

    def plug(self, *devices: DeviceInfo) -> list[object]:
        """These are plugged in, and no others; those that are opened can be read."""
        self.reader.told.append(Scanned(devices))
        events = self.take()
        asked, self.reader.asked = self.reader.asked, []
        self.reader.told += [Opened(path, PAD) for path in asked]
        return events + self.take()

    def report(self, *values: tuple[int, int | None], path: str = "/dev/hidraw0") -> list[object]:
        inbox = self.reader.inboxes[path]
        inbox.put(values)
        return self.take()

    def take(self) -> list[object]:
        self.now += 0.01
        return list(told([*self.joysticks.events(self.now)]))

    def press(self) -> None:
        self.report((A, 1))
        self.report((A, 0))

    @property
    def state(self) -> JoystickState:
        return next(iter(self.joysticks.states.values()))


def resting() -> Table:
    table = Table()
    table.plug(device())
    table.report(*REST)
    return table


def test_a_device_that_is_plugged_in_drives_and_is_shown() -> None:
    table = Table()
    assert table.state.phase is JoystickPhase.MISSING
    assert not table.state.lost
    table.plug(device())
    assert (table.state.phase, table.state.device) == (JoystickPhase.CONNECTED, "Pad")
    table.report(*REST)
    assert table.report((LEFT_Y, 0))[0] == ("lefty", True, False, 1.0)
    assert table.state.values["lefty"] == 1.0


def test_unplugged_while_deflected_is_released_at_once_and_counts_again_from_neutral() -> None:
    table = resting()
    table.report((LEFT_Y, 0))
    table.reader.told.append(Gone("/dev/hidraw0"))
    assert ("lefty", False, False, 0.0) in table.take()
    assert table.state.lost
    assert table.state.values == {}
    table.plug()
    table.plug(device("/dev/hidraw1"))
    assert table.state.phase is JoystickPhase.CONNECTED
    assert table.report(*REST[:1], (LEFT_Y, 0), path="/dev/hidraw1") == []
    table.report((LEFT_Y, 128), path="/dev/hidraw1")
    assert table.report((LEFT_Y, 0), path="/dev/hidraw1")


def test_a_look_that_no_longer_finds_the_device_releases_as_well() -> None:
    table = resting()
    table.report((A, 1))
    assert table.plug() == [("a", False, False, 0.0)]
    assert table.state.lost


def test_what_waits_when_everything_is_let_go_does_not_count() -> None:
    table = resting()
    table.report((A, 1))
    table.reader.inboxes["/dev/hidraw0"].put(((LEFT_Y, 0),))
    released = told(table.joysticks.release_all(1.0))
    assert released == [("lefty", False, False, 0.0)], "a is still held"
    assert table.report((LEFT_Y, 5)) == []
    table.report((LEFT_Y, 128), (A, 0))
    assert len(table.report((LEFT_Y, 0), (A, 1))) == 3


def test_what_is_let_go_of_while_events_are_given_out_is_left_out() -> None:
    table = resting()
    table.reader.inboxes["/dev/hidraw0"].put(
        (
            (A, 1),
            (LEFT_Y, 0),
        )
    )
    given = []
    for event in table.joysticks.events(1.0):
        given += told([event])
        table.joysticks.release_all(1.0)
    assert given == [("a", True, False, 1.0)]
    assert table.report((LEFT_Y, 5)) == []


def test_no_permission_is_said_with_the_rule_that_gives_it_and_tried_again() -> None:
    table = Table()
    refused = Refused("/dev/hidraw0", "Permission denied", forbidden=True)
    for _ in range(2):
        table.reader.told.append(Scanned((device(),)))
        table.take()
        assert table.reader.asked.pop() == "/dev/hidraw0"
        table.reader.told.append(refused)
        table.take()
    assert table.state.phase is JoystickPhase.FORBIDDEN
    assert 'KERNELS=="*:046D:C216.*"' in table.state.why
    table.plug(device())
    assert (table.state.phase, table.state.why) == (JoystickPhase.CONNECTED, "")


def test_a_device_whose_reports_cannot_be_understood_is_not_tried_again() -> None:
    table = Table()
    table.reader.told += [Scanned((device(),))]
    table.take()
    table.reader.asked.clear()
    table.reader.told += [Refused("/dev/hidraw0", "it is odd", unsuitable=True)]
    table.reader.told += [Scanned((device(),))]
    table.take()
    assert table.reader.asked == []
    assert (table.state.phase, table.state.why) == (JoystickPhase.UNSUITABLE, "it is odd")


def test_a_device_that_falls_silent_again_and_again_is_given_up_until_it_is_plugged_anew() -> None:
    table = Table()
    for _ in range(4):
        table.plug(device())
        assert table.state.phase is JoystickPhase.CONNECTED
        table.reader.told.append(Gone("/dev/hidraw0"))
        table.take()
    table.plug(device())
    assert table.state.phase is JoystickPhase.UNSUITABLE
    table.plug()
    table.plug(device())
    assert table.state.phase is JoystickPhase.CONNECTED


def test_a_keyboard_that_the_layout_names_is_said_to_be_none() -> None:
    table = Table(joystick(control("leftx"), vid=0x046D))
    table.plug(device(joystick=False))
    assert table.state.phase is JoystickPhase.UNSUITABLE
    assert "is no joystick" in table.state.why


def test_controls_that_the_device_lacks_are_named() -> None:
    table = Table(joystick(control("leftx"), control("rightx")))
    table.plug(device())
    assert table.state.phase is JoystickPhase.CONNECTED
    assert table.state.why == "it has no rightx"


def test_two_pads_of_a_kind_are_a_joystick_each() -> None:
    table = Table(joystick(control("a"), name="one"), joystick(control("a"), name="two"))
    table.plug(device("x", port="1"), device("y", port="2"))
    assert table.joysticks.states["two"].phase is JoystickPhase.CONNECTED
    table.reader.inboxes["y"].put(((A, 1),))
    (event,) = table.joysticks.events(9.0)
    assert event.name == "joystick two a"


def test_another_layout_keeps_the_device_open_and_lets_go_of_it() -> None:
    table = resting()
    inbox = table.reader.inbox("/dev/hidraw0")
    table.report((LEFT_Y, 0), (A, 1))
    table.joysticks.follow([joystick(control("lefty"), control("a"))], 2.0)
    assert table.reader.inbox("/dev/hidraw0") is inbox
    assert table.state.phase is JoystickPhase.CONNECTED
    assert table.report((LEFT_Y, 2)) == []
    assert table.report((A, 0), (LEFT_Y, 128)) == []
    assert len(table.report((A, 1), (LEFT_Y, 0))) == 3


def test_another_layout_without_it_closes_the_device() -> None:
    table = resting()
    table.joysticks.follow([], 2.0)
    assert table.reader.inboxes == {}
    assert table.joysticks.states == {}
    table.joysticks.follow([ALL], 3.0)
    assert table.reader.asked == ["/dev/hidraw0"]


def test_another_layout_that_wants_another_kind_gives_the_device_up() -> None:
    table = resting()
    table.joysticks.follow([joystick(control("a"), vid=0x054C)], 2.0)
    assert table.reader.inboxes == {}
    assert table.state.phase is JoystickPhase.MISSING


def test_a_layout_without_joysticks_looks_for_none() -> None:
    reader = FakeReader()
    joysticks = Joysticks((), reader, CalibrationStore())
    joysticks.start(lambda: None)
    assert [*joysticks.events(1.0)] == []
    assert reader.started == 0
    joysticks.follow([ALL], 2.0)
    assert reader.started == 1


def test_without_the_library_the_reason_is_shown() -> None:
    class NoReader(FakeReader):
        def start(self, notify: Callable[[], None]) -> None:
            super().start(notify)
            text = "joysticks need hidapi"
            raise HidMissingError(text)

    joysticks = Joysticks((ALL,), NoReader(), CalibrationStore())
    joysticks.start(lambda: None)
    assert joysticks.states["pad"].why == "joysticks need hidapi"
    assert [*joysticks.events(1.0)] == []


def test_the_operator_is_led_through_a_calibration_that_drives_nothing() -> None:
    table = resting()
    table.joysticks.calibrate("", "leftx", table.now)
    for raw in (240, 20, 130):
        assert "leftx" in table.state.prompt
        assert table.report((LEFT_X, raw)) == []
        table.press()
    assert table.state.prompt == ""
    assert table.joysticks.store.of(device().key) == {
        "x": Calibration(low=20, high=240, centre=130)
    }
    assert table.joysticks.unsaved
    assert table.joysticks.tick(table.now) == ["pad is calibrated"]
    table.report((LEFT_X, 130))
    assert table.report((LEFT_X, 240))[0] == ("leftx", True, False, 1.0)


def test_a_stick_that_does_not_count_before_it_is_let_go_of_is_told() -> None:
    table = Table()
    table.plug(device())
    table.report((LEFT_X, 128), (LEFT_Y, 0))
    assert table.state.waiting == {"lefty"}
    table.report((LEFT_Y, 128))
    table.report((LEFT_Y, 0))
    assert table.state.waiting == set()
    table.joysticks.release_all(table.now)
    assert table.state.waiting == {"lefty"}
    table.joysticks.calibrate("", "", table.now)
    assert table.state.waiting == set()


def test_a_calibration_lets_go_of_a_stick_that_reports_nothing_more() -> None:
    table = resting()
    table.report((LEFT_Y, 0))
    assert table.woken == 0
    table.joysticks.calibrate("", "", table.now)
    assert table.woken == 1
    assert ("lefty", False, False, 0.0) in table.take()


def test_a_calibration_ends_when_it_is_asked_for_again_or_nothing_is_done() -> None:
    table = resting()
    table.joysticks.calibrate("pad", "", table.now)
    table.joysticks.calibrate("pad", "", table.now)
    assert "you ended it" in table.joysticks.tick(table.now)[0]
    assert table.state.prompt == ""
    table.joysticks.calibrate("pad", "", table.now)
    (said,) = table.joysticks.tick(table.now + TIME_TO_ACT_S + 1.0)
    assert "nothing was done" in said
    assert not table.joysticks.unsaved


@pytest.mark.parametrize(("name", "axis"), [("other", ""), ("pad", "nothing")])
def test_a_calibration_of_what_is_not_there_says_so(name: str, axis: str) -> None:
    table = resting()
    table.joysticks.calibrate(name, axis, 1.0)
    (said,) = table.joysticks.tick(1.0)
    assert f"no joystick {name}" in said or f"no axis {axis}" in said


def test_a_calibration_of_what_is_not_plugged_in_says_so() -> None:
    table = Table()
    table.joysticks.calibrate("", "", 1.0)
    assert "not plugged in" in table.joysticks.tick(1.0)[0]


def test_axes_that_the_layout_wants_calibrated_are_asked_for_once_a_device() -> None:
    spec = joystick(control("leftx", calibrate=True), control("lefty"))
    table = Table(spec)
    table.plug(device())
    for raw in (240, 20, 130):
        assert "leftx" in table.state.prompt
        table.report((LEFT_X, raw))
        table.press()
    assert table.state.prompt == ""
    table.joysticks.store.save()
    again = Table(spec)
    again.plug(device())
    assert again.state.prompt == ""


def test_broken_calibrations_are_told_of() -> None:
    path = CalibrationStore().path
    path.parent.mkdir(parents=True)
    path.write_text("{")
    (said,) = Table().joysticks.tick(0.0)
    assert str(path) in said
