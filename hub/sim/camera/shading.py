"""Computes the colour of every pixel from its object and its depth."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hub.sim.camera.faces import PLANES, Faces
from hub.sim.camera.lighting import Lighting
from hub.sim.camera.textures import LEVELS
from hub.sim.camera.textures import SIDE as TEXELS
from hub.sim.camera.view import CameraFrame, View

_HAZE = 74.0
"""Grey of very distant objects, 0 to 255."""
_CLEAR = 1.06
_FADE_PER_METRE = 0.055
_LEAST_SHARE = 0.22
"""Share of an object's own colour: CLEAR - FADE * depth, from LEAST_SHARE to 1."""
_GRAZING = 2.5
"""Floors are seen at a grazing angle: a pixel covers this many times more of them than of walls."""
_STEEP = 0.5
"""Sine of the camera's pitch from which on floors are seen less and less at a grazing angle."""
_FOOT_LIGHT = 0.72
_FOOT_SHADE_PER_METRE = 1.1
"""Share of light at the foot of an upright object, and its growth with height."""
_LIGHT_FROM = (0.8, 0.6)
"""Direction of the light on cylinders, in x and y, unit length."""
_FAR_SIDE_LIGHT = 0.62


class Shader:
    """Colours frames of one arena; owns its working memory, so it belongs to one thread."""

    def __init__(self, faces: Faces, ground_light: npt.NDArray[np.float32] | None = None) -> None:
        """Prepare it.

        Args:
            faces: What is drawn.
            ground_light: Share of light of each cell of the height map, as `CameraFrame.cell`
                counts them; None without a height map.
        """
        self._faces = faces
        self._ground_light = ground_light
        self._first_cylinder = PLANES + len(faces.axis)
        fineness = np.abs(faces.column_scale)
        self._texels_per_metre = np.where(faces.flat, _GRAZING * fineness, fineness).astype(
            np.float32
        )

    def shade(
        self, view: View, frame: CameraFrame, lighting: Lighting, *, haze: bool = True
    ) -> npt.NDArray[np.uint8]:
        """The picture of a frame, shape (height, width, 3).

        Args:
            view: The camera.
            frame: Its frame, with all that is drawn.
            lighting: The light.
            haze: Whether the air of the hall makes distant things grey.
        """
        faces = self._faces
        thing = frame.thing
        depth = 1.0 / frame.inverse_depth
        x, y, z = self._points(view, frame, depth)
        across = np.where(faces.across_x[thing], x, y)
        down = np.where(faces.flat[thing], y, z)
        brightness = faces.brightness.take(thing)
        if self._ground_light is not None:
            on_ground = thing >= faces.first_ground
            np.multiply(
                brightness, self._ground_light.take(frame.cell), out=brightness, where=on_ground
            )
        if len(faces.cylinders):
            self._wrap_cylinders(frame, x, y, across, brightness)
        # Little light reaches the foot of a wall; z is not needed any more.
        z *= _FOOT_SHADE_PER_METRE
        z += _FOOT_LIGHT
        brightness *= np.clip(z, _FOOT_LIGHT, 1.0, out=z)
        texel = self._texels(frame, depth, across, down)
        if not lighting.plain:
            brightness *= lighting.share(frame, depth)

        grey = None
        if haze:
            depth *= -_FADE_PER_METRE
            depth += _CLEAR
            share = np.clip(depth, _LEAST_SHARE, 1.0, out=depth)
            grey = ((1.0 - share) * (_HAZE * 256.0 * lighting.ambient)).astype(np.uint16)
            share *= brightness
        else:
            share = brightness
        share *= 256.0
        light = share.astype(np.uint16)
        picture = np.empty((frame.height, frame.width, 3), dtype=np.uint8)
        for channel, plane in enumerate(faces.atlas.planes):
            colour = plane.take(texel)
            # At most 255 * 256: brightness above 1 is clipped where it would not fit.
            shaded = _saturating_product(colour, light, grey)
            np.right_shift(shaded, 8, out=picture[..., channel], casting="unsafe")
        return picture

    def _points(
        self, view: View, frame: CameraFrame, depth: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """The points of all pixels in the arena's frame [m], each of shape (height, width)."""
        x = frame.ray_x * depth
        x += np.float32(view.x)
        y = frame.ray_y * depth
        y += np.float32(view.y)
        z = frame.ray_z.astype(np.float32, copy=False) * depth
        z += np.float32(view.z)
        return x, y, z

    def _wrap_cylinders(
        self,
        frame: CameraFrame,
        x: npt.NDArray[np.float32],
        y: npt.NDArray[np.float32],
        across: npt.NDArray[np.float32],
        brightness: npt.NDArray[np.float32],
    ) -> None:
        """Measure textures around cylinders, and light the side that faces the light."""
        thing = frame.thing
        where = np.nonzero((thing >= self._first_cylinder) & (thing < self._faces.first_ground))
        if not len(where[0]):
            return
        centre_x, centre_y, radius = self._faces.cylinders[
            thing[where] - self._first_cylinder, :3
        ].T
        from_x, from_y = x[where] - centre_x, y[where] - centre_y
        across[where] = np.arctan2(from_y, from_x) * radius
        lit = (from_x * _LIGHT_FROM[0] + from_y * _LIGHT_FROM[1]) / radius
        middle = (1.0 + _FAR_SIDE_LIGHT) / 2
        brightness[where] = middle + (1.0 - middle) * lit

    def _texels(
        self,
        frame: CameraFrame,
        depth: npt.NDArray[np.float32],
        across: npt.NDArray[np.float32],
        down: npt.NDArray[np.float32],
    ) -> npt.NDArray[np.intp]:
        """Index into the atlas for each pixel, shape (height, width)."""
        faces, thing = self._faces, frame.thing
        across *= faces.column_scale.take(thing)
        across += faces.column_offset.take(thing)
        down *= faces.row_scale.take(thing)
        down += faces.row_offset.take(thing)
        column = across.astype(np.int32)
        column &= TEXELS - 1
        row = down.astype(np.int32)
        row &= TEXELS - 1
        texels_per_pixel = self._fineness(frame).take(thing)
        texels_per_pixel *= depth
        # A level is taken from half again as many texels as fit it without smoothing.
        texels_per_pixel *= np.float32(1.0 / (1.5 * frame.focal))
        level = np.zeros(thing.shape, dtype=np.int32)
        for number in range(LEVELS - 1):
            level += texels_per_pixel > float(1 << number)
        level *= TEXELS
        level += row
        level *= TEXELS
        level += column
        level += faces.first_texel.take(thing)
        return level.astype(np.intp)

    def _fineness(self, frame: CameraFrame) -> npt.NDArray[np.float32]:
        """Texels of each thing that a pixel covers at a depth of 1 m, times the focal length."""
        steepness = max(0.0, abs(float(frame.basis[2, 2])) - _STEEP) / (1.0 - _STEEP)
        if steepness == 0.0:
            return self._texels_per_metre
        less = np.float32(1.0 - steepness * (1.0 - 1.0 / _GRAZING))
        return np.where(self._faces.flat, self._texels_per_metre * less, self._texels_per_metre)


def _saturating_product(
    colour: npt.NDArray[np.uint16],
    light: npt.NDArray[np.uint16],
    grey: npt.NDArray[np.uint16] | None,
) -> npt.NDArray[np.uint16]:
    """`colour * light + grey`, at most 65535; None: no grey."""
    total = colour.astype(np.uint32)
    total *= light
    if grey is not None:
        total += grey
    return np.minimum(total, 65535, out=total).astype(np.uint16)
