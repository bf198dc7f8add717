"""visualizeTiltData: where the camera looks, up to the top."""

from __future__ import annotations

from typing import ClassVar

from hub.gcm.vision import CameraState
from rune_tui.layout.rules import VisualizerRule
from rune_tui.visualizers.parts.angle_bar import AngleBar, Direction


class TiltData(AngleBar):
    """A bar centred on the tilt, as long as the field of view, against a centre line."""

    rule: ClassVar = VisualizerRule(
        meaning="the same, up and down",
        message="GCM_CameraState",
    )
    direction = Direction.UPWARD

    @staticmethod
    def reading(camera: CameraState) -> tuple[float, float, float]:
        """Tilt, field of view and largest tilt [rad]."""
        return camera.tilt, camera.vertical_fov, camera.tilt_limit
