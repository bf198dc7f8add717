"""What not every terminal reports of the keys that a layout names."""

from __future__ import annotations

from rune_tui.layout.names import RARE_KEYS
from rune_tui.layout.spec import LayoutSpec


def key_notes(layout: LayoutSpec) -> tuple[str, ...]:
    """A sentence for each key that only some terminals tell, in the order of the file."""
    view = layout.view
    widgets = (*view.widgets, *(w for viewport in view.viewports for w in viewport.widgets))
    events = sorted((e for widget in widgets for e in widget.events), key=lambda each: each.line)
    rare = dict.fromkeys(event.name for event in events if event.name in RARE_KEYS)
    return tuple(_note(key) for key in rare)


def _note(key: str) -> str:
    others = RARE_KEYS[key]
    instead = f"others report it as {others}" if others else "others report nothing"
    return f"key {key}: only terminals with the kitty keyboard protocol tell it, {instead}"
