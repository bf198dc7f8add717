"""Finds and opens layouts by name or path, with all visualizers and widgets."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from hub.nearest import did_you_mean
from rune_tui.errors import LayoutError, LayoutProblem
from rune_tui.layout.extensions import with_installed
from rune_tui.layout.loader import load_layout
from rune_tui.layout.rules import Vocabulary
from rune_tui.layout.spec import LayoutSpec
from rune_tui.visualizers.registry import VISUALIZERS
from rune_tui.widgets.registry import WIDGETS

BUILT_IN = Vocabulary(visualizers=VISUALIZERS, widgets=WIDGETS)
"""Visualizers and widgets of the package."""

_HERE = Path(__file__).parents[1]
_SHIPPED = (_HERE / "layouts", _HERE.parent / "layouts")
"""Folders of shipped layouts: in the package, or beside it in a source tree."""
_COMMENT = re.compile(r"<!--(.*?)-->", re.DOTALL)
_LONGEST_NAME = 64
"""Most letters of a shipped layout's name; a longer text is a path."""


def open_layout(
    name_or_path: str | Path,
    variables: Mapping[str, str] | None = None,
    *,
    trusted: bool = True,
) -> LayoutSpec:
    """The layout of a file, or the shipped layout of a name.

    Args:
        name_or_path: Path of the file, or the name.
        variables: Values of the layout's variables; each replaces the value in the file.
        trusted: Whether the operator chose the layout; else none of its extensions run.

    Raises:
        LayoutError: The file cannot be read or has mistakes, with a list of them.
    """
    path = layout_path(str(name_or_path))
    if path == Path(name_or_path) and _is_bare(path, str(name_or_path)) and not path.exists():
        hint = did_you_mean(str(name_or_path), list(shipped_layouts()))
        text = f"there is no such file and no such layout{hint or '; `rune layouts` lists them'}"
        raise LayoutError([LayoutProblem(path=path.name, line=0, column=0, message=text)])
    return load_layout(path, with_installed(BUILT_IN), variables, trusted=trusted)


def layout_path(name_or_path: str) -> Path:
    """The file of a layout by its name or path."""
    path = Path(name_or_path)
    if _is_bare(path, name_or_path) and not path.exists():
        for folder in _SHIPPED:
            if (folder / f"{name_or_path}.xml").is_file():
                return folder / f"{name_or_path}.xml"
    return path


def shipped_layouts() -> dict[str, str]:
    """The first sentence of each shipped layout's comment, by the layout's name."""
    folder = next(folder for folder in _SHIPPED if folder.is_dir())
    return {path.stem: _meaning(path.read_text("utf-8")) for path in sorted(folder.glob("*.xml"))}


def _meaning(text: str) -> str:
    comment = _COMMENT.search(text)
    words = " ".join(comment[1].split()) if comment else ""
    return words.split(". ")[0].rstrip(".")


def _is_bare(path: Path, name: str) -> bool:
    """Whether a text could be the name of a shipped layout."""
    return path.suffix == "" and path.name == name and len(name) <= _LONGEST_NAME
