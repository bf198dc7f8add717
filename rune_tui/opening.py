"""Layouts by name or path, with all visualizers and widgets there are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rune_tui.layout.extensions import with_installed
from rune_tui.layout.loader import load_layout
from rune_tui.layout.rules import Vocabulary
from rune_tui.layout.spec import LayoutSpec
from rune_tui.visualizers.registry import VISUALIZERS
from rune_tui.widgets.registry import WIDGETS

BUILT_IN = Vocabulary(visualizers=VISUALIZERS, widgets=WIDGETS)
"""What the package itself has."""

_LONGEST_NAME = 64
"""Letters of a shipped layout's name at most; what is longer is a path."""


def open_layout(name_or_path: str | Path, variables: Mapping[str, str] | None = None) -> LayoutSpec:
    """The layout file of that path, or the shipped layout of that name.

    Args:
        name_or_path: Which.
        variables: Values of the layout's variables that are not those of the file.

    Raises:
        LayoutError: The file cannot be read or has mistakes; all of them are listed.
    """
    path = layout_path(str(name_or_path))
    return load_layout(path, with_installed(BUILT_IN), variables)


def layout_path(name_or_path: str) -> Path:
    """Where the layout is that goes by this name or path."""
    path = Path(name_or_path)
    bare = path.suffix == "" and path.name == name_or_path and len(name_or_path) <= _LONGEST_NAME
    if bare and not path.exists():
        here = Path(__file__).parent
        for folder in (here / "layouts", here.parent / "layouts"):
            if (folder / f"{name_or_path}.xml").is_file():
                return folder / f"{name_or_path}.xml"
    return path
