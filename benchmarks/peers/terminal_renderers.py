"""Libraries of others that draw pictures in terminals, each asked for one frame at a time.

Runs in the peers' own environment. Standard input has a line a frame, "RENDERER SCENE NUMBER";
standard output first a line with what is here and why the others are not, then a line for each,
"CPU-MILLISECONDS BYTES". Scenes are files of RGB frames beside one another.
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
from importlib.metadata import version
from pathlib import Path
from typing import Any

Draw = Callable[[Any], str | bytes]


def main() -> None:
    folder, columns, rows = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    # What a terminal would tell; libraries ask for it when they are imported.
    os.environ |= {"COLORTERM": "truecolor", "TERM": "xterm-256color", "LC_ALL": "C.UTF-8"}
    warnings.simplefilter("ignore")
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    drawing: dict[str, Draw] = {}
    missing: dict[str, str] = {}
    for name, prepare in RENDERERS.items():
        try:
            drawing[name] = prepare(columns, rows)
        except (ImportError, AttributeError, OSError) as error:
            missing[name] = f"{type(error).__name__}: {error}"
    versions = {name: version(name) for name in drawing}
    print(json.dumps({"versions": versions, "missing": missing}), file=answers)
    for line in sys.stdin:
        name, scene, number = line.split()
        frame = picture(folder / scene, int(number), columns, rows)
        start = time.process_time()
        drawn = drawing[name](frame)
        spent = time.process_time() - start
        length = len(drawn if isinstance(drawn, bytes) else drawn.encode())
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


RENDERERS: dict[str, Callable[[int, int], Draw]] = {
    "rich-pixels": rich_pixels,
    "textual-image": textual_image,
    "term-image": term_image,
    "chafa.py": chafa,
}

if __name__ == "__main__":
    main()
