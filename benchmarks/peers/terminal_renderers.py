"""Libraries of others that draw pictures in terminals, each asked for one frame at a time.

Runs in the peers' own environment, and without a terminal of its own, which they would ask.
Standard input has a line a frame, "RENDERER SCENE NUMBER"; standard output first a line with what
is here and why the others are not, then a line for each, "CPU-MILLISECONDS BYTES". Scenes are files
of RGB frames beside one another.
"""

from __future__ import annotations

import ctypes
import io
import json
import os
import sys
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

Draw = Callable[[Any], str | bytes | int]
"""Draws a picture, and gives the bytes to the terminal, or their number."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Renderer:
    """One that takes part.

    Attributes:
        version: Its own.
        draw: What is measured.
        prepared: Makes of Pillow's picture, which others take, what it draws.
    """

    version: str
    draw: Draw
    prepared: Callable[[Any], Any] = lambda picture: picture


def main() -> None:
    folder, columns, rows = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    # What a terminal would tell; libraries ask for it when they are imported.
    os.environ |= {"COLORTERM": "truecolor", "TERM": "xterm-256color", "LC_ALL": "C.UTF-8"}
    warnings.simplefilter("ignore")
    requests, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)  # notcurses reads keys from there
    renderers: dict[str, Renderer] = {}
    missing: dict[str, str] = {}
    for name, begin in RENDERERS.items():
        try:
            begun = begin(columns, rows)
        except (ImportError, AttributeError, OSError) as error:
            missing[name] = f"{type(error).__name__}: {error}"
        else:
            if not isinstance(begun, Renderer):
                begun = Renderer(version=version(name), draw=begun)
            renderers[name] = begun
    versions = {name: renderer.version for name, renderer in renderers.items()}
    print(json.dumps({"versions": versions, "missing": missing}), file=answers)
    for line in requests:
        name, scene, number = line.split()
        renderer = renderers[name]
        frame = renderer.prepared(picture(folder / scene, int(number), columns, rows))
        start = time.process_time()
        drawn = renderer.draw(frame)
        spent = time.process_time() - start
        drawn = drawn.encode() if isinstance(drawn, str) else drawn
        length = drawn if isinstance(drawn, int) else len(drawn)
        print(spent * 1e3, length, file=answers)


def picture(path: Path, number: int, columns: int, rows: int) -> Any:
    from PIL import Image

    size = 6 * columns * rows
    data = path.read_bytes()[number * size : (number + 1) * size]
    return Image.frombytes("RGB", (columns, 2 * rows), data)


def rich_console(columns: int, rows: int) -> Any:
    from rich.console import Console

    return Console(
        file=io.StringIO(),
        force_terminal=True,
        color_system="truecolor",
        width=columns,
        height=rows,
        legacy_windows=False,
    )


def rich_pixels(columns: int, rows: int) -> Draw:
    from rich_pixels import Pixels

    def draw(frame: Any) -> str:
        console = rich_console(columns, rows)
        console.print(Pixels.from_image(frame))
        return console.file.getvalue()

    return draw


def textual_image(columns: int, rows: int) -> Draw:
    import textual_image._terminal as terminal

    # There is no terminal to ask.
    terminal.get_cell_size._result = terminal.CellSize(8, 16)  # noqa: SLF001 - no public way
    from textual_image.renderable.halfcell import Image

    def draw(frame: Any) -> str:
        console = rich_console(columns, rows)
        console.print(Image(frame, width=columns, height=rows))
        return console.file.getvalue()

    return draw


def term_image(columns: int, rows: int) -> Draw:
    from term_image.image import BlockImage

    BlockImage._supported = True  # noqa: SLF001 - there is no terminal to ask

    def draw(frame: Any) -> str:
        shown = BlockImage(frame)
        shown._size = (columns, rows)  # noqa: SLF001 - as above
        return shown._renderer(shown._render_image, None)  # noqa: SLF001 - as above

    return draw


def chafa(columns: int, rows: int) -> Draw:
    """Half blocks alone and the least of work: nothing is compared but these."""
    from chafa import (
        Canvas,
        CanvasConfig,
        CanvasMode,
        PixelMode,
        PixelType,
        SymbolMap,
        SymbolTags,
        TermDb,
    )

    config = CanvasConfig()
    config.height, config.width = rows, columns
    config.pixel_mode = PixelMode.CHAFA_PIXEL_MODE_SYMBOLS
    config.canvas_mode = CanvasMode.CHAFA_CANVAS_MODE_TRUECOLOR
    symbols = SymbolMap()
    symbols.add_by_tags(SymbolTags.CHAFA_SYMBOL_TAG_VHALF)
    config.set_symbol_map(symbols)
    config.work_factor = 0.0
    canvas = Canvas(config)
    terminal = TermDb().get_fallback_info()

    def draw(frame: Any) -> bytes:
        width, height = frame.size
        data = frame.tobytes()
        pixels = (ctypes.c_uint8 * len(data)).from_buffer_copy(data)
        canvas.draw_all_pixels(PixelType.CHAFA_PIXEL_RGB8, pixels, width, height, 3 * width)
        return canvas.print(terminal)

    return draw


def notcurses(columns: int, rows: int) -> Renderer:
    from benchmarks.peers.notcurses import Notcurses

    screen = Notcurses(columns, rows)
    return Renderer(
        version=screen.version,
        draw=screen.draw,
        prepared=lambda picture: picture.convert("RGBA").tobytes(),
    )


RENDERERS: dict[str, Callable[[int, int], Draw | Renderer]] = {
    "rich-pixels": rich_pixels,
    "textual-image": textual_image,
    "term-image": term_image,
    "chafa.py": chafa,
    "notcurses": notcurses,
}

if __name__ == "__main__":
    main()
