"""The schema as rules, for mistakes in plain words.

The schema is the only definition of a layout's content. It uses a small part of RELAX NG:
each element is defined once, and its content is a set of children with a least and a most number.
"""

from __future__ import annotations

import functools
import math
import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import field

from hub.nearest import did_you_mean
from hub.values import dataclass
from rune_tui.layout.places import Place

_RELAX_NG = "{http://relaxng.org/ns/structure/1.0}"
_ANNOTATIONS = "{http://relaxng.org/ns/compatibility/annotations/1.0}"
_NUMBERS = {
    "integer": re.compile(r"[+-]?0{0,99}[0-9]{1,18}"),
    "decimal": re.compile(r"[+-]?(0{0,99}[0-9]{1,18}(\.[0-9]{0,99})?|\.[0-9]{1,99})"),
}
_SPACES = " \t\n\r"
PART = "part"
"""The outermost element of a file that layouts include."""
REFERENCE = re.compile(r"\$\{([A-Za-z][A-Za-z0-9_]*)\}")
"""A variable in place of its value."""
_LONGEST_WITH_REFERENCE = 1000
_SHOWN_LENGTH = 40
_SHORT_SET = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """An element of an XML file.

    Attributes:
        tag: Its name; "{namespace}name" if it has a namespace.
        attributes: Its attributes.
        children: Elements in it.
        text: Text in it, without surrounding white space.
        place: Where its start tag begins.
        places: Places of its attributes.
    """

    tag: str
    attributes: Mapping[str, str]
    children: tuple[Node, ...]
    text: str
    place: Place
    places: Mapping[str, Place] = field(default_factory=dict)

    def at(self, attribute: str) -> Place:
        """The place of an attribute, or of the element without it."""
        return self.places.get(attribute, self.place)

    def of(self, tag: str) -> tuple[Node, ...]:
        """The children of this name."""
        return tuple(child for child in self.children if child.tag == tag)


@dataclass(frozen=True, slots=True)
class Mistake:
    """Something wrong in a file.

    Attributes:
        place: Where.
        message: The mistake, and the allowed values.
    """

    place: Place
    message: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ValueRule:
    """The allowed values of an attribute.

    Attributes:
        allowed: In words.
        kind: Type in the schema: "string", "integer", "decimal", or "choice".
        limits: Parameters of the type: pattern, maxLength, minInclusive, maxInclusive.
        choices: The values, if it is a choice.
        variable: Whether it may contain variables.
    """

    allowed: str
    kind: str
    limits: Mapping[str, str]
    choices: tuple[str, ...]
    variable: bool

    def written(self, text: str) -> bool:
        """Whether a file may contain this: a value, or variables that may become one."""
        short = len(text) <= _LONGEST_WITH_REFERENCE
        open_yet = self.variable and short and REFERENCE.search(text) is not None
        return open_yet or self.accepts(text)

    def accepts(self, text: str) -> bool:
        """Whether a value follows the rule."""
        if self.kind == "choice":
            return text in self.choices
        if self.kind == "string":
            long = len(text) > int(self.limits.get("maxLength", len(text)))
            pattern = self.limits.get("pattern")
            return not long and (pattern is None or re.fullmatch(pattern, text) is not None)
        text = text.strip(_SPACES)
        return _NUMBERS[self.kind].fullmatch(text) is not None and (
            float(self.limits["minInclusive"]) <= float(text) <= float(self.limits["maxInclusive"])
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class AttributeRule:
    """An attribute of an element.

    Attributes:
        type: Name of the rule of its value.
        required: Whether it must be there.
        default: Its value where it is left out; None if the schema has none.
    """

    type: str
    required: bool
    default: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ElementRule:
    """The allowed content of an element.

    Attributes:
        attributes: By name.
        children: Least and most number of each child, by name.
    """

    attributes: dict[str, AttributeRule] = field(default_factory=dict)
    children: dict[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rules:
    """A whole schema.

    Attributes:
        root: Name of the outermost element.
        elements: By name.
        values: Rules of values, by name.
    """

    root: str
    elements: Mapping[str, ElementRule]
    values: Mapping[str, ValueRule]

    def value(self, node: Node, attribute: str) -> str | None:
        """An attribute's value or its default.

        None if there is neither, if it breaks its rule, or where a variable in it is not known.
        """
        rule = self.elements[node.tag].attributes[attribute]
        text = node.attributes.get(attribute, rule.default)
        if text is None or REFERENCE.search(text) or not self.values[rule.type].accepts(text):
            return None
        return text if self.values[rule.type].kind == "string" else text.strip(_SPACES)

    def mistakes(self, root: Node, *, outermost: str = "") -> Iterator[Mistake]:
        """Everything in a tree that breaks the schema; its outermost element is a layout's."""
        outermost = outermost or self.root
        if root.tag != outermost:
            message = f"the outermost element is {tag(root.tag)}, it must be {tag(outermost)}"
            if root.tag == PART:
                message = f"this is a part of layouts; open one that includes it, not {tag(PART)}"
            yield Mistake(root.place, message)
            return
        nodes = [root]
        while nodes:
            node = nodes.pop()
            yield from self._attribute_mistakes(node)
            yield from self._child_mistakes(node)
            allowed = self.elements[node.tag].children
            nodes.extend(child for child in node.children if child.tag in allowed)

    def _attribute_mistakes(self, node: Node) -> Iterator[Mistake]:
        rules = self.elements[node.tag].attributes
        for name, text in node.attributes.items():
            if name not in rules:
                message = f"{tag(node.tag)} has no attribute {quoted(name)}{hint(name, rules)}"
                yield Mistake(node.at(name), message)
            elif not (rule := self.values[rules[name].type]).written(text):
                message = f"{name} of {tag(node.tag)} is {quoted(text)}, it must be {rule.allowed}"
                yield Mistake(node.at(name), message)
        for name, attribute in rules.items():
            if attribute.required and name not in node.attributes:
                allowed = self.values[attribute.type].allowed
                yield Mistake(node.place, f"{tag(node.tag)} needs the attribute {name}: {allowed}")

    def _child_mistakes(self, node: Node) -> Iterator[Mistake]:
        rules = self.elements[node.tag].children
        if node.text:
            message = f"{tag(node.tag)} holds the text {quoted(node.text)}, it may hold none"
            yield Mistake(node.place, message)
        seen: Counter[str] = Counter()
        for child in node.children:
            seen[child.tag] += 1
            if child.tag not in rules:
                yield Mistake(child.place, self._misplaced(child.tag, node.tag))
            elif seen[child.tag] > rules[child.tag][1]:
                yield Mistake(child.place, f"{tag(node.tag)} may hold only one {tag(child.tag)}")
        for name, (least, _) in rules.items():
            if seen[name] < least:
                yield Mistake(node.place, f"{tag(node.tag)} needs a {tag(name)} in it")

    def _misplaced(self, child: str, parent: str) -> str:
        places = [
            name for name, rule in self.elements.items() if child in rule.children and name != PART
        ]
        if places:
            belongs = " or ".join(map(tag, places))
            return f"{tag(child)} may not stand in {tag(parent)}, it belongs into {belongs}"
        allowed = self.elements[parent].children
        if not allowed:
            return f"unknown element {tag(child)}, {tag(parent)} holds no elements"
        return f"unknown element {tag(child)} in {tag(parent)}{hint(child, allowed)}"


def tag(name: str) -> str:
    """An element's name as a sentence shows it."""
    return f"<{quoted(name)[1:-1]}>"


def quoted(text: str) -> str:
    """A text from the file as a sentence shows it: short, printable, in quotes."""
    return repr(text if len(text) <= _SHOWN_LENGTH else text[: _SHOWN_LENGTH - 3] + "...")


def hint(word: str, known: Collection[str]) -> str:
    """The nearest known name, and all names if they are few, to be put behind a sentence."""
    text = _did_you_mean(word, tuple(known))
    if 0 < len(known) <= _SHORT_SET:
        text += f" (allowed: {', '.join(known)})"
    return text


_did_you_mean = functools.lru_cache(maxsize=1024)(did_you_mean)


def read_rules(schema: Node) -> Rules:
    """The rules in a schema.

    Raises:
        ValueError: The schema uses a part of RELAX NG that is not known here.
    """
    elements: dict[str, ElementRule] = {}
    values: dict[str, ValueRule] = {}
    for define in schema.of(f"{_RELAX_NG}define"):
        name = define.attributes["name"]
        if bodies := define.of(f"{_RELAX_NG}element"):
            elements[name] = ElementRule()
            _read_content(bodies[0], elements[name], 1, 1)
        else:
            values[name] = _read_value(define)
    (start,) = schema.of(f"{_RELAX_NG}start")
    roots = [ref.attributes["name"] for ref in start.children[0].children]
    return Rules(root=roots[0], elements=elements, values=values)


_COUNTS: dict[str, tuple[float, float]] = {
    "optional": (0, 1),
    "zeroOrMore": (0, math.inf),
    "oneOrMore": (1, math.inf),
    "interleave": (1, 1),
}


def _read_content(body: Node, rule: ElementRule, least: float, most: float) -> None:
    for part in body.children:
        kind = part.tag.removeprefix(_RELAX_NG)
        if kind == "attribute":
            rule.attributes[part.attributes["name"]] = AttributeRule(
                type=part.children[0].attributes["name"],
                required=least > 0,
                default=part.attributes.get(f"{_ANNOTATIONS}defaultValue"),
            )
        elif kind == "ref":
            rule.children[part.attributes["name"]] = (least, most)
        elif kind in _COUNTS:
            _read_content(part, rule, least * _COUNTS[kind][0], most * _COUNTS[kind][1])
        elif kind != "empty":
            message = f"schema.rng, line {part.place.line}: {kind} is not known to the loader"
            raise ValueError(message)


def _read_value(define: Node) -> ValueRule:
    (documentation,) = define.of(f"{_ANNOTATIONS}documentation")
    choices = define.of(f"{_RELAX_NG}choice")
    parts = choices[0] if choices else define
    data = parts.of(f"{_RELAX_NG}data")
    params = data[0].children if data else ()
    return ValueRule(
        allowed=documentation.text,
        kind=data[0].attributes["type"] if data else "choice",
        limits={param.attributes["name"]: param.text for param in params},
        choices=tuple(value.text for value in parts.of(f"{_RELAX_NG}value")),
        variable=bool(parts.of(f"{_RELAX_NG}ref")),
    )
