"""Draws characters that the font of picture files lacks: lines, blocks, triangles."""

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
"""Sides of the cell that the lines reach from its middle; capital letters are thick lines."""
_SHAPES: Final = {
    "█": ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)),
    "▲": ((0.5, 0.25), (0.98, 0.75), (0.02, 0.75)),
    "▼": ((0.02, 0.25), (0.98, 0.25), (0.5, 0.75)),
    "◀": ((0.02, 0.5), (0.98, 0.22), (0.98, 0.78)),
    "▶": ((0.98, 0.5), (0.02, 0.22), (0.02, 0.78)),
}
"""Corners of a shape, as shares of the cell."""
_ENDS: Final = {"l": (0.0, 0.5), "r": (1.0, 0.5), "u": (0.5, 0.0), "d": (0.5, 1.0)}


def drawn_glyph(glyph: str, scale: int) -> Image.Image | None:
    """Mask of a character's ink in its cell; None if the font has the character.

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
