"""Characters that terminals draw and the font of picture files lacks: lines, blocks, triangles."""

from __future__ import annotations

from typing import Final

from PIL import Image, ImageDraw

_LINES: Final = {
    "─": "lr",
    "│": "ud",
    "├": "udr",
    "┤": "udl",
    "┬": "lrd",
    "┴": "lru",
    "┼": "lrud",
    "╵": "u",
    "╷": "d",
    "┃": "UD",
}
"""To which sides of the cell its lines go from the middle; capital letters are thick."""
_SHAPES: Final = {
    "█": ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)),
    "▲": ((0.5, 0.25), (0.98, 0.75), (0.02, 0.75)),
    "▼": ((0.02, 0.25), (0.98, 0.25), (0.5, 0.75)),
    "◀": ((0.02, 0.5), (0.98, 0.22), (0.98, 0.78)),
    "▶": ((0.98, 0.5), (0.02, 0.22), (0.02, 0.78)),
}
"""Corners in shares of the cell."""
_ENDS: Final = {"l": (0.0, 0.5), "r": (1.0, 0.5), "u": (0.5, 0.0), "d": (0.5, 1.0)}


def drawn_glyph(glyph: str, scale: int) -> Image.Image | None:
    """Where a character's ink is in its cell; None of those that fonts have.

    Args:
        glyph: The character.
        scale: Width and half the height of the cell [pixels].
    """
    width, height = scale, 2 * scale
    mask = Image.new("L", (width, height))
    pen = ImageDraw.Draw(mask)
    if corners := _SHAPES.get(glyph):
        pen.polygon([(x * (width - 1), y * (height - 1)) for x, y in corners], 255)
        return mask
    sides = _LINES.get(glyph)
    if sides is None:
        return None
    middle = (width // 2, height // 2)
    for side in sides:
        x, y = _ENDS[side.lower()]
        thickness = max(1, scale // (3 if side.isupper() else 8))
        pen.line([middle, (round(x * width), round(y * height))], 255, thickness)
    return mask
