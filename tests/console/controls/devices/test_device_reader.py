"""When what a device reports is passed on."""

from __future__ import annotations

import threading

from rune_tui.controls.devices.device_reader import DeviceReader
from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.hid.reading import Value
from tests.console.controls.joystick.pads import LEFT_X, PAD
from tests.support.waiting import until

INFO = DeviceInfo(path="pad", vid=1, pid=2)


class Pad:
    """A pad that reports once, as somebody waits for it, and twice more before the next look."""

    controls = PAD
    descriptor = b""

    def __init__(self) -> None:
        self.notified = threading.Event()
        self.looks: list[tuple[bool, bool]] = []
        """Whether each look waited, and whether a report was passed on before it."""
        self._reports = iter((None, 5, 6, 7))

    def read(self, timeout: float) -> tuple[Value, ...] | None:
        if not self.looks:
            self.notified.clear()  # that it was opened is news too
        self.looks.append((timeout > 0.0, self.notified.is_set()))
        report = next(self._reports, None)
        return None if report is None else ((LEFT_X, report),)

    def close(self) -> None:
        pass


class Pads:
    """The kind of devices with that pad."""

    def __init__(self) -> None:
        self.pad = Pad()

    def require(self) -> None:
        pass

    def plugged_in(self) -> tuple[DeviceInfo, ...]:
        return (INFO,)

    def mark(self) -> object:
        return 1

    def open(self, info: DeviceInfo) -> Pad:
        assert info == INFO
        self.pad.notified.clear()
        return self.pad


def test_a_report_that_was_waited_for_is_passed_on_before_the_next_look() -> None:
    kind = Pads()
    pad, reader = kind.pad, DeviceReader([kind])
    reader.start(pad.notified.set)
    try:
        reader.read(INFO)
        until(lambda: len(pad.looks) > 6, 10.0)
        inbox = reader.inbox("pad")
    finally:
        reader.close()
    # Not the first look, which finds nothing: the second waits, and gets the first report.
    assert [waited for waited, _ in pad.looks[:3]] == [False, True, False]
    assert pad.looks[2][1]
    assert inbox is not None
    assert dict(inbox.everything())[LEFT_X] == 7
