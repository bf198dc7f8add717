"""The layouts that a console was started with: which one is open, and whether it was saved since.

Files are checked a few times a second, which costs microseconds and works on every file system,
network mounts and editors that replace files included.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Protocol

from rune_tui.errors import LayoutError
from rune_tui.layout.spec import LayoutSpec

CHECK_S = 0.25
"""Time between two checks [s]."""

_Mark = tuple[int, int, int] | None
"""The marks of a file that change when it is saved; None: there is no file."""


class LayoutArrivals(Protocol):
    """Layouts that are made while the console runs, as for robots that join a fleet."""

    def look(self) -> str:
        """The news since the last call and how it is shown, in one sentence; empty: none."""

    def names(self) -> Sequence[str]:
        """The names of all layouts now, with all of before; the first shows the news."""


class LayoutSource:
    """Layouts by name, one of them open. A change to a layout with mistakes keeps the old one.

    Attributes:
        layout: The newest one without mistakes.
    """

    def __init__(
        self,
        names: Sequence[str],
        read: Callable[[str], LayoutSpec],
        layout: LayoutSpec,
        *,
        watched: bool,
        arrivals: LayoutArrivals | None = None,
    ) -> None:
        """Begin with the first.

        Args:
            names: Of all layouts.
            read: Reads the layout of a name; raises LayoutError.
            layout: The layout of the first name.
            watched: Whether `check` checks the files.
            arrivals: Layouts that come later; None: there are none.
        """
        self.layout = layout
        self._names = names if len(names) > 1 else (*names, *_companions(layout))
        self._read = read
        self._watched, self._arrivals, self._came = watched, arrivals, False
        self._open = self._tried = 0
        self._seen = _marks(layout.files)
        self._changing: Mapping[Path, _Mark] | None = None

    @property
    def changes(self) -> bool:
        """Whether there can ever be another layout than the first."""
        return self._watched or self.several or self._arrivals is not None

    @property
    def several(self) -> bool:
        """Whether there is a next layout."""
        return len(self._names) > 1 or self._came

    def news(self) -> str:
        """What can be shown since the last call, in one sentence; empty: nothing new."""
        said = "" if self._arrivals is None else self._arrivals.look()
        self._came |= bool(said)
        return said

    def check(self) -> LayoutSpec | LayoutError | None:
        """The saved layout, or its mistakes; None: nothing was saved.

        A file that still changed since the last check waits for the next: it may be half written.
        """
        if not self._watched:
            return None
        marks = _marks(self._seen)
        if marks == self._seen:
            self._changing = None
            return None
        if marks != self._changing:
            self._changing = marks
            return None
        return self._opened(self._open, marks)

    def next(self) -> LayoutSpec | LayoutError:
        """The layout behind the one that was tried last, the first behind the last.

        After news it is the first, which shows them.
        """
        if self._arrivals is not None:
            before, self._names = self._names, self._arrivals.names()
            self._open = self._names.index(before[self._open])
            self._tried = self._names.index(before[self._tried])
        self._tried = 0 if self._came else (self._tried + 1) % len(self._names)
        self._came = False
        return self._opened(self._tried, {})

    def _opened(self, index: int, before: Mapping[Path, _Mark]) -> LayoutSpec | LayoutError:
        self._changing = None
        try:
            layout = self._read(self._names[index])
        except LayoutError as error:
            if index == self._open:
                # Marks come before the reading: a file that is saved meanwhile counts as changed.
                self._seen = {**_marks(error.files), **before}
            return error
        except Exception:  # an extension may fail in any way; tried again after the next save
            self._seen |= before
            raise
        self._open = self._tried = index
        marks = _marks(layout.files)
        self._seen = {path: before.get(path, mark) for path, mark in marks.items()}
        self.layout = layout
        return layout


def _companions(layout: LayoutSpec) -> Iterator[str]:
    """The layout that another one names as its next, at most one."""
    widgets = [*layout.view.widgets]
    for viewport in layout.view.viewports:
        widgets += viewport.widgets
    named = (str(each.options.values.get("layout", "")) for each in widgets)
    yield from [name for name in named if name][:1]


def first_problem(error: LayoutError) -> str:
    """The mistakes of a layout in a line or two: their number, and the first of them."""
    first = error.problems[0]
    where = dataclasses.replace(first, path=Path(first.path).name)
    count = "1 problem" if len(error.problems) == 1 else f"{len(error.problems)} problems, first"
    return f"The layout stays as it was; {count}: {where}"


def _marks(files: Iterable[Path]) -> dict[Path, _Mark]:
    return {path: _mark(path) for path in files}


def _mark(path: Path) -> _Mark:
    try:
        status = path.stat()
    except (OSError, ValueError):
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino
