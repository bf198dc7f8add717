"""The fonts that a layout names: their files, and the mistakes in them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rune_tui.layout.files import named_file
from rune_tui.layout.grammar import Mistake, Node, Rules, quoted
from rune_tui.layout.spec import FontSpec


def named_fonts(
    root: Node, rules: Rules, folder: Path
) -> tuple[Mapping[str, FontSpec], list[Path], list[Mistake]]:
    """The fonts by name, their files, and their mistakes; `folder` is the layout's."""
    fonts: dict[str, FontSpec] = {}
    files: list[Path] = []
    mistakes: list[Mistake] = []
    for node in root.of("font"):
        name, points = rules.value(node, "name"), rules.value(node, "size")
        file = rules.value(node, "file")
        path = named_file(file, beside=node.place.path, folder=folder) if file else None
        if file and path is None:
            text = f"the font {quoted(file)} is not in the layout's folder or below it"
            mistakes.append(Mistake(node.at("file"), text))
        elif path is not None:
            files.append(path)
            if not _is_file(path):
                text = f"the font {quoted(file or '')} is not there: {path}"
                mistakes.append(Mistake(node.at("file"), text))
        if name is not None:
            size = float(points) if points else 16.0
            fonts.setdefault(name, FontSpec(file=str(path) if path else "", points=size))
    return fonts, files, mistakes


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # such as a name that is too long
        return False
