"""How fast a frame becomes terminal bytes, exactly; 160 x 48 cells.

A synthetic camera pans over a textured scene with sensor noise, 7 pixels a frame, so nearly every
cell differs from its neighbour and from the frame before: the worst case for an exact encoder.
"""

from __future__ import annotations

import numpy as np

from benchmarks.figures import median_ms, report, say
from rune_tui.compositor.ansi import RowEncoder
from rune_tui.compositor.cells import Cells

COLUMNS, ROWS, FRAMES, RUNS = 160, 48, 30, 300
BAR_MS = 0.9


def panning() -> list[Cells]:
    random = np.random.default_rng(2005)
    height, width = 2 * ROWS, COLUMNS + 7 * FRAMES
    rows, columns = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None]
    distance = np.hypot(rows, columns)
    distance[0, 0] = 1.0
    spectrum = random.normal(size=(*distance.shape, 2)) @ (1.0, 1.0j) / distance**1.3
    texture = np.fft.irfft2(spectrum, (height, width))
    scene = 120.0 + 26.0 * (texture / texture.std())[..., None] + np.array([-10.0, 0.0, 20.0])
    frames = []
    for index in range(FRAMES):
        seen = scene[:, 7 * index : 7 * index + COLUMNS]
        pixels = np.zeros((height, COLUMNS, 4), np.uint8)
        pixels[..., :3] = np.clip(seen + random.normal(0.0, 2.0, seen.shape), 0, 255)
        frames.append(without_text(pixels))
    return frames


def without_text(pixels: np.ndarray) -> Cells:
    rows, columns = pixels.shape[0] // 2, pixels.shape[1]
    return Cells(
        pixels=pixels,
        glyphs=np.zeros((rows, columns), np.uint32),
        ink=np.zeros((rows, columns, 4), np.uint8),
    )


def plain_python(cells: Cells) -> list[str]:
    """The same rows as one writes them first: a loop over cells with f-strings."""
    lines = []
    for upper, lower in zip(cells.pixels[0::2].tolist(), cells.pixels[1::2].tolist(), strict=True):
        parts = [
            f"\x1b[38;2;{a[0]};{a[1]};{a[2]};48;2;{b[0]};{b[1]};{b[2]}m▀"
            for a, b in zip(upper, lower, strict=True)
        ]
        lines.append("".join(parts) + "\x1b[0m")
    return lines


def main() -> None:
    frames = panning()
    encoder = RowEncoder()
    say(f"{COLUMNS} x {ROWS} cells, {RUNS} frames of a panning camera")
    exact = median_ms(lambda index: encoder.encode(frames[index % FRAMES]), RUNS, warmup=30)
    plain = median_ms(lambda index: plain_python(frames[index % FRAMES]), FRAMES)
    kilobytes = np.mean([sum(map(len, encoder.encode(cells))) for cells in frames]) / 1e3
    report(
        "terminal.exact_ms",
        exact,
        "ms",
        bar=BAR_MS,
        peers={"f-strings (Python)": round(plain, 3)},
        note=f"{kilobytes:.0f} kB a frame; nothing is left out but what the terminal has in force",
    )


if __name__ == "__main__":
    main()
