"""Widgets that move the camera by steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from hub.gcm.vision import CAMERA_COMMAND, CameraCommand, CameraMotion
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import HandlerRule, NumberOption, Section
from rune_tui.layout.spec import CHOSEN, EventSpec
from rune_tui.model.cameras import CAMERA_OPTION, camera_of
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, SendEffect
from rune_tui.widgets.stepping import SteppingWidget
from rune_tui.widgets.widget import PressWidget

_PAN = NumberOption(
    default=5.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, to the left"
)
_TILT = NumberOption(default=3.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, upwards")


class _AdjustCamera(SteppingWidget):
    """Moves the camera by a step.

    Attributes:
        moves: Effect of each of its controls: a member of the command, and the option with the
            size of a step; sizes in degrees end in `_deg`.
    """

    moves: ClassVar[Mapping[str, tuple[str, str]]]

    def step(self, value: float, control: str, state: ConsoleState) -> Effect:
        """One command: the size of a step times the value."""
        member, option = self.moves[control]
        size = self.spec.options.number(option)
        step = math.radians(size) if option.endswith("_deg") else size
        amount: dict[str, Any] = {member: step * value}
        command = CameraCommand(**amount, camera=_commanded_camera(self, state))
        return SendEffect(robot=self.robot, definition=CAMERA_COMMAND, value=command)


class AdjustPan(_AdjustCamera):
    """Turns the camera; a positive value means left."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Look {direction}"},
        meaning="Turns the camera by steps while held; positive is left.",
        options={"step_deg": _PAN, "camera": CAMERA_OPTION},
        sends=("GCM_Camera_Command",),
        words={"": ("left", "right")},
    )
    moves: ClassVar = {"": ("pan", "step_deg")}


class AdjustTilt(_AdjustCamera):
    """Tilts the camera; a positive value is upwards."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Look {direction}"},
        meaning="Tilts the camera by steps while held; positive is up.",
        options={"step_deg": _TILT, "camera": CAMERA_OPTION},
        sends=("GCM_Camera_Command",),
        words={"": ("up", "down")},
    )
    moves: ClassVar = {"": ("tilt", "step_deg")}


class AdjustPanTilt(_AdjustCamera):
    """Turns and tilts the camera: a hat switch, two axes or four keys."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"pan": "Look {direction}", "tilt": "Look {direction}"},
        meaning=(
            "Turns and tilts the camera by steps while held; positive `pan` is left, positive "
            "`tilt` is up."
        ),
        controls=("pan", "tilt"),
        options={"pan_deg": _PAN, "tilt_deg": _TILT, "camera": CAMERA_OPTION},
        sends=("GCM_Camera_Command",),
        words={"pan": ("left", "right"), "tilt": ("up", "down")},
        plane=("pan", "tilt"),
    )
    moves: ClassVar = {"pan": ("pan", "pan_deg"), "tilt": ("tilt", "tilt_deg")}


class AdjustZoom(_AdjustCamera):
    """Zooms; a positive value is closer."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Zoom {direction}"},
        meaning="Zooms by steps while held; positive is closer.",
        options={
            "step": NumberOption(
                default=0.05, least=0.001, most=1.0, unit="", meaning="change a press, of 0 to 1"
            ),
            "camera": CAMERA_OPTION,
        },
        sends=("GCM_Camera_Command",),
        words={"": ("closer", "wider")},
    )
    moves: ClassVar = {"": ("zoom", "step")}


class HomePTZ(PressWidget):
    """Sends the camera home: straight ahead, wide."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Look straight ahead, wide"},
        meaning="Sends the camera straight ahead, wide.",
        options={"camera": CAMERA_OPTION},
        sends=("GCM_Camera_Command",),
    )

    def press(
        self, _event: ControlEvent, _event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """One command."""
        home = CameraCommand(motion=CameraMotion.HOME, camera=_commanded_camera(self, state))
        return (SendEffect(robot=self.robot, definition=CAMERA_COMMAND, value=home),)


def _commanded_camera(widget: PressWidget, state: ConsoleState) -> str:
    """The camera that a widget moves; empty: the main one."""
    robot, option = state.robot(widget.robot), widget.spec.options.word("camera")
    if robot is None:
        return "" if option == CHOSEN else option
    return camera_of(option, robot, state)
