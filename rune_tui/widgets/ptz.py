"""Widgets that move the camera, one step for each press and repeat."""

from __future__ import annotations

import math
from abc import abstractmethod

from hub.gcm.vision import CAMERA_COMMAND, CameraCommand, CameraMotion
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.names import HANDLERS
from rune_tui.layout.spec import EventSpec
from rune_tui.model.effects import Effect, SendEffect
from rune_tui.widgets.widget import PressWidget


class _AdjustCamera(PressWidget):
    """Moves the camera by a step."""

    @abstractmethod
    def command(self, value: float) -> CameraCommand:
        """The step that an event of this value makes."""

    def press(self, event: ControlEvent, event_spec: EventSpec) -> tuple[Effect, ...]:  # noqa: ARG002 - a repeat is one more step
        """One step."""
        value = self.command(event_spec.value)
        return (SendEffect(robot=self.robot, definition=CAMERA_COMMAND, value=value),)

    def _option(self, name: str) -> float:
        return self.spec.option(name, HANDLERS[self.spec.handler].options[name].default)


class AdjustPan(_AdjustCamera):
    """Turns the camera; a positive value is to the left."""

    def command(self, value: float) -> CameraCommand:
        """The option `step_deg` times the value."""
        return CameraCommand(pan=math.radians(self._option("step_deg")) * value)


class AdjustTilt(_AdjustCamera):
    """Tilts the camera; a positive value is upwards."""

    def command(self, value: float) -> CameraCommand:
        """The option `step_deg` times the value."""
        return CameraCommand(tilt=math.radians(self._option("step_deg")) * value)


class AdjustZoom(_AdjustCamera):
    """Zooms; a positive value is closer."""

    def command(self, value: float) -> CameraCommand:
        """The option `step` times the value."""
        return CameraCommand(zoom=self._option("step") * value)


class HomePTZ(PressWidget):
    """Sends the camera home: straight ahead, wide."""

    def press(self, event: ControlEvent, event_spec: EventSpec) -> tuple[Effect, ...]:  # noqa: ARG002 - home is home
        """One command; a repeat adds nothing."""
        if event.repeat:
            return ()
        home = CameraCommand(motion=CameraMotion.HOME)
        return (SendEffect(robot=self.robot, definition=CAMERA_COMMAND, value=home),)
