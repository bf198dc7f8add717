"""Lines of the help: the actions of a layout's inputs by section, stop and drive first.

The last section has the parameters that make a vehicle unsafe.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, zip_longest
from typing import Final

from hub.values import dataclass
from rune_tui.layout.actions import Action
from rune_tui.layout.rules import Section
from rune_tui.layout.spec import CHOSEN
from rune_tui.model.own_keys import OwnKey
from rune_tui.visualizers.parts.severity import Severity

_SECTIONS = list(Section)
_SHIFTED: Final = {"!": "Shift+1 (!)", '@, "': 'Shift+2 (@ ")', "#, £, §": "Shift+3 (# £ §)"}
"""Digits with Shift, by the characters that they are on keyboards of several countries."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PageLine:
    """A line of a page.

    Attributes:
        left: First column; a heading fills both.
        right: Second column.
        severity: Severity of the line.
        heading: Whether it is a heading.
    """

    left: str
    right: str = ""
    severity: Severity = Severity.PLAIN
    heading: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class _Entry:
    section: Section
    robot: str
    inputs: str
    words: str
    safe: bool = True


def help_lines(
    actions: Sequence[Action],
    own: Iterable[OwnKey],
    robots: frozenset[str],
    *,
    unsafe: Iterable[tuple[str, str, str]] = (),
    search: str,
    left: int,
    right: int,
) -> Iterator[PageLine]:
    """The lines of the help.

    Args:
        actions: Actions of the layout's inputs.
        own: The console's keys that the layout does not bind.
        robots: Names of all robots of the layout.
        unsafe: The robot, the parameter with its values, and the reason, of each unsafe parameter.
        search: Text that an entry must contain.
        left: Width of the column of inputs [cells].
        right: Width of the column of actions [cells].
    """
    wanted = search.casefold()
    entries = [
        entry
        for entry in (*_of_layout(actions, robots), *_of_console(own))
        if wanted in f"{entry.section.value} {entry.robot} {entry.inputs} {entry.words}".casefold()
    ]
    entries.sort(key=lambda entry: (_SECTIONS.index(entry.section), entry.robot, not entry.safe))
    lines = [(_heading(entry), entry.inputs, entry.words) for entry in entries]
    lines += [
        (f"Unsafe parameters: {robot}", parameter, why)
        for robot, parameter, why in unsafe
        if wanted in f"unsafe parameters: {robot} {parameter} {why}".casefold()
    ]
    for heading, group in groupby(lines, key=lambda line: line[0]):
        yield PageLine(left=heading, heading=True)
        for _, inputs, words in group:
            yield from _wrapped(textwrap.wrap(inputs, left), textwrap.wrap(words, right))


def _wrapped(left: Sequence[str], right: Sequence[str]) -> Iterator[PageLine]:
    for one, other in zip_longest(left, right, fillvalue=""):
        yield PageLine(left=one, right=other)


def _of_layout(actions: Sequence[Action], robots: frozenset[str]) -> Iterator[_Entry]:
    several = len({action.robot for action in actions if action.robot}) > 1
    merged: dict[tuple[Section, str, str, bool], list[str]] = {}
    for action in actions:
        for said in action.inputs:
            robot = robot_words(action.robot) if several and action.robot else ""
            words = action.words
            alike = {each.robot for each in actions if _is_alike(each, action, said)}
            if len(alike) > 1:
                named = "all robots" if alike >= robots else ", ".join(sorted(alike))
                robot, words = "", f"{words}: {named}"
            inputs = merged.setdefault((action.section, robot, words, action.safe), [])
            inputs += [said] if said not in inputs else []
    for (section, robot, words, safe), inputs in merged.items():
        said = ", ".join(inputs)
        yield _Entry(
            section=section,
            robot=robot,
            inputs=_SHIFTED.get(said, said),
            words=words,
            safe=safe,
        )


def _is_alike(one: Action, other: Action, said: str) -> bool:
    """Whether an input means the same for two named robots."""
    named = {one.robot, other.robot}.isdisjoint({"", CHOSEN})
    return named and said in one.inputs and (one.section, one.words) == (other.section, other.words)


def _of_console(own: Iterable[OwnKey]) -> Iterator[_Entry]:
    merged: dict[tuple[Section, str], list[str]] = {}
    for each in own:
        merged.setdefault((each.section, each.words), []).append(each.key)
    for (section, words), keys in merged.items():
        yield _Entry(section=section, robot="", inputs=", ".join(keys), words=words)


def _heading(entry: _Entry) -> str:
    return f"{entry.section.value}: {entry.robot}" if entry.robot else entry.section.value


def robot_words(robot: str) -> str:
    """The robot of an action, in words."""
    if robot == CHOSEN:
        return "the chosen robot"
    return robot or "the console"
