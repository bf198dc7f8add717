"""A pad as a decoder describes it, and joysticks of layouts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rune_tui.controls.devices.matching import DeviceInfo
from rune_tui.controls.events import ControlEvent
from rune_tui.controls.hid.device_controls import PhysicalControl
from rune_tui.layout.names import ROLES
from rune_tui.layout.spec import ControlKind, ControlSpec, JoystickSpec

LEFT_X, LEFT_Y, TRIGGER, A, HAT, BALL = range(6)


def physical(kind: ControlKind, usage: str, role: str = "", high: int = 255, **more: Any) -> Any:
    values = {"index": 0, "minimum": 0, "flipped": False, **more}
    return PhysicalControl(kind=kind, usage=usage, role=role, maximum=high, **values)


PAD = (
    physical(ControlKind.AXIS, "x", "leftx"),
    physical(ControlKind.AXIS, "y", "lefty", flipped=True),
    physical(ControlKind.AXIS, "rx", "righttrigger"),
    physical(ControlKind.BUTTON, "button 1", "a", high=1),
    physical(ControlKind.HAT, "hat switch", "dpad", high=7),
    physical(ControlKind.BALL, "wheel", high=127, minimum=-127),
)
REST = ((LEFT_X, 128), (LEFT_Y, 128), (TRIGGER, 0), (A, 0), (HAT, None))


def control(role: str, **more: Any) -> ControlSpec:
    return ControlSpec(**{"name": role, "kind": ROLES[role], "role": role, **more})


def joystick(*controls: ControlSpec, name: str = "pad", **more: Any) -> JoystickSpec:
    return JoystickSpec(name=name, controls=controls, **more)


ALL = joystick(
    control("leftx"),
    control("lefty"),
    control("righttrigger"),
    control("a"),
    control("dpad"),
    ControlSpec(name="wheel", kind=ControlKind.BALL, usage="wheel"),
)


def device(path: str = "/dev/hidraw0", **more: Any) -> DeviceInfo:
    return DeviceInfo(**{"path": path, "vid": 0x046D, "pid": 0xC216, "name": "Pad", **more})


def told(events: Sequence[ControlEvent]) -> list[tuple[str, bool, bool, float]]:
    """Name without the joystick's, pressed, repeat, value."""
    return [
        (event.name.split(" ", 2)[2], event.pressed, event.repeat, round(event.value, 3))
        for event in events
    ]
