"""Draws characters that the font of picture files lacks: lines, blocks, triangles, arrows."""

from __future__ import annotations

from typing import Final

from PIL import Image, ImageDraw, ImageFont

_LINES: Final = {
    "─": "lr",
    "│": "ud",
    "┌": "rd",
    "┐": "ld",
    "└": "ur",
    "┘": "ul",
    "├": "udr",
    "┤": "udl",
    "┬": "lrd",
    "┴": "lru",
    "┼": "lrud",
    "╴": "l",
    "╵": "u",
    "╶": "r",
    "╷": "d",
    "━": "LR",
    "┃": "UD",
    "╋": "LRUD",
}
"""Sides of the cell that the lines reach from its middle; capital letters are thick lines."""
_Corners = tuple[tuple[float, float], ...]


def _block(left: float, top: float, right: float, bottom: float) -> _Corners:
    return ((left, top), (right, top), (right, bottom), (left, bottom))


_QUARTERS: Final = (
    _block(0.0, 0.0, 0.5, 0.5),
    _block(0.5, 0.0, 1.0, 0.5),
    _block(0.0, 0.5, 0.5, 1.0),
    _block(0.5, 0.5, 1.0, 1.0),
)
_SHAPES: Final[dict[str, tuple[_Corners, ...]]] = {
    "▀": (_block(0.0, 0.0, 1.0, 0.5),),
    "▐": (_block(0.5, 0.0, 1.0, 1.0),),
    "▔": (_block(0.0, 0.0, 1.0, 0.125),),
    "▕": (_block(0.875, 0.0, 1.0, 1.0),),
    **{chr(0x2580 + n): (_block(0.0, 1.0 - n / 8, 1.0, 1.0),) for n in range(1, 9)},
    **{chr(0x2590 - n): (_block(0.0, 0.0, n / 8, 1.0),) for n in range(1, 8)},
    **{
        sign: tuple(_QUARTERS[each] for each in quarters)
        for sign, quarters in {
            "▖": (2,), "▗": (3,), "▘": (0,), "▙": (0, 2, 3), "▚": (0, 3), "▛": (0, 1, 2),
            "▜": (0, 1, 3), "▝": (1,), "▞": (1, 2), "▟": (1, 2, 3),
        }.items()
    },
    "▲": (((0.5, 0.25), (0.98, 0.75), (0.02, 0.75)),),
    "▼": (((0.02, 0.25), (0.98, 0.25), (0.5, 0.75)),),
    "◀": (((0.02, 0.5), (0.98, 0.22), (0.98, 0.78)),),
    "▶": (((0.98, 0.5), (0.02, 0.22), (0.02, 0.78)),),
    "☾": (((0.3, 0.2), (0.85, 0.35), (0.9, 0.65), (0.3, 0.8), (0.6, 0.6), (0.6, 0.4)),),
}  # fmt: skip
"""Corners of the parts of a shape, as shares of the cell."""
_STROKES: Final[dict[str, tuple[_Corners, ...]]] = {
    "╱": (((0.0, 1.0), (1.0, 0.0)),),
    "╲": (((0.0, 0.0), (1.0, 1.0)),),
    "╳": (((0.0, 1.0), (1.0, 0.0)), ((0.0, 0.0), (1.0, 1.0))),
    "–": (((0.05, 0.55), (0.95, 0.55)),),
    "←": (((1.0, 0.5), (0.0, 0.5)), ((0.4, 0.3), (0.0, 0.5), (0.4, 0.7))),
    "→": (((0.0, 0.5), (1.0, 0.5)), ((0.6, 0.3), (1.0, 0.5), (0.6, 0.7))),
    "↑": (((0.5, 0.8), (0.5, 0.2)), ((0.1, 0.4), (0.5, 0.2), (0.9, 0.4))),
    "↓": (((0.5, 0.2), (0.5, 0.8)), ((0.1, 0.6), (0.5, 0.8), (0.9, 0.6))),
    "↖": (((0.9, 0.7), (0.1, 0.3)), ((0.6, 0.3), (0.1, 0.3), (0.1, 0.55))),
    "↗": (((0.1, 0.7), (0.9, 0.3)), ((0.4, 0.3), (0.9, 0.3), (0.9, 0.55))),
    "↘": (((0.1, 0.3), (0.9, 0.7)), ((0.4, 0.7), (0.9, 0.7), (0.9, 0.45))),
    "↙": (((0.9, 0.3), (0.1, 0.7)), ((0.6, 0.7), (0.1, 0.7), (0.1, 0.45))),
    "☼": (
        ((0.3, 0.4), (0.7, 0.4), (0.7, 0.6), (0.3, 0.6), (0.3, 0.4)),
        *(((0.5, 0.4), (0.5, 0.25)), ((0.5, 0.6), (0.5, 0.75))),
        *(((0.3, 0.5), (0.05, 0.5)), ((0.7, 0.5), (0.95, 0.5))),
    ),
}
"""Points of the lines of a character, as shares of the cell."""
_LETTERS: Final = {
    "£": (("L", 1.6, 1.55), ("-", 1.6, 1.55)),
    "§": (("S", 0.95, 1.1), ("S", 0.95, 1.55)),
    "²": (("2", 0.9, 0.95),),
}
"""Letters that make a character: each with its size and the height of its foot [widths]."""
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
    if parts := _SHAPES.get(glyph):
        for corners in parts:
            pen.polygon([(x * (width - 1), y * (height - 1)) for x, y in corners], 255)
        return mask
    if lines := _STROKES.get(glyph):
        for points in lines:
            ends = [(x * (width - 1), y * (height - 1)) for x, y in points]
            pen.line(ends, 255, max(1, scale // 8))
        return mask
    if letters := _LETTERS.get(glyph):
        for letter, size, foot in letters:
            font = ImageFont.load_default(size * scale)
            pen.text((width / 2, foot * scale), letter, 255, font, anchor="ms")
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
