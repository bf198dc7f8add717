"""Which layout the console shows from a moment on, as recordings tell it."""

from __future__ import annotations

from dataclasses import dataclass

from hub.ipc.definition import MessageDefinition


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownLayout:
    """The layout that is shown from now on; the same one again when its file was saved anew.

    Attributes:
        layout: Its path.
        run: The number of the experiment's run that it names.
    """

    layout: str
    run: int


SHOWN_LAYOUT = MessageDefinition(
    name="RuneLayout",
    type=ShownLayout,
)
"""A local message: it is recorded, and goes over no bus."""
