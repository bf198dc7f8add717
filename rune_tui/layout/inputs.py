"""Which keys, parts of the mouse and of joysticks wake which widget, and where two collide."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field

from hub.values import dataclass
from rune_tui.layout import names
from rune_tui.layout.grammar import Mistake, Node, Rules, hint, quoted
from rune_tui.layout.joystick_checks import event_mistakes
from rune_tui.layout.joysticks import KINDS_FOR, Input, JoystickNodes
from rune_tui.layout.places import Place


def inputs_of(event: Node, rules: Rules, joysticks: JoystickNodes) -> tuple[Input, ...]:
    """The inputs that an event waits for; none if it has no single kind, or is wrong.

    They are several where an event means a whole hat switch.
    """
    if len(given := _sources(event)) != 1:
        return ()
    text = rules.value(event, given[0])
    if text is None:
        return ()
    if given == ["joystick"]:
        return joysticks.inputs(event)
    return (Input(name=names.MOUSE + text if given == ["mouse"] else names.canonical_key(text)),)


def input_mistakes(
    event: Node, rules: Rules, viewport: Node | None, joysticks: JoystickNodes
) -> Iterator[Mistake]:
    """The mistakes in an event's input."""
    key = rules.value(event, "key")
    if key is not None and not names.is_key(key):
        yield Mistake(event.at("key"), _unknown_key(key))
    elif key is not None and names.canonical_key(key) == names.WAY_OUT:
        message = f"the key {quoted(key)} ends the console always; choose another key"
        yield Mistake(event.at("key"), message)
    given = _sources(event)
    if len(given) > 1:
        message = f"an event is of one of key, mouse and joystick, not of {' and of '.join(given)}"
        yield Mistake(event.place, message)
    elif not given and not any(part in event.attributes for part in KINDS_FOR):
        message = "an event needs one of the attributes key, mouse and joystick"
        yield Mistake(event.place, message)
    yield from _mouse_mistakes(event, rules, viewport)
    yield from event_mistakes(event, rules, joysticks)


def _sources(event: Node) -> list[str]:
    return [source for source in ("key", "mouse", "joystick") if source in event.attributes]


def _mouse_mistakes(event: Node, rules: Rules, viewport: Node | None) -> Iterator[Mistake]:
    mouse = rules.value(event, "mouse")
    if mouse is None:
        return
    if viewport is None:
        message = "an event of the mouse belongs into a viewport: it is meant where that is"
        yield Mistake(event.at("mouse"), message)
    if mouse in {"wheel", "motion"} and rules.value(event, "when") == "released":
        yield Mistake(event.at("when"), f"the mouse's {mouse} is never released, leave when out")


def _unknown_key(key: str) -> str:
    if (reported := names.KEYS_REPORTED_AS.get(key)) is not None:
        return f"unknown key {quoted(key)}; terminals report it as {reported}, write that"
    if names.is_key(lower := names.canonical_key(key)):
        return f"unknown key {quoted(key)}; did you mean {lower!r}?"
    nearest = hint(key, names.KEYS)
    return f"unknown key {quoted(key)}{nearest or '; ' + names.KEY_RULE}"


_ANY = "*"
"""In place of a control: a whole hat moves several."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Claim:
    """An event that uses an input.

    Attributes:
        place: Place of the input's name.
        shown: The input, in words.
        what: The same as a key for tables; the mouse is meant where it is, so its viewport is
            part of it.
        control: The control of the widget that it moves, or `_ANY`.
        other: An alternative to choose.
    """

    place: Place
    shown: str
    what: str
    control: str
    other: str = "key"


@dataclass(slots=True)
class TakenInputs:
    """Which inputs are taken, and where; each is reported once for each event."""

    rules: Rules
    joysticks: JoystickNodes
    anywhere: dict[str, Place] = field(default_factory=dict)
    globally: dict[str, Place] = field(default_factory=dict)
    by_handler: dict[tuple[str, str, str], Place] = field(default_factory=dict)
    by_widget: dict[tuple[int, str], dict[str, Place]] = field(default_factory=dict)

    def claim(
        self, widget: Node, robot: str | None, *, viewport: Node | None = None
    ) -> Iterator[Mistake]:
        """Take the inputs of a widget, whose robot is None if it is global."""
        handler = self.rules.value(widget, "handler") or ""
        claims = [
            self._claim(event, each, viewport)
            for event in widget.of("event")
            if self.rules.value(event, "when")
            for each in inputs_of(event, self.rules, self.joysticks)
        ]
        reported: set[Place] = set()
        for claim in claims:
            taken = self._taken(widget, robot, handler, claim)
            if taken is not None and claim.place not in reported:
                reported.add(claim.place)
                message = f"{claim.shown} {taken}; choose another {claim.other}"
                yield Mistake(claim.place, message)
            bound = self.by_widget.setdefault((id(widget), claim.what), {})
            bound.setdefault(claim.control, claim.place)
        for claim in claims:
            self.anywhere.setdefault(claim.what, claim.place)
            if robot is None:
                self.globally.setdefault(claim.what, claim.place)
            elif robot:
                self.by_handler.setdefault((robot, handler, claim.what), claim.place)

    def _claim(self, event: Node, wanted: Input, viewport: Node | None) -> _Claim:
        when = "" if self.rules.value(event, "when") == "pressed" else " when released"
        control = _ANY if wanted.pushed else self.rules.value(event, "control") or ""
        name = wanted.name
        if wanted.kind is not None:
            place = event.at(next(part for part in KINDS_FOR if part in event.attributes))
            return _Claim(
                place=place, shown=name + when, what=name + when, control=control, other="control"
            )
        if name.startswith(names.MOUSE):
            shown = f"the mouse's {name.removeprefix(names.MOUSE)}{when}"
            within = viewport.attributes.get("name", "") if viewport else ""
            what = f"{name}{when} in {within}"
            return _Claim(place=event.at("mouse"), shown=shown, what=what, control=control)
        shown = f"the key {quoted(name)}{when}"
        return _Claim(place=event.at("key"), shown=shown, what=name + when, control=control)

    def _taken(self, widget: Node, robot: str | None, handler: str, claim: _Claim) -> str | None:
        what = claim.what
        bound = self.by_widget.get((id(widget), what), {})
        first = next(iter(bound.values()), None)
        if _ANY not in {claim.control, *bound}:
            first = bound.get(claim.control)
        if first is not None:
            return f"is already bound by this widget in {first.seen_from(claim.place)}"
        if (first := self.globally.get(what)) is not None:
            return f"belongs to a global widget already, in {first.seen_from(claim.place)}"
        if robot is None and (first := self.anywhere.get(what)) is not None:
            return f"of this global widget is used already, in {first.seen_from(claim.place)}"
        if robot and (first := self.by_handler.get((robot, handler, what))) is not None:
            at = first.seen_from(claim.place)
            return f"is bound to {handler} of robot {quoted(robot)} already, in {at}"
        return None
