"""The rules for places of viewports, beyond the schema.

Either the view has a size and each viewport a place, or arrangements have both.
"""

from __future__ import annotations

from collections.abc import Iterator

from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted, tag
from rune_tui.layout.places import Place

_PLACE = ("xpos", "ypos", "xsize", "ysize")


def arrangement_mistakes(view: Node, rules: Rules) -> Iterator[Mistake]:
    """The mistakes in the places of a view's viewports."""
    yield from _unmet_by_the_mouse(view, rules)
    arrangements = view.of("arrangement")
    if not arrangements:
        yield from _needed(view, ("xsize", "ysize"), rules)
        for viewport in view.of("viewport"):
            yield from _needed(viewport, _PLACE, rules)
            yield from _outside(viewport, view, "view", rules)
        return
    yield from _placed_twice(view, rules)
    known = tuple(filter(None, (rules.value(each, "name") for each in view.of("viewport"))))
    first: dict[tuple[str | None, str | None], Place] = {}
    for arrangement in arrangements:
        size = (rules.value(arrangement, "min-columns"), rules.value(arrangement, "min-rows"))
        if None not in size and size in first:
            at = first[size].seen_from(arrangement.place)
            message = f"the arrangement in {at} is for the same size; give another min-columns"
            yield Mistake(arrangement.at("min-columns"), message)
        first.setdefault(size, arrangement.place)
        yield from _place_mistakes(arrangement, known, rules)


def _needed(node: Node, attributes: tuple[str, ...], rules: Rules) -> Iterator[Mistake]:
    """That a place is not given where no arrangement gives it."""
    for name in attributes:
        if name not in node.attributes:
            allowed = rules.values[rules.elements[node.tag].attributes[name].type].allowed
            yield Mistake(node.place, f"{tag(node.tag)} needs the attribute {name}: {allowed}")


def _placed_twice(view: Node, rules: Rules) -> Iterator[Mistake]:
    """Places and sizes beside arrangements, which have them all."""
    for name in ("xsize", "ysize"):
        if name in view.attributes:
            message = f"each arrangement has an {name} of its own; leave it out here"
            yield Mistake(view.at(name), message)
    for viewport in view.of("viewport"):
        given = [name for name in _PLACE if name in viewport.attributes]
        if given:
            name = quoted(rules.value(viewport, "name") or "")
            message = f"viewport {name} has its places in arrangements; leave {given[0]} out here"
            yield Mistake(viewport.at(given[0]), message)


def _place_mistakes(arrangement: Node, known: tuple[str, ...], rules: Rules) -> Iterator[Mistake]:
    first: dict[str, Place] = {}
    for place in arrangement.of("place"):
        name = rules.value(place, "viewport")
        if name is None:
            continue
        if name not in known:
            message = f"unknown viewport {quoted(name)}{hint(name, known)}"
            yield Mistake(place.at("viewport"), message)
        elif name in first:
            at = first[name].seen_from(place.place)
            message = f"viewport {quoted(name)} is placed in {at} already; place it once"
            yield Mistake(place.at("viewport"), message)
        first.setdefault(name, place.place)
        yield from _outside(place, arrangement, "arrangement", rules)


def _unmet_by_the_mouse(view: Node, rules: Rules) -> Iterator[Mistake]:
    """Events of the mouse in viewports that are never on the screen."""
    for viewport in view.of("viewport"):
        name = rules.value(viewport, "name")
        shown = [
            rules.value(place if "transparency" in place.attributes else viewport, "transparency")
            for arrangement in view.of("arrangement")
            for place in arrangement.of("place")
            if rules.value(place, "viewport") == name
        ]
        unseen = set(shown or [rules.value(viewport, "transparency")]) == {"255"}
        if not viewport.of("visualizer") or unseen:
            for event in (event for each in viewport.of("widget") for event in each.of("event")):
                if rules.value(event, "mouse") is not None:
                    message = "the mouse cannot meet this viewport: give it a visualizer"
                    yield Mistake(event.at("mouse"), f"{message} that can be seen")


def _outside(node: Node, design: Node, what: str, rules: Rules) -> Iterator[Mistake]:
    name = quoted(node.attributes.get("viewport" if node.tag == "place" else "name", ""))
    for axis in "xy":
        length = _number(design, f"{axis}size", rules)
        start = _number(node, f"{axis}pos", rules)
        size = _number(node, f"{axis}size", rules)
        if length is None or start is None or size is None:
            continue
        if start >= length or start + size <= 0:
            covers = f"it covers {axis} {start:g} to {start + size:g}, the {what} 0 to {length:g}"
            message = f"viewport {name} lies wholly outside the {what}: {covers}"
            yield Mistake(node.at(f"{axis}pos"), message)
            break


def _number(node: Node, attribute: str, rules: Rules) -> float | None:
    text = rules.value(node, attribute)
    return None if text is None else float(text)
