"""Puts a layout together: takes in the parts that it includes, and the values of its variables.

A file's variables hold for it and for all that it includes, and win over those of the same name
there; so a part's variables are defaults. The variables of an
`<include>` hold for that part alone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from hub.values import dataclass
from rune_tui.errors import LayoutError
from rune_tui.layout.files import named_file
from rune_tui.layout.grammar import PART, REFERENCE, Mistake, Node, Rules, hint, quoted, tag
from rune_tui.layout.places import Place

DEEPEST = 8
"""Parts within parts that are taken in."""
MOST = 100
"""Parts that a layout may include, those within parts counted."""

_Reader = Callable[[Path], tuple[Node, int]]
"""Reads a file: its outermost element and its size [characters]; raises LayoutError."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Variable:
    """A variable as one file sees it.

    Attributes:
        value: Its replacement.
        declared: Where it was declared, here and in the files that include this one.
        given: Whether the command line gives it, and no file.
    """

    value: str
    declared: tuple[Place, ...]
    given: bool = False


_Scope = Mapping[str, _Variable]


class Assembly:
    """A layout file and all its parts as one tree.

    Attributes:
        mistakes: The mistakes in their composition.
        files: The files that were read, or would have been if they were there.
        given: Which values that were not those of a file went where, such as run=2.
    """

    def __init__(self, rules: Rules, read: _Reader, path: Path, *, largest: int) -> None:
        """Prepare.

        Args:
            rules: The rules of the schema.
            read: Reads a part.
            path: The layout file.
            largest: How large all files may be together, values put in included [characters].
        """
        self.mistakes: list[Mistake] = []
        self.files: list[Path] = [path]
        self.given: dict[Place, str] = {}
        self._rules = rules
        self._read = read
        self._folder = path.parent
        self._largest = largest
        self._room = largest
        self._parts = 0
        self._names: dict[Place, str] = {}
        self._used: set[Place] = set()

    def whole(self, root: Node, size: int, given: Mapping[str, str]) -> Node:
        """The layout with its parts; an `<include>` stays, in front of its content.

        Args:
            root: The layout file.
            size: Its size [characters].
            given: Values of variables that are not those of the file.
        """
        self._room -= size
        top = {
            name: _Variable(value=value, declared=(), given=True) for name, value in given.items()
        }
        whole = self._file(root, top, (self.files[0],))
        for name, value in given.items():
            self._plain(name, value, Place(root.place.path))
            if name not in self._names.values():
                near = hint(name, sorted(set(self._names.values())))
                message = f"the layout has no variable {quoted(name)} to be set{near}"
                self._wrong(Place(root.place.path), message)
        for place, name in self._names.items():
            if place not in self._used:
                self._wrong(place, f"the variable {quoted(name)} is used nowhere; remove it")
        return whole

    def _wrong(self, place: Place, message: str) -> None:
        self.mistakes.append(Mistake(place, message))

    def _file(self, root: Node, scope: _Scope, chain: tuple[Path, ...]) -> Node:
        """A file with its parts in it; `chain` leads from the layout to it."""
        return self._filled(root, {**scope, **self._declared(root, scope)}, chain)

    def _declared(self, owner: Node, outer: _Scope) -> dict[str, _Variable]:
        """The variables that an element declares; those of `outer` change their values."""
        found: dict[str, _Variable] = {}
        for node in owner.of("variable"):
            name = self._rules.value(node, "name")
            value = node.attributes.get("value")
            if name is None or value is None:
                continue
            place = node.at("name")
            self._plain(name, value, node.at("value"))
            if name in found:
                first = found[name].declared[0].seen_from(place)
                self._wrong(place, f"the variable {quoted(name)} is already in {first}")
                continue
            self._names[place] = name
            known = outer.get(name, _Variable(value=value, declared=()))
            found[name] = dataclasses.replace(known, declared=(place, *known.declared))
        return found

    def _plain(self, name: str, value: str, place: Place) -> None:
        """Values are literal, so they cannot grow from each other."""
        if "${" in value:
            message = f"the value of variable {quoted(name)} may not use variables itself"
            self._wrong(place, message)

    def _filled(self, node: Node, scope: _Scope, chain: tuple[Path, ...]) -> Node:
        """An element with values for variables and, where it may have them, its parts."""
        if node.tag == "variable":
            return node
        rule = self._rules.elements.get(node.tag)
        includes = rule is not None and "include" in rule.children
        children: list[Node] = []
        for child in node.children:
            filled = self._filled(child, scope, chain)
            children.append(filled)
            if child.tag == "include" and includes:
                children += self._part(filled, scope, chain)
        values = {
            name: self._value(text, node.at(name), scope) for name, text in node.attributes.items()
        }
        return dataclasses.replace(node, attributes=values, children=tuple(children))

    def _value(self, text: str, place: Place, scope: _Scope) -> str:
        """The value of an attribute, with the values of variables in it."""
        if "${" not in text:
            return text
        found = list(REFERENCE.finditer(text))
        if text.count("${") > len(found):
            self._wrong(place, "'${' begins the name of a variable, such as ${name}")
        for name in dict.fromkeys(one[1] for one in found):
            if name in scope:
                self._used.update(scope[name].declared)
                if scope[name].given:
                    self.given[place] = f"{name}={scope[name].value}"
            else:
                near = hint(name, sorted(scope))
                self._wrong(place, f"unknown variable {quoted(name)}{near}")
        growth = sum(len(scope[one[1]].value) - len(one[0]) for one in found if one[1] in scope)
        if not self._fits(max(0, growth), place):
            return text
        return REFERENCE.sub(lambda one: scope[one[1]].value if one[1] in scope else one[0], text)

    def _fits(self, size: int, place: Place) -> bool:
        """Whether there is room for more characters; a lack is reported once."""
        if self._room >= 0 > self._room - size:
            message = f"the layout with its parts and variables is larger than {self._largest}"
            self._wrong(place, f"{message} characters; a layout is a few thousand long")
        self._room -= size
        return self._room >= 0

    def _part(self, include: Node, scope: _Scope, chain: tuple[Path, ...]) -> Iterable[Node]:
        """The content of an `<include>`'s part."""
        root = self._root(include, chain)
        if root is None:
            return ()
        # Its children are checked at their new place; its variables have no other place.
        head = dataclasses.replace(root, children=root.of("variable"))
        self.mistakes += self._rules.mistakes(head, outermost=PART)
        scope = {**scope, **self._declared(include, {})}
        whole = self._file(root, scope, (*chain, Path(root.place.path)))
        return (child for child in whole.children if child.tag != "variable")

    def _root(self, include: Node, chain: tuple[Path, ...]) -> Node | None:
        """The outermost element of the file that an `<include>` names."""
        name, place = self._rules.value(include, "file"), include.at("file")
        if name is None or self._room < 0 or self._parts > MOST:
            return None
        path = named_file(name, beside=include.place.path, folder=self._folder)
        if path is None:
            self._wrong(place, f"the part {quoted(name)} is not in the layout's folder or below it")
            return None
        if path in chain:
            self._wrong(place, f"the part {quoted(name)} includes itself")
            return None
        if len(chain) > DEEPEST:
            self._wrong(place, f"parts are included more than {DEEPEST} deep")
            return None
        self._parts += 1
        if self._parts > MOST:
            self._wrong(place, f"more than {MOST} parts are included")
            return None
        return self._opened(path, name, place)

    def _opened(self, path: Path, name: str, place: Place) -> Node | None:
        if path not in self.files:
            self.files.append(path)
        try:
            root, size = self._read(path)
        except LayoutError as error:
            for problem in error.problems:
                at, message = Place(problem.path, problem.line, problem.column), problem.message
                if not problem.line:
                    at, message = place, f"the part {quoted(name)}: {message.partition(';')[0]}"
                self._wrong(at, message)
            return None
        if not self._fits(size, place):
            return None
        if root.tag != PART:
            message = f"the outermost element of a part is {tag(PART)}, not {tag(root.tag)}"
            self._wrong(root.place, message)
            return None
        return root
