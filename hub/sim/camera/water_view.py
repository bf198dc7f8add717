"""What water does to a picture: less light reaches the camera, and scattered light is added.

After Akkaynak and Treibitz 2018, "A Revised Underwater Image Formation Model". Of a colour J at a
range r, a camera sees `J (L + lamp) exp(-direct r) + backscatter (1 - exp(-back r))`. L is the
daylight at the depth of the thing. Light is not refracted. All of it is taken from tables by range
and by depth, so a picture costs a few look-ups a pixel.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from hub.sim.arena_specs import WATER_TYPES, Area, WaterSpec
from hub.sim.camera.lighting import FULL, Lighting
from hub.sim.camera.shading import Shader
from hub.sim.camera.view import CameraFrame, View
from hub.values import dataclass

_CONTRAST = 3.9
"""-log of 2 %, the contrast below which a thing is not seen."""
_BACK = (1.10, 0.95, 0.90)
"""Growth of backscatter relative to the loss of things' light, red, green, blue; our choice."""
_SCATTERED_SHARE = 0.55
"""Share of the light lost on its way that is scattered, not swallowed; our choice."""
_BACKSCATTER = 158.0
"""Brightest value of the backscatter at the surface, 0 to 255; our choice."""
_LAMP = 3.0
"""Light of the full lamp at no distance, as a share of full daylight."""
_HALF_DISTANCE = 0.9
"""Distance at which half of the lamp's light is left in clear water [m]."""
_BEAM = 0.45
"""Squared tangent from the middle of the beam at which half of the light is left."""
_GLOW = (23.0, 26.0, 26.0)
"""Brightest value of the lamp's glow in the water before the camera, red, green, blue."""
_FARTHEST = 30.0
_VISIBILITIES = 2.2
"""Ranges are in the tables up to the visibility times this; nothing is left of light beyond."""
_RANGES = 1024
_DEPTHS = 256
_WINDOW = (0.60, 0.72)
"""Cosines from the vertical between which the surface, from below, turns from mirror to window."""
_SKY = (206.0, 226.0, 232.0)
"""The surface, where light falls through it from above."""
_REFLECTED_AHEAD = 0.02
_REFLECTED_GRAZING = 0.6
"""Share of light that the surface reflects from above, straight down and at a grazing angle."""
_REFLECTION = (150.0, 160.0, 168.0)
_RIPPLES = 0.08
_LEAST = np.float32(1e-6)
_EVERYWHERE: Area = ((-math.inf, -math.inf), (math.inf, math.inf))

_Floats = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Tables:
    """Light by range and by depth under water, red, green and blue.

    Attributes:
        direct: Loss of a thing's light [1/m], shape (3,).
        back: Growth of backscatter [1/m], shape (3,).
        daylight: Loss of daylight with depth [1/m], shape (3,).
        brightest: Backscatter of an endless range at the surface, 0 to 255, shape (3,).
        passed: Share of light that is left after a range, shape (3, ranges).
        backscatter: Scattered daylight that a range adds at the surface, shape (3, ranges).
        lit: Share of full light that the lamp gives at a range, both ways, shape (3, ranges).
        glow: The lamp's glow that a range adds, shape (3, ranges).
        day: Share of daylight that is left at a depth, shape (3, depths).
        steps_per_metre: Of range.
        depth_steps_per_metre: Of depth.
    """

    direct: _Floats
    back: _Floats
    daylight: _Floats
    brightest: _Floats
    passed: _Floats
    backscatter: _Floats
    lit: _Floats
    glow: _Floats
    day: _Floats
    steps_per_metre: float
    depth_steps_per_metre: float


def _tables(water: WaterSpec) -> _Tables:
    daylight = np.array(WATER_TYPES[water.type])
    lost = _CONTRAST / water.visibility
    # The loss of daylight is no loss of contrast: the visibility says what is lost besides.
    direct = daylight + max(0.0, lost - float(daylight[1]))
    back = direct * _BACK
    backscatter = _SCATTERED_SHARE * lost / (1.6 * daylight + 0.25 * lost)
    backscatter *= _BACKSCATTER / backscatter.max()
    farthest = min(_FARTHEST, _VISIBILITIES * water.visibility)
    ranges = (np.arange(_RANGES) + 0.5) * farthest / _RANGES
    depths = (np.arange(_DEPTHS) + 0.5) * water.surface / _DEPTHS
    passed = np.exp(-np.outer(direct, ranges))
    reached = 1.0 - np.exp(-np.outer(back, ranges))
    glow = np.array(_GLOW)[:, None] * (1.0 - np.exp(-2.0 * np.outer(back, ranges)))
    return _Tables(
        direct=direct.astype(np.float32),
        back=back.astype(np.float32),
        daylight=daylight.astype(np.float32),
        brightest=backscatter.astype(np.float32),
        passed=passed.astype(np.float32),
        backscatter=(backscatter[:, None] * reached).astype(np.float32),
        lit=(_LAMP * passed**2 / (1.0 + (ranges / _HALF_DISTANCE) ** 2)).astype(np.float32),
        glow=glow.astype(np.float32),
        day=np.exp(-np.outer(daylight, depths)).astype(np.float32),
        steps_per_metre=_RANGES / farthest,
        depth_steps_per_metre=_DEPTHS / water.surface,
    )


class WaterView:
    """Draws pictures of an arena with water in it."""

    def __init__(self, water: WaterSpec) -> None:
        self._water = water
        self._tables = _tables(water)

    def picture(
        self, view: View, frame: CameraFrame, shader: Shader, lighting: Lighting
    ) -> npt.NDArray[np.uint8]:
        """The picture of a frame, shape (height, width, 3)."""
        if view.z < self._water.surface and _within(self._water.area, view.x, view.y):
            clear = shader.shade(view, frame, FULL, haze=False)
            return self._from_inside(view, frame, clear, lighting)
        picture = shader.shade(view, frame, lighting)
        if view.z > self._water.surface:
            self._from_above(view, frame, picture, lighting)
        return picture

    def _from_inside(
        self,
        view: View,
        frame: CameraFrame,
        picture: npt.NDArray[np.uint8],
        lighting: Lighting,
    ) -> npt.NDArray[np.uint8]:
        """Change a picture taken in clear air to what a camera in the water takes."""
        tables = self._tables
        rise = np.float32(self._water.surface - view.z)
        ray_z = frame.ray_z.astype(np.float32, copy=False)
        # Rays that go up leave the water, unless they meet something before.
        to_surface = ray_z * np.float32(1.0 / rise)
        above = to_surface > frame.inverse_depth
        depth = np.float32(1.0) / np.maximum(frame.inverse_depth, to_surface)
        if above.any():
            self._draw_surface(view, frame, picture, above)
        deep = depth * (ray_z * np.float32(-tables.depth_steps_per_metre))
        deep += rise * np.float32(tables.depth_steps_per_metre)
        day_at = deep.astype(np.intp)
        depth *= frame.length
        depth *= np.float32(tables.steps_per_metre)
        at = depth.astype(np.intp)
        ambient = np.float32(lighting.ambient)
        lamp = np.float32(lighting.headlight)
        if lamp:
            beam = np.float32(_BEAM) / (frame.length * frame.length + np.float32(_BEAM - 1.0))
        here = self._daylight(view) * ambient
        for channel in range(3):
            plane = picture[..., channel]
            light = tables.passed[channel].take(at, mode="clip")
            light *= (tables.day[channel] * ambient).take(day_at, mode="clip")
            if lamp:
                light += (tables.lit[channel] * lamp).take(at, mode="clip") * beam
            light *= plane
            backscatter = tables.backscatter[channel] * here[channel]
            if lamp:
                light += (tables.glow[channel] * lamp).take(at, mode="clip") * beam
            light += backscatter.take(at, mode="clip")
            if lamp:  # without, no value is greater than the thing's own
                np.minimum(light, 255.0, out=light)
            np.copyto(plane, light, casting="unsafe")
        return picture

    def _daylight(self, view: View) -> _Floats:
        """Share of daylight at the camera's depth, shape (3,)."""
        depth = self._water.surface - view.z
        step = int(depth * self._tables.depth_steps_per_metre)
        return self._tables.day[:, min(step, _DEPTHS - 1)]

    def _draw_surface(
        self,
        view: View,
        frame: CameraFrame,
        picture: npt.NDArray[np.uint8],
        above: npt.NDArray[np.bool_],
    ) -> None:
        """Draw the surface from below: a bright window overhead, a mirror around it."""
        pixels = np.flatnonzero(above)
        ray_z = np.broadcast_to(frame.ray_z, above.shape).take(pixels).astype(np.float32)
        way = np.float32(self._water.surface - view.z) / ray_z
        x = np.float32(view.x) + frame.ray_x.take(pixels) * way
        y = np.float32(view.y) + frame.ray_y.take(pixels) * way
        ripple = _ripple(x, y)
        low, high = _WINDOW
        window = (ray_z / frame.length.take(pixels) + ripple - low) / (high - low)
        window = np.clip(window, 0.0, 1.0)
        flat = picture.reshape(-1, 3)
        for channel, dark in enumerate(self._tables.backscatter[:, -1].tolist()):
            seen = window * np.float32(_SKY[channel] - dark)
            seen += np.float32(dark)
            seen *= 1.0 + ripple
            flat[pixels, channel] = np.minimum(seen, 255.0)

    def _from_above(
        self,
        view: View,
        frame: CameraFrame,
        picture: npt.NDArray[np.uint8],
        lighting: Lighting,
    ) -> None:
        """Draw the water over the picture that a camera above its surface takes."""
        drop = np.float32(view.z - self._water.surface)
        # Rays that do not go down meet no water; they only must not divide by 0.
        down = np.maximum(-frame.ray_z, _LEAST).astype(np.float32, copy=False)
        way = drop / down
        inverse_depth = np.maximum(frame.inverse_depth, _LEAST)
        wet = way * inverse_depth < 1.0
        wet &= frame.ray_z < 0.0
        if not wet.any():
            return
        x = np.float32(view.x) + frame.ray_x * way
        y = np.float32(view.y) + frame.ray_y * way
        if self._water.area is not None:
            wet &= _within(self._water.area, x, y)
        under = np.float32(1.0) / inverse_depth
        under -= way
        np.maximum(under, 0.0, out=under)
        ranges = under * frame.length
        depths = under * down
        aslant = np.float32(1.0) - down / frame.length
        aslant -= _ripple(x, y)
        np.maximum(aslant, 0.0, out=aslant)
        reflected = aslant * aslant * aslant
        reflected *= np.float32(_REFLECTED_GRAZING - _REFLECTED_AHEAD)
        reflected += np.float32(_REFLECTED_AHEAD)
        ambient = np.float32(lighting.ambient)
        tables = self._tables
        for channel in range(3):
            plane = picture[..., channel]
            seen = np.exp(ranges * -tables.direct[channel] - depths * tables.daylight[channel])
            seen *= plane
            scattered = np.exp(ranges * -tables.back[channel])
            scattered *= -tables.brightest[channel] * ambient
            scattered += tables.brightest[channel] * ambient
            seen += scattered
            seen += reflected * (np.float32(_REFLECTION[channel]) * ambient - seen)
            np.copyto(plane, seen, where=wet, casting="unsafe")


def _ripple(x: _Floats, y: _Floats) -> _Floats:
    """Waves of the surface at places [m], between -RIPPLES and RIPPLES; they stand still."""
    waves: _Floats = np.sin(9.0 * x + 2.0 * np.sin(5.0 * y))
    waves *= np.float32(_RIPPLES)
    return waves


def _within(
    area: Area | None, x: float | _Floats, y: float | _Floats
) -> npt.NDArray[np.bool_] | np.bool_:
    """Whether points are within the area, seen from above; None: everywhere."""
    (west, south), (east, north) = area or _EVERYWHERE
    x, y = np.asarray(x), np.asarray(y)
    return (x >= west) & (x <= east) & (y >= south) & (y <= north)
