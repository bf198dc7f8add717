"""visualizePanData: where the camera looks, left to the left."""

from __future__ import annotations

from hub.gcm.vision import CameraState
from rune_tui.visualizers.angle_bar import AngleBar, Direction


class PanData(AngleBar):
    """A bar centred on the pan, as long as the field of view, against a centre line."""

    direction = Direction.ACROSS

    @staticmethod
    def reading(camera: CameraState) -> tuple[float, float, float]:
        """Pan, field of view and largest pan [rad]."""
        return camera.pan, camera.horizontal_fov, camera.pan_limit
