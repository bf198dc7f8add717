"""Which keys and which parts of the mouse wake which widget, and where two of them collide."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from rune_tui.layout import names
from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted
from rune_tui.layout.places import Place


def input_name(event: Node, rules: Rules) -> str:
    """The one name of the input that an event waits for; empty if it names none or several."""
    key, mouse = rules.value(event, "key"), rules.value(event, "mouse")
    if (key is None) == (mouse is None):
        return ""
    return names.MOUSE + mouse if mouse else names.canonical_key(key or "")


def input_mistakes(event: Node, rules: Rules, viewport: Node | None) -> Iterator[Mistake]:
    """What is wrong with the input that an event names."""
    key, mouse = rules.value(event, "key"), rules.value(event, "mouse")
    if key is not None and not names.is_key(key):
        yield Mistake(event.at("key"), _unknown_key(key))
    elif key is not None and names.canonical_key(key) == names.WAY_OUT:
        message = f"the key {quoted(key)} ends the console always; choose another key"
        yield Mistake(event.at("key"), message)
    if "key" not in event.attributes and "mouse" not in event.attributes:
        yield Mistake(event.place, "an event needs one of the attributes key and mouse")
    elif "key" in event.attributes and "mouse" in event.attributes:
        yield Mistake(event.place, "an event is of a key or of the mouse, not of both")
    if mouse is not None and viewport is None:
        message = "an event of the mouse belongs into a viewport: it is meant where that is"
        yield Mistake(event.at("mouse"), message)
    elif mouse is not None and viewport is not None and _unseen(viewport, rules):
        message = "the mouse cannot meet this viewport: give it a visualizer that can be seen"
        yield Mistake(event.at("mouse"), message)
    if mouse in {"wheel", "motion"} and rules.value(event, "when") == "released":
        yield Mistake(event.at("when"), f"the mouse's {mouse} is never released, leave when out")


def _unseen(viewport: Node, rules: Rules) -> bool:
    """Whether nothing of a viewport is ever on the screen."""
    return not viewport.of("visualizer") or rules.value(viewport, "transparency") == "255"


def _unknown_key(key: str) -> str:
    if (reported := names.KEYS_REPORTED_AS.get(key)) is not None:
        return f"unknown key {quoted(key)}; terminals report it as {reported}, write that"
    if names.is_key(lower := names.canonical_key(key)):
        return f"unknown key {quoted(key)}; did you mean {lower!r}?"
    nearest = hint(key, names.KEYS)
    return f"unknown key {quoted(key)}{nearest or '; ' + names.KEY_RULE}"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Claim:
    """An event that wants an input.

    Attributes:
        place: Where it says which.
        shown: What it wants, in words.
        what: The same as a key for tables; the mouse is meant where it is, so its viewport is
            part of it.
        control: What of the widget it moves.
    """

    place: Place
    shown: str
    what: str
    control: str


@dataclass(slots=True)
class TakenInputs:
    """Which inputs are taken, and where; each is reported once for each event."""

    rules: Rules
    anywhere: dict[str, Place] = field(default_factory=dict)
    globally: dict[str, Place] = field(default_factory=dict)
    by_handler: dict[tuple[str, str, str], Place] = field(default_factory=dict)
    by_widget: dict[tuple[int, str, str], Place] = field(default_factory=dict)

    def claim(
        self, widget: Node, robot: str | None, *, viewport: Node | None = None
    ) -> Iterator[Mistake]:
        """Take the inputs of a widget, whose robot is None if it is global."""
        handler = self.rules.value(widget, "handler") or ""
        claims = [
            self._claim(event, name, viewport)
            for event in widget.of("event")
            if (name := input_name(event, self.rules)) and self.rules.value(event, "when")
        ]
        for claim in claims:
            taken = self._taken(widget, robot, handler, claim)
            if taken is not None:
                yield Mistake(claim.place, f"{claim.shown} {taken}; choose another key")
            self.by_widget.setdefault((id(widget), claim.what, claim.control), claim.place)
        for claim in claims:
            self.anywhere.setdefault(claim.what, claim.place)
            if robot is None:
                self.globally.setdefault(claim.what, claim.place)
            elif robot:
                self.by_handler.setdefault((robot, handler, claim.what), claim.place)

    def _claim(self, event: Node, name: str, viewport: Node | None) -> _Claim:
        when = "" if self.rules.value(event, "when") == "pressed" else " when released"
        shown, what = f"the key {quoted(name)}{when}", name + when
        if name.startswith(names.MOUSE):
            place = viewport.attributes.get("name", "") if viewport else ""
            shown = f"the mouse's {name.removeprefix(names.MOUSE)}{when}"
            what += f" in {place}"
        control = self.rules.value(event, "control") or ""
        place_of_name = event.at("mouse" if name.startswith(names.MOUSE) else "key")
        return _Claim(place=place_of_name, shown=shown, what=what, control=control)

    def _taken(self, widget: Node, robot: str | None, handler: str, claim: _Claim) -> str | None:
        what = claim.what
        if (first := self.by_widget.get((id(widget), what, claim.control))) is not None:
            return f"is already bound by this widget in {first.seen_from(claim.place)}"
        if (first := self.globally.get(what)) is not None:
            return f"belongs to a global widget already, in {first.seen_from(claim.place)}"
        if robot is None and (first := self.anywhere.get(what)) is not None:
            return f"of this global widget is used already, in {first.seen_from(claim.place)}"
        if robot and (first := self.by_handler.get((robot, handler, what))) is not None:
            at = first.seen_from(claim.place)
            return f"is bound to {handler} of robot {quoted(robot)} already, in {at}"
        return None
