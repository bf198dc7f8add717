"""What fewer colours cost and save: mapping a frame to 256, 16 or none, and bytes; 160 x 48 cells.

The frames are those of `camera_scenes.py`.
"""

from __future__ import annotations

import numpy as np

from benchmarks.camera_scenes import COLUMNS, FRAMES, ROWS, panning
from benchmarks.figures import median_ms, report, say
from rune_tui.compositor.colours import at_depth
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.screen_encoder import ScreenEncoder

BAR_MS = 2.0
RUNS = 300


def main() -> None:
    frames = panning()
    say(f"{COLUMNS} x {ROWS} cells, {RUNS} frames of a panning camera")
    for depth in ColourDepth:
        if depth is ColourDepth.TRUECOLOUR:
            continue
        mapped = [at_depth(cells, depth) for cells in frames]
        mapping = median_ms(
            lambda index, depth=depth: at_depth(frames[index % FRAMES], depth), RUNS
        )
        encoder = ScreenEncoder()
        coding = median_ms(
            lambda index, encoder=encoder, mapped=mapped: encoder.encode(mapped[index % FRAMES]),
            RUNS,
        )
        kilobytes = np.mean([len(ScreenEncoder().encode(cells)) for cells in mapped]) / 1e3
        note = f"and {coding:.2f} ms to {kilobytes:.0f} kB a frame"
        report(f"terminal.map_to_{depth.value}_ms", mapping, "ms", bar=BAR_MS, note=note)


if __name__ == "__main__":
    main()
