"""The files that a layout may name: those in its own folder and below."""

from __future__ import annotations

from pathlib import Path, PurePosixPath


def named_file(name: str, *, beside: str, folder: Path) -> Path | None:
    """The file that a layout or one of its parts names.

    Args:
        name: The name, relative to the file with it.
        beside: The file with the name.
        folder: The layout's own folder.

    Returns:
        None if it is, or leads, outside of the layout's folder, or is no path at all.
    """
    parts = PurePosixPath(name)
    if parts.is_absolute() or ".." in parts.parts or "\\" in name:
        return None
    path = Path(beside).parent / parts
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # a loop of links, a name that is too long
        return None
    return path if inside else None
