"""Notes on keys of a layout that not every terminal reports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rune_tui.layout.names import MOUSE, RARE_KEYS
from rune_tui.layout.spec import EventSpec, LayoutSpec, WidgetSpec

_MOST_NAMED = 3
"""Keys that a notice names."""


def key_notes(layout: LayoutSpec) -> tuple[str, ...]:
    """A sentence for each key that may not work as the layout intends.

    These are keys that only some terminals report, in the order of the file, unless the layout also
    binds the report of other terminals. Further, held keys that drive and have another action too.
    """
    bound = {event.name for widget in _widgets(layout) for event in widget.events}
    return (*(_note(key, bound) for key in _without_another(layout)), *_collisions(layout))


def _collisions(layout: LayoutSpec) -> Iterator[str]:
    """A sentence for each held key with another action too."""
    rules = layout.vocabulary.widgets
    users: dict[tuple[str, str], dict[str, bool]] = {}
    for widget in _widgets(layout):
        for event in widget.events:
            held = rules[widget.handler].rule.held
            # A button of the mouse means only the viewport that is clicked.
            where = widget.viewport if event.name.startswith(MOUSE) else ""
            users.setdefault((event.name, where), {}).setdefault(widget.handler, held)
    for (name, _), handlers in users.items():
        if len(handlers) > 1 and any(handlers.values()) and not all(handlers.values()):
            yield f"{name} wakes {' and '.join(handlers)}: holding it does both"


def unreported_keys(layout: LayoutSpec) -> str:
    """A sentence for a terminal that reports none of them; empty: no problem."""
    keys = list(_without_another(layout))
    if not keys:
        return ""
    named, more = ", ".join(keys[:_MOST_NAMED]), len(keys) - _MOST_NAMED
    others = f" and {more} more" if more > 0 else ""
    return f"this terminal does not tell {named}{others}: rune check says what to bind as well"


def _widgets(layout: LayoutSpec) -> Iterator[WidgetSpec]:
    yield from layout.view.widgets
    for viewport in layout.view.viewports:
        yield from viewport.widgets


def _without_another(layout: LayoutSpec) -> Mapping[str, None]:
    """Rare keys with an action that no common key has, in the order of the file."""
    found = (
        (event.line, event.name)
        for widget in _widgets(layout)
        for event in widget.events
        if event.name in RARE_KEYS and not any(_is_another(e, event) for e in widget.events)
    )
    return dict.fromkeys(name for _, name in sorted(found, key=lambda each: each[0]))


def _is_another(other: EventSpec, rare: EventSpec) -> bool:
    """Whether an event of the same widget has the other terminals' report, with one meaning."""
    instead = RARE_KEYS[rare.name]
    reported = other.name == instead if instead else other.name not in RARE_KEYS
    return reported and _meaning(other) == _meaning(rare)


def _meaning(event: EventSpec) -> tuple[str, float, bool]:
    return event.control, event.value, event.released


def _note(key: str, bound: set[str]) -> str:
    others = RARE_KEYS[key]
    if not others:
        instead = "others report nothing: bind another key as well"
    elif others in bound:
        instead = f"others report it as {others}, which means something else here"
    else:
        instead = f'others report it as {others}: bind "{others}" as well'
    return f"key {key}: only terminals with the kitty keyboard protocol tell it, {instead}"
