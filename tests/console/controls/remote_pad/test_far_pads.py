"""Gamepads of other machines, as joysticks of the layout: nothing that comes is trusted."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable
from contextlib import closing
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import CodecError
from hub.gcm.pad import OLDEST_S, PAD_DEVICE, PAD_STATE, PadDevice, PadState
from rune_tui.controls.devices.device_reader import Scanned
from rune_tui.controls.devices.hid_reader import HidMissingError
from rune_tui.controls.joystick.calibration_store import CalibrationStore
from rune_tui.controls.joystick_set import Joysticks
from rune_tui.controls.joystick_sources import Sources
from rune_tui.controls.remote_pad.far_pads import (
    IDLE_SILENCE_S,
    LONGEST_DESCRIPTOR,
    MOST_PADS,
    WAITING_SILENCE_S,
    FarPads,
    Sender,
)
from rune_tui.controls.remote_pad.pad_values import Row
from rune_tui.layout.spec import JoystickSpec
from rune_tui.model.joystick_state import Absence, JoystickPhase, JoystickState
from tests.console.controls.hid.fixtures import device as recorded
from tests.console.controls.joystick import pads
from tests.console.controls.joystick.pads import control, joystick, told
from tests.console.controls.pure_agent import HeardPads
from tests.console.controls.test_joystick_set import FakeReader
from tests.support.waiting import until

F310 = recorded("logitech_f310_dinput")
CONTROLS = F310.decoder().controls
SPEC = joystick(control("lefty"), control("a"))
ALICE: Sender = ("magellan", 7)
STEP_S = 0.02


def told_device(**more: Any) -> PadDevice:
    descriptor = more.pop("descriptor", F310.descriptor)
    whole: dict[str, Any] = {
        "session": 1,
        "machine": "desk",
        "name": "F310",
        "vid": F310.vid,
        "pid": F310.pid,
        "bus": F310.bus,
        "descriptor": np.frombuffer(descriptor, np.uint8),
    }
    return PadDevice(**whole | more)


class Far:
    """A console where nothing is plugged in, and a pad elsewhere."""

    def __init__(self, spec: JoystickSpec = SPEC, operator: str = "bob") -> None:
        self.now = 100.0
        self.near = FakeReader()
        self.pads = HeardPads(operator, lambda: self.now)
        self.sources = Sources(self.near, self.pads)
        self.joysticks = Joysticks((spec,), self.sources, CalibrationStore())
        self.joysticks.start(lambda: None)
        self.row = Row(CONTROLS)

    def report(
        self, y: int = 128, *, a: bool = False, sender: Sender = ALICE, **more: Any
    ) -> list[Any]:
        """The next state, which is new; what comes of it."""
        self.now += STEP_S
        raws = {"lefty": y, "a": int(a)}
        self.row.take((p, raws[c.role]) for p, c in enumerate(CONTROLS) if c.role in raws)
        age = more.pop("age", 0.0)
        row = np.array(self.row.values, np.int32)
        state = PadState(**{"session": 1, "active": 1, "values": row} | more)
        self.pads.state_came(sender, state, self.now - age)
        return self.take()

    def take(self) -> list[Any]:
        events: list[Any] = []
        for _ in range(3):  # what is opened is told with the news after that
            events += told([*self.joysticks.events(self.now)])
        return events

    def wait(self, seconds: float) -> list[Any]:
        self.now += seconds
        return self.take()

    @property
    def state(self) -> JoystickState:
        return self.joysticks.states["pad"]

    @property
    def plugged(self) -> bool:
        return self.state.phase is JoystickPhase.CONNECTED


@pytest.fixture
def far() -> Far:
    """With a pad that is plugged in there and at rest."""
    made = Far()
    made.pads.device_came(ALICE, told_device())
    assert made.report() == []
    return made


FORWARD = ("lefty", True, False, 1.0)
RELEASED = ("lefty", False, False, 0.0)


def test_it_is_a_joystick_like_any_other_and_says_where_it_is_and_how_old(far: Far) -> None:
    assert (far.state.device, far.state.machine) == ("F310 at desk", "desk")
    assert far.report(0)[0] == FORWARD
    assert far.state.values["lefty"] == 1.0
    assert far.report(age=0.1) == [("lefty pressed", False, False, 0.0), RELEASED][::-1]
    assert far.state.measured == pytest.approx(far.now - 0.1)
    assert far.report() == []
    assert far.state.measured == far.now


def test_a_silence_while_it_is_used_lets_go_and_then_it_counts_from_neutral_only(
    far: Far,
) -> None:
    far.report(0)
    assert far.wait(OLDEST_S) == []
    assert RELEASED in far.wait(0.001)
    assert far.state.lost
    assert far.report(0) == []
    assert far.report(1) == []
    assert far.plugged
    assert far.state.waiting == {"lefty"}
    far.report(128)
    assert far.report(0)[0] == FORWARD


def test_a_silence_that_ended_before_anybody_looked_was_a_silence_all_the_same(far: Far) -> None:
    far.report(0)
    far.now += OLDEST_S
    assert RELEASED in far.report(0)
    assert far.report(1) == []
    assert far.state.waiting == {"lefty"}


def test_states_of_a_session_that_was_not_told_of_are_nobodys(far: Far) -> None:
    assert far.report(0, session=2) == []
    assert far.state.values["lefty"] == 0.0


def test_a_button_that_was_held_over_a_silence_counts_when_it_is_pressed_anew(far: Far) -> None:
    assert far.report(a=True) == [("a", True, False, 1.0)]
    assert far.wait(1.0) == [("a", False, False, 0.0)]
    assert far.report(a=True) == []
    assert far.report(a=False) == []
    assert far.report(a=True) == [("a", True, False, 1.0)]


def test_a_pad_that_nobody_touches_may_be_silent_for_longer(far: Far) -> None:
    far.report(active=0)
    far.wait(IDLE_SILENCE_S - STEP_S)
    assert far.plugged
    assert far.report(0)[0] == FORWARD
    far.report(active=0)
    far.wait(IDLE_SILENCE_S + 0.001)
    assert not far.plugged


NO_VALUES = np.zeros(0, np.int32)
UNPLUGGED = {"active": 1, "values": NO_VALUES}
ENDED = {"active": 0, "values": NO_VALUES}


@pytest.mark.parametrize(
    ("said", "absence"), [(UNPLUGGED, Absence.UNPLUGGED), (ENDED, Absence.ENDED)]
)
def test_a_device_that_is_gone_there_is_gone_at_once_and_why_is_known(
    far: Far, said: dict[str, Any], absence: Absence
) -> None:
    far.report(0)
    assert RELEASED in far.report(**said)
    assert far.state.lost
    assert far.state.absence is absence


def test_who_waited_for_its_device_and_ended_or_fell_silent_is_not_unplugged_any_more(
    far: Far,
) -> None:
    far.report(**UNPLUGGED)
    far.wait(WAITING_SILENCE_S - STEP_S)
    assert far.state.absence is Absence.UNPLUGGED
    far.wait(2 * STEP_S)
    assert far.state.absence is Absence.SILENT
    far.report(**UNPLUGGED)
    assert far.state.absence is Absence.UNPLUGGED
    far.report(**ENDED)
    far.wait(1e4)
    assert far.state.absence is Absence.ENDED


def test_a_silence_is_told_as_one_whatever_was_before_it(far: Far) -> None:
    far.report(**UNPLUGGED)
    far.pads.device_came(ALICE, told_device(session=2))
    assert far.state.absence is Absence.UNPLUGGED
    far.report(session=2)
    assert far.plugged
    far.wait(OLDEST_S + STEP_S)
    assert (far.state.lost, far.state.absence) == (True, Absence.SILENT)


def test_what_one_said_last_outlasts_that_it_is_forgotten(far: Far) -> None:
    far.report(**ENDED)
    assert far.state.absence is Absence.ENDED
    far.now += 60.0
    far.pads.device_came(("magellan", 8), told_device(machine="elsewhere"))
    far.take()
    assert far.state.absence is Absence.ENDED


def test_a_sender_that_begins_anew_has_another_device_which_has_to_be_neutral_first(
    far: Far,
) -> None:
    far.report(0)
    far.pads.device_came(ALICE, told_device(session=2))
    assert RELEASED in far.take()
    assert far.report(0) == []
    assert far.report(0, session=2) == []
    assert far.plugged
    assert far.state.waiting == {"lefty"}


def test_what_is_too_old_is_dropped_and_counted_and_drives_nothing(far: Far) -> None:
    assert far.report(0, age=OLDEST_S + 0.001) == []
    assert far.pads.late == 1
    assert far.state.values["lefty"] == 0.0


def test_of_states_that_come_together_the_newest_counts_and_every_click(far: Far) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(far, "take", list)
        for y in (0, 40, 0):
            far.report(y, a=True)
            far.report(y, a=False)
    events = far.take()
    assert [event for event in events if event[0] == "lefty"] == [FORWARD]
    assert [event[1] for event in events if event[0] == "a"] == [True, False] * 3


def test_a_pad_for_another_operator_is_left_out_and_one_for_this_one_is_not() -> None:
    far = Far(operator="bob")
    far.pads.device_came(ALICE, told_device(operator="alice"))
    far.report()
    assert not far.plugged
    far.pads.device_came(ALICE, told_device(operator="bob"))
    far.report()
    assert far.plugged
    far.pads.device_came(ALICE, told_device(operator="alice"))
    far.take()
    assert not far.plugged


def test_the_layout_says_by_name_which_it_means() -> None:
    far = Far(joystick(control("lefty"), device="Logitech*"))
    far.pads.device_came(ALICE, told_device())
    far.report()
    assert not far.plugged
    far.pads.device_came(ALICE, told_device(name="Logitech F310"))
    far.report()
    assert far.plugged


def test_what_is_plugged_in_here_comes_first_and_somebody_elses_pad_does_not_take_its_place() -> (
    None
):
    far = Far()
    far.near.told.append(Scanned((pads.device(port="usb-2"),)))
    far.pads.device_came(ALICE, told_device(port="usb-1"))
    far.report()
    assert far.near.asked == ["/dev/hidraw0"]
    far.near.told.append(Scanned(()))
    far.report()
    assert not far.plugged


def test_without_hidapi_those_of_other_machines_work_and_the_others_are_explained() -> None:
    class NoReader(FakeReader):
        def start(self, notify: Callable[[], None]) -> None:
            del notify
            text = "joysticks need hidapi"
            raise HidMissingError(text)

    far = Far()
    far.joysticks = Joysticks((SPEC,), Sources(NoReader(), far.pads), CalibrationStore())
    far.joysticks.start(lambda: None)
    assert far.state.why == "joysticks need hidapi"
    far.pads.device_came(ALICE, told_device())
    far.report()
    assert far.plugged
    assert far.report(0)[0] == FORWARD


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"descriptor": b"\xc0"}, "its report descriptor cannot be read"),
        ({"descriptor": b""}, "it is no joystick"),
    ],
)
def test_what_describes_itself_wrongly_is_said_to_be_unusable(
    wrong: dict[str, Any], said: str
) -> None:
    far = Far()
    far.pads.device_came(ALICE, told_device(**wrong))
    far.report()
    assert far.state.phase is JoystickPhase.UNSUITABLE
    assert far.state.why.startswith(said)


def test_states_of_another_length_long_descriptors_and_too_many_pads_are_refused(far: Far) -> None:
    far.report(0, values=np.zeros(3, np.int32))
    assert far.pads.refused == 1
    assert far.state.values["lefty"] == 0.0
    far.pads.device_came(("r", 1), told_device(descriptor=bytes(LONGEST_DESCRIPTOR + 1)))
    assert far.pads.refused == 2
    far.report(active=0)
    for number in range(MOST_PADS):
        far.pads.device_came(("r", number), told_device())
        far.report(sender=("r", number), active=0)
    assert far.pads.refused == 3


def test_who_told_of_a_pad_and_is_silent_makes_room_for_others(far: Far) -> None:
    for number in range(3 * MOST_PADS):
        far.now += 0.01
        far.pads.device_came(("r", number), told_device())
    assert far.pads.refused == 0
    assert far.plugged


def payload(definition: Any, value: Any) -> bytes:
    return b"".join(definition.encode(value))


@st.composite
def damaged(draw: st.DrawFn, whole: bytes) -> bytes:
    """A payload in which some bytes are others, or that is cut off; or any bytes."""
    if draw(st.booleans()):
        return draw(st.binary(max_size=60))
    taken = bytearray(whole[: draw(st.integers(0, len(whole)))] if draw(st.booleans()) else whole)
    for place in draw(st.lists(st.integers(0, max(0, len(taken) - 1)), max_size=6)):
        if taken:
            taken[place] = draw(st.integers(0, 255))
    return bytes(taken)


DEVICE = payload(PAD_DEVICE, told_device())
STATE = payload(PAD_STATE, PadState(session=1, active=1, values=np.arange(17, dtype=np.int32)))


@given(
    messages=st.lists(
        st.one_of(
            st.tuples(st.just(PAD_DEVICE), damaged(DEVICE)),
            st.tuples(st.just(PAD_STATE), damaged(STATE)),
        ),
        max_size=6,
    )
)
def test_any_bytes_are_a_message_or_refused_and_nothing_breaks(
    messages: list[tuple[Any, bytes]],
) -> None:
    far = Far()
    far.pads.device_came(ALICE, told_device())
    far.report()
    for definition, raw in messages:
        try:
            value = definition.decode(raw)
        except CodecError:
            continue
        if definition is PAD_DEVICE:
            far.pads.device_came(ALICE, value)
        else:
            far.pads.state_came(ALICE, value, far.now)
        far.take()
        assert all(map(str.isprintable, far.state.device))
    for event in far.wait(2.0):
        assert not event[1]
    assert not far.plugged


def test_silence_wakes_who_waits_without_being_asked() -> None:
    woken = threading.Event()
    pads_there = FarPads()
    with closing(pads_there):
        pads_there.start(woken.set)
        now = time.monotonic()
        pads_there.device_came(ALICE, told_device())
        state = PadState(session=1, active=1, values=zeros())
        pads_there.state_came(ALICE, state, now)
        devices = [news.devices for news in pads_there.news() if isinstance(news, Scanned)]
        assert [len(each) for each in devices] == [1]
        woken.clear()
        assert woken.wait(10.0)
        until(lambda: pads_there.news() == [Scanned(())], 10.0)


def zeros() -> np.ndarray[Any, np.dtype[np.int32]]:
    return np.zeros(len(CONTROLS), np.int32)


def test_the_same_said_again_changes_nothing(far: Far) -> None:
    far.report(0)
    far.pads.device_came(ALICE, dataclasses.replace(told_device()))
    assert far.take() == []
    assert far.plugged
