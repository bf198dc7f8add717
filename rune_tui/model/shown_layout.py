"""The message of recordings about the layout that the console shows."""

from __future__ import annotations

from hub.ipc.definition import MessageDefinition
from hub.values import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ShownLayout:
    """The layout that is shown from now on, or its file after a change.

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
