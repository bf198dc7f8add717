"""What a robot's camera sees, made up: sequences of frames as cells of 160 x 48.

A scene is textured like nature is (amplitude falls with frequency), with sky, ground and rubble.
"""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np
from PIL import Image

from rune_tui.compositor.blend import Layer, compose
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.seen_pictures import SeenPicture, seen_pictures
from rune_tui.raster.canvas import Canvas

COLUMNS, ROWS, FRAMES = 160, 48, 30
_WIDTH, _HEIGHT = 320, 240
_STEP = 7


def panning() -> list[Cells]:
    """The camera pans by 7 of 320 pixels a frame and has noise: nearly all cells change."""
    return [seen(frame) for frame in panning_frames()]


def panning_frames() -> list[np.ndarray]:
    """The same as the camera takes them, shape (240, 320, 3)."""
    random = np.random.default_rng(2005)
    return list(_panned(_rubble(random), random, noise=2.0))


def photo() -> list[Cells]:
    """The same over objects of all sizes that cover one another, as a close photograph has."""
    return [seen(frame) for frame in photo_frames()]


def photo_frames() -> list[np.ndarray]:
    """The same as the camera takes them, shape (240, 320, 3)."""
    random = np.random.default_rng(2006)
    return list(_panned(_leaves(random), random, noise=1.0))


def static() -> list[Cells]:
    """A fixed camera without noise; a person walks by."""
    return [seen(frame) for frame in _walk(np.random.default_rng(2005), noise=0.0)]


def fixed() -> list[Cells]:
    """The same as cameras send it: with noise, and as JPEG."""
    return [seen(frame) for frame in fixed_frames()]


def fixed_frames() -> list[np.ndarray]:
    """The same as the camera sends them, shape (240, 320, 3)."""
    return [_jpeg(frame) for frame in _walk(np.random.default_rng(2005), noise=2.0)]


def seen(frame: np.ndarray) -> Cells:
    """A picture of shape (h, w, 3) without any text over it, as large as the view."""
    pixels = np.zeros((2 * ROWS, COLUMNS, 4), np.uint8)
    small = Image.fromarray(frame).resize((COLUMNS, 2 * ROWS), Image.Resampling.BOX)
    pixels[..., :3] = np.asarray(small)
    return Cells(
        pixels=pixels,
        glyphs=np.zeros((ROWS, COLUMNS), np.uint32),
        ink=np.zeros((ROWS, COLUMNS, 4), np.uint8),
    )


def seen_in_quadrants(frame: np.ndarray) -> tuple[Cells, tuple[SeenPicture, ...]]:
    """The same for a terminal that shows quadrants."""
    canvas = Canvas.blank(COLUMNS, 2 * ROWS, scale=(2, 1))
    canvas.place_picture(frame, 0, 0, (COLUMNS, 2 * ROWS))
    layers = [Layer(canvas=canvas, x=0, y=0)]
    cells = compose(COLUMNS, ROWS, (0, 0, 0), layers)
    return cells, seen_pictures(cells, layers)


def _panned(world: np.ndarray, random: np.random.Generator, noise: float) -> Iterator[np.ndarray]:
    for index in range(FRAMES):
        frame = world[:, _STEP * index : _STEP * index + _WIDTH]
        yield _bytes(frame + random.normal(0.0, noise, frame.shape))


def _walk(random: np.random.Generator, noise: float) -> Iterator[np.ndarray]:
    base = _rubble(random)[:, 200 : 200 + _WIDTH]
    down, across = np.mgrid[0:_HEIGHT, 0:_WIDTH]
    for index in range(FRAMES):
        frame = base.copy()
        x, y = 40 + 3 * index, 140 + 4 * np.sin(index / 3)
        person = ((across - x) / 14) ** 2 + ((down - y) / 38) ** 2 < 1
        frame[person] = (200, 60, 50) * (0.8 + 0.3 * np.sin(down[person] / 9.0))[:, None]
        yield _bytes(frame + random.normal(0.0, noise, frame.shape))


def _rubble(random: np.random.Generator, width: int = 800) -> np.ndarray:
    """Shape (240, width, 3)."""
    y = np.linspace(0, 1, _HEIGHT)[:, None]
    high = (y < 0.45)[..., None]
    sky = np.stack([120 + 60 * y, 150 + 60 * y, 215 + 20 * y], -1)
    ground = np.stack([110 - 30 * y, 95 - 20 * y, 70 - 10 * y], -1)
    texture = _texture(random, width)[..., None]
    world = np.where(high, sky, ground) + texture * np.where(high, 10, 26)
    for _ in range(28):
        wide, tall = random.integers(12, 90), random.integers(10, 110)
        left = random.integers(0, width - wide)
        bottom = random.integers(_HEIGHT // 2, _HEIGHT)
        top = max(0, bottom - tall)
        box = slice(top, bottom), slice(left, left + wide)
        shade = np.linspace(1.1, 0.7, wide)[None, :, None]
        world[box] = random.integers(30, 220, 3) * shade + texture[box] * 14
    return world


def _texture(random: np.random.Generator, width: int) -> np.ndarray:
    distance = np.hypot(np.fft.fftfreq(_HEIGHT)[:, None], np.fft.rfftfreq(width)[None])
    distance[0, 0] = 1.0
    waves = random.normal(size=distance.shape) + 1j * random.normal(size=distance.shape)
    waves /= distance**1.3
    waves[0, 0] = 0.0
    texture = np.fft.irfft2(waves, (_HEIGHT, width))
    return texture / texture.std()


def _leaves(random: np.random.Generator, width: int = 600) -> np.ndarray:
    """Discs of all sizes over one another: the statistics of photographs (Lee et al., 2001)."""
    world = np.zeros((_HEIGHT, width, 3))
    texture = _texture(random, width)[..., None]
    down, across = np.mgrid[0:_HEIGHT, 0:width]
    for _ in range(1500):
        radius = 4.0 / np.sqrt(random.uniform(0.002, 1.0))
        x, y = random.uniform(0, width), random.uniform(0, _HEIGHT)
        disc = (across - x) ** 2 + (down - y) ** 2 < radius**2
        light = 1.0 + (x - across[disc])[:, None] / radius * 0.2
        colour = random.uniform(60, 180) + random.normal(0.0, 25.0, 3)
        world[disc] = colour * light + texture[disc] * random.uniform(2, 16)
    return world


def _jpeg(frame: np.ndarray) -> np.ndarray:
    file = io.BytesIO()
    Image.fromarray(frame).save(file, "JPEG", quality=60)
    return np.asarray(Image.open(file).convert("RGB"))


def _bytes(frame: np.ndarray) -> np.ndarray:
    return np.clip(frame, 0, 255).astype(np.uint8)
