"""Visualizers and widgets from outside of the package: installed ones, and files beside a layout.

An extension is a Python file with a table `VISUALIZERS` or `WIDGETS`, or both: classes by the name
that layouts use. An installed package offers single classes as entry points of the groups
`rune.visualizers` and `rune.widgets`. Its code runs as the operator who opens the layout.
"""

from __future__ import annotations

import dataclasses
import importlib.metadata
import inspect
import itertools
import logging
import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from hub.gcm.catalog import BY_NAME
from rune_tui.layout.files import named_file
from rune_tui.layout.grammar import Mistake, Node, Rules, quoted
from rune_tui.layout.rules import HandlerRule, Purpose, VisualizerRule, Vocabulary

_logger = logging.getLogger(__name__)

GROUPS = {"VISUALIZERS": "rune.visualizers", "WIDGETS": "rune.widgets"}
_RULES: Mapping[str, type] = {"VISUALIZERS": VisualizerRule, "WIDGETS": HandlerRule}
_METHODS = {
    "VISUALIZERS": ("from_spec", "draw", "source"),
    "WIDGETS": ("from_spec", "handle", "tick", "release"),
}
_PURPOSE_METHODS: Mapping[Purpose, tuple[str, ...]] = {
    Purpose.DRIVE: ("accepts", "forget"),
    Purpose.TAKE_CONTROL: ("takes_by_driving",),
}
_FLAG_METHODS: Mapping[str, tuple[str, ...]] = {
    "pictures": ("picture_size", "in_picture"),
    "locates": ("locate",),
    "draws_over": ("draw_over",),
}
_LONGEST_REASON = 200


def with_installed(vocabulary: Vocabulary) -> Vocabulary:
    """The vocabulary with the offers of installed packages, and the reasons for unusable ones."""
    tables: dict[str, dict[str, Any]] = {"VISUALIZERS": {}, "WIDGETS": {}}
    faults: dict[str, str] = {}
    for table, group in GROUPS.items():
        for point in importlib.metadata.entry_points(group=group):
            try:
                found = point.load()
            except (Exception, SystemExit) as error:  # an extension may fail in any way
                why = f"{point.name} of {point.value} cannot be loaded: {_why(error)}"
                faults[point.name] = why
                _logger.debug("%s", why, exc_info=True)
                continue
            if lack := _lack(table, found):
                faults[point.name] = f"{point.name} of {point.value} {lack}"
            else:
                _complete(found)
                tables[table][point.name] = found
    return dataclasses.replace(_joined(vocabulary, tables), faults=faults)


def extended(
    vocabulary: Vocabulary, root: Node, rules: Rules, folder: Path
) -> tuple[Vocabulary, tuple[Path, ...], list[Mistake]]:
    """The vocabulary with a layout's extensions, their files, and their mistakes."""
    mistakes = []
    files: dict[Path, None] = {}
    for node in root.of("extension"):
        name = rules.value(node, "file")
        if name is None:
            continue
        path = named_file(name, beside=node.place.path, folder=folder)
        if path is None or path.suffix != ".py":
            text = f"the extension {quoted(name)} is no Python file in the layout's folder or below"
            mistakes.append(Mistake(node.at("file"), text))
            continue
        if path in files:
            text = f"the extension {quoted(name)} is named twice"
            mistakes.append(Mistake(node.at("file"), text))
            continue
        files[path] = None
        try:
            tables = _read(path)
        except _ExtensionFault as fault:
            mistakes.append(Mistake(node.at("file"), f"the extension {quoted(name)} {fault}"))
            continue
        known = vocabulary.visualizers.keys() | vocabulary.widgets.keys()
        for twice in sorted(known & {each for table in tables.values() for each in table}):
            text = f"the extension {quoted(name)} names {quoted(twice)}, which there is already"
            mistakes.append(Mistake(node.at("file"), f"{text}; give it another name"))
        vocabulary = _joined(vocabulary, tables)
    return vocabulary, tuple(files), mistakes


def refused_extensions(root: Node) -> list[Mistake]:
    """A mistake for each extension of a layout that others wrote, for any name of its file."""
    text = "the layout has code, which does not run from a recording; name your copy by --layout"
    return [Mistake(node.place, text) for node in root.of("extension")]


class _ExtensionFault(Exception):  # noqa: N818 - it becomes a layout's mistake
    """The mistake of an extension, as words after its name."""


def _joined(vocabulary: Vocabulary, tables: Mapping[str, Mapping[str, Any]]) -> Vocabulary:
    return dataclasses.replace(
        vocabulary,
        visualizers={**tables["VISUALIZERS"], **vocabulary.visualizers},
        widgets={**tables["WIDGETS"], **vocabulary.widgets},
    )


def _read(path: Path) -> dict[str, dict[str, Any]]:
    module = _run(path)
    tables: dict[str, dict[str, Any]] = {}
    for table in GROUPS:
        offered = getattr(module, table, {})
        if not isinstance(offered, Mapping):
            text = f"has a {table} that is no table of classes by name"
            raise _ExtensionFault(text)
        for offer, found in offered.items():
            if lack := _lack(table, found):
                text = f"offers {quoted(str(offer))}, which {lack}"
                raise _ExtensionFault(text)
            _complete(found)
        tables[table] = {str(offer): found for offer, found in offered.items()}
    if not any(tables.values()):
        text = "has neither a table VISUALIZERS nor a table WIDGETS"
        raise _ExtensionFault(text)
    return tables


def _run(path: Path) -> ModuleType:
    """The module in a file; always the file as it is now, and nothing is written beside it."""
    module = ModuleType(f"rune extension {path.resolve()}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module  # dataclasses read it
    try:
        code = compile(path.read_bytes(), str(path), "exec")
        exec(code, module.__dict__)
    except FileNotFoundError as error:
        text = f"is not there: {path}"
        raise _ExtensionFault(text) from error
    except (Exception, SystemExit) as error:  # an extension may fail in any way
        text = f"cannot be run: {_why(error)}"
        raise _ExtensionFault(text) from error
    return module


def _why(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST_REASON]


def _lack(table: str, found: object) -> str:
    """The missing parts of a class for its table; empty: none."""
    if not inspect.isclass(found):
        return "is no class"
    rule = getattr(found, "rule", None)
    if not isinstance(rule, VisualizerRule | HandlerRule) or not isinstance(rule, _RULES[table]):
        return f"has no attribute rule that is a {_RULES[table].__name__}"
    methods = (*_METHODS[table], *_methods_of(rule))
    missing = [name for name in methods if not callable(getattr(found, name, None))]
    if missing:
        return f"has no method {missing[0]}"
    unknown = [name for name in _messages(rule) if name not in BY_NAME]
    return f"names a message {quoted(unknown[0])}, which is not known" if unknown else ""


def _complete(found: Any) -> None:  # noqa: ANN401 - a class of an extension
    """Fill in the missing values of a rule.

    A widget gets the purpose of the class from which it is derived, a visualizer the flags of its
    methods.
    """
    rules = [getattr(each, "rule", None) for each in found.__mro__]
    purposes = [each.purpose for each in rules if isinstance(each, HandlerRule) and each.purpose]
    if purposes and found.rule.purpose is None:
        found.rule = dataclasses.replace(found.rule, purpose=purposes[0])
    if isinstance(found.rule, VisualizerRule):
        flags: dict[str, Any] = {
            flag: True for flag, names in _FLAG_METHODS.items() if _has(found, names)
        }
        found.rule = dataclasses.replace(found.rule, **flags)


def _has(found: object, names: tuple[str, ...]) -> bool:
    """Whether a class has all of these methods."""
    return all(callable(getattr(found, name, None)) for name in names)


def _methods_of(rule: VisualizerRule | HandlerRule) -> tuple[str, ...]:
    """The methods that the flags of a rule promise."""
    if isinstance(rule, HandlerRule):
        return _PURPOSE_METHODS.get(rule.purpose, ()) if rule.purpose else ()
    flagged = (names for flag, names in _FLAG_METHODS.items() if getattr(rule, flag))
    return tuple(itertools.chain.from_iterable(flagged))


def _messages(rule: VisualizerRule | HandlerRule) -> tuple[str, ...]:
    if isinstance(rule, HandlerRule):
        return (*rule.sends, *rule.uses)
    return tuple(filter(None, (rule.message, *rule.others)))
