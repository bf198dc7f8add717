"""Widgets that move the camera by steps."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

from hub.gcm.vision import CAMERA_COMMAND, CameraCommand, CameraMotion
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import HandlerRule, NumberOption, Section
from rune_tui.layout.spec import EventSpec
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, SendEffect
from rune_tui.widgets.stepping import SteppingWidget
from rune_tui.widgets.widget import PressWidget


class _AdjustCamera(SteppingWidget):
    """Moves the camera by a step."""

    @abstractmethod
    def command(self, value: float, control: str) -> CameraCommand:
        """The step that an input of this value makes."""

    def step(self, value: float, control: str) -> Effect:
        """One command."""
        command = self.command(value, control)
        return SendEffect(robot=self.robot, definition=CAMERA_COMMAND, value=command)


class AdjustPan(_AdjustCamera):
    """Turns the camera; a positive value means left."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Look {direction}"},
        meaning="Turns the camera by steps while held; positive is left.",
        options={
            "step_deg": NumberOption(
                default=5.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, to the left"
            )
        },
        sends=("GCM_Camera_Command",),
        words={"": ("left", "right")},
    )

    def command(self, value: float, control: str) -> CameraCommand:  # noqa: ARG002 - it has one
        """The option `step_deg` times the value."""
        return CameraCommand(pan=math.radians(self.spec.options.number("step_deg")) * value)


class AdjustTilt(_AdjustCamera):
    """Tilts the camera; a positive value is upwards."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Look {direction}"},
        meaning="Tilts the camera by steps while held; positive is up.",
        options={
            "step_deg": NumberOption(
                default=3.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, upwards"
            )
        },
        sends=("GCM_Camera_Command",),
        words={"": ("up", "down")},
    )

    def command(self, value: float, control: str) -> CameraCommand:  # noqa: ARG002 - it has one
        """The option `step_deg` times the value."""
        return CameraCommand(tilt=math.radians(self.spec.options.number("step_deg")) * value)


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
        options={
            "pan_deg": NumberOption(
                default=5.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, to the left"
            ),
            "tilt_deg": NumberOption(
                default=3.0, least=0.1, most=90.0, unit="deg", meaning="turn a press, upwards"
            ),
        },
        sends=("GCM_Camera_Command",),
        words={"pan": ("left", "right"), "tilt": ("up", "down")},
        plane=("pan", "tilt"),
    )

    def command(self, value: float, control: str) -> CameraCommand:
        """The option of the control times the value."""
        step = math.radians(self.spec.options.number(f"{control}_deg")) * value
        return CameraCommand(pan=step) if control == "pan" else CameraCommand(tilt=step)


class AdjustZoom(_AdjustCamera):
    """Zooms; a positive value is closer."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Zoom {direction}"},
        meaning="Zooms by steps while held; positive is closer.",
        options={
            "step": NumberOption(
                default=0.05, least=0.001, most=1.0, unit="", meaning="change a press, of 0 to 1"
            )
        },
        sends=("GCM_Camera_Command",),
        words={"": ("closer", "wider")},
    )

    def command(self, value: float, control: str) -> CameraCommand:  # noqa: ARG002 - it has one
        """The option `step` times the value."""
        return CameraCommand(zoom=self.spec.options.number("step") * value)


class HomePTZ(PressWidget):
    """Sends the camera home: straight ahead, wide."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Look straight ahead, wide"},
        meaning="Sends the camera straight ahead, wide.",
        sends=("GCM_Camera_Command",),
    )

    def press(
        self,
        event: ControlEvent,  # noqa: ARG002 - home is home
        event_spec: EventSpec,  # noqa: ARG002
        state: ConsoleState,  # noqa: ARG002
    ) -> tuple[Effect, ...]:
        """One command."""
        home = CameraCommand(motion=CameraMotion.HOME)
        return (SendEffect(robot=self.robot, definition=CAMERA_COMMAND, value=home),)
