"""When a gamepad's state is sent, and what it says."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from hub.gcm.pad import OLDEST_S, PadDevice, PadState
from rune_tui.controls.hid.reading import Value
from rune_tui.controls.remote_pad.pad_sender import ACTIVE_FOR_S, PadSender
from tests.console.controls.joystick.pads import LEFT_X, LEFT_Y, PAD, REST, A, device

TURN_S = 0.02


class Sending:
    """A sender, what it has sent, and its time."""

    def __init__(self) -> None:
        self.devices: list[PadDevice] = []
        self.states: list[PadState] = []
        self.now = 0.0
        self.sender = PadSender(
            self.devices.append, self.states.append, operator="alice", machine="desk"
        )
        self.sender.plug(device(serial="7"), PAD, b"descriptor")

    def turn(self, *values: Value) -> None:
        self.now += TURN_S
        self.sender.turn(values, self.now)

    def states_in(self, seconds: float) -> int:
        """How many are sent while nothing changes."""
        before = len(self.states)
        for _ in range(round(seconds / TURN_S)):
            self.turn()
        return len(self.states) - before


@pytest.fixture
def sending() -> Sending:
    made = Sending()
    made.turn(*REST)
    return made


def values(state: PadState) -> Sequence[int]:
    numbers: list[int] = state.values.tolist()
    return numbers


def test_it_says_at_once_and_every_two_seconds_what_the_device_is(sending: Sending) -> None:
    (told,) = sending.devices
    assert (told.name, told.serial, told.machine, told.operator) == ("Pad", "7", "desk", "alice")
    assert told.descriptor.tobytes() == b"descriptor"
    sending.states_in(6.0)
    assert len(sending.devices) == 4


def test_a_pad_at_rest_is_told_of_five_times_a_second_and_one_in_use_fifty(
    sending: Sending,
) -> None:
    assert sending.states_in(ACTIVE_FOR_S) == pytest.approx(50, abs=2)
    assert sending.states_in(4.0) == pytest.approx(20, abs=1)
    assert not sending.states[-1].active
    sending.turn((LEFT_Y, 0))
    assert sending.states[-1].active
    assert sending.states_in(10.0) == 500
    sending.turn((LEFT_Y, 128))
    assert sending.states_in(ACTIVE_FOR_S) == pytest.approx(50, abs=2)
    assert sending.states_in(1.0) == 5


def test_what_changes_at_rest_is_sent_with_the_next_turn(sending: Sending) -> None:
    sending.states_in(2.0)
    before = len(sending.states)
    sending.turn((LEFT_X, 255))
    assert len(sending.states) == before + 1
    assert values(sending.states[-1])[LEFT_X] == 255


def test_a_click_within_one_turn_is_two_edges(sending: Sending) -> None:
    before = values(sending.states[-1])[A]
    sending.turn((A, 1), (A, 0))
    assert values(sending.states[-1])[A] == before + 2


def test_after_standing_still_it_begins_anew_so_that_all_has_to_be_neutral_first(
    sending: Sending,
) -> None:
    session = sending.states[-1].session
    sending.now += OLDEST_S + TURN_S
    sending.turn((LEFT_Y, 0))
    assert sending.states[-1].session == sending.devices[-1].session == session + 1


def test_a_device_that_is_gone_is_told_to_be_gone_at_once_and_now_and_then(
    sending: Sending,
) -> None:
    before = len(sending.states)
    sending.sender.unplug()
    sending.sender.unplug()
    sending.now += OLDEST_S  # no session begins anew without a device
    sending.states_in(6.0)
    gone = sending.states[before:]
    assert len(gone) == 1 + 3
    assert {(state.session, state.active, state.values.size) for state in gone} == {(1, 1, 0)}
    assert not sending.sender.plugged
    sending.sender.plug(device(), PAD, b"")
    sending.turn()
    assert sending.states[-1].session == sending.states[-2].session + 1


def test_a_sender_that_ends_says_that_it_does_whether_a_device_is_there_or_not(
    sending: Sending,
) -> None:
    sending.sender.end()
    assert (sending.states[-1].active, sending.states[-1].values.size) == (0, 0)
    sending.sender.unplug()
    assert sending.states[-1].active == 0
