"""visualizePanData: where the camera looks, left to the left."""

from __future__ import annotations

from typing import ClassVar

from hub.gcm.vision import CameraState
from rune_tui.layout.rules import VisualizerRule
from rune_tui.visualizers.parts.angle_bar import AngleBar, Direction


class PanData(AngleBar):
    """A bar centred on the pan, as long as the field of view, against a centre line."""

    rule: ClassVar = VisualizerRule(
        meaning="where the camera looks from left to right, as a bar as wide as its field of view",
        message="GCM_CameraState",
    )
    direction = Direction.ACROSS

    @staticmethod
    def reading(camera: CameraState) -> tuple[float, float, float]:
        """Pan, field of view and largest pan [rad]."""
        return camera.pan, camera.horizontal_fov, camera.pan_limit
