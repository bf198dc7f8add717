"""A camera that is fixed on its robot: a device, a stream from the network, or a file."""

from __future__ import annotations

from hub.robots.cropping import cropped_fov
from hub.robots.fixed_camera import FixedCamera
from hub.robots.interfaces import Picture
from hub.robots.video_reader import VideoReader
from hub.robots.video_source import video_source


class VideoCamera(FixedCamera):
    """Pictures of a source in the robot file; implements `Camera`."""

    def __init__(
        self,
        source: str,
        *,
        horizontal_fov: float,
        forward: float,
        height: float,
    ) -> None:
        """Start to read, without waiting; an absent source may appear later.

        Args:
            source: Device, path, or address.
            horizontal_fov: Field of view from left to right [rad].
            forward: Ahead of the robot's centre [m].
            height: Above the ground [m].

        Raises:
            CameraError: The source is an address of an unknown kind.
        """
        super().__init__(horizontal_fov=horizontal_fov, forward=forward, height=height)
        self._reader = VideoReader(video_source(source))

    def take(self, width_px: int, height_px: int, _now: float) -> Picture:
        """The newest picture.

        Raises:
            CameraError: There is none, or only an old one.
        """
        shot = self._reader.newest()
        pixels = shot.pixels(width_px, height_px)
        size = pixels.shape[1], pixels.shape[0]
        return Picture(
            pixels=pixels,
            measured=shot.measured,
            horizontal_fov=cropped_fov(self._horizontal_fov, size, shot.size),
        )

    def close(self) -> None:
        """Stop reading."""
        self._reader.close()
