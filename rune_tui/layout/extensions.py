"""Visualizers and widgets from outside of the package: installed ones, and files beside a layout.

An extension is a Python file with a table `VISUALIZERS` or `WIDGETS`, or both: classes by the name
that layouts use. An installed package offers single classes as entry points of the groups
`rune.visualizers` and `rune.widgets`. Its code runs as the operator who opens the layout.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import inspect
import logging
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from rune_tui.layout.grammar import Mistake, Node, Rules, quoted
from rune_tui.layout.rules import HandlerRule, VisualizerRule, Vocabulary

_logger = logging.getLogger(__name__)

GROUPS = {"VISUALIZERS": "rune.visualizers", "WIDGETS": "rune.widgets"}
_RULES: Mapping[str, type] = {"VISUALIZERS": VisualizerRule, "WIDGETS": HandlerRule}
_METHODS = {
    "VISUALIZERS": ("from_spec", "draw", "source"),
    "WIDGETS": ("from_spec", "handle", "tick", "release"),
}
_LONGEST_REASON = 200


def with_installed(vocabulary: Vocabulary) -> Vocabulary:
    """The vocabulary with what installed packages offer; what cannot be loaded is left out."""
    tables: dict[str, dict[str, Any]] = {"VISUALIZERS": {}, "WIDGETS": {}}
    for table, group in GROUPS.items():
        for point in importlib.metadata.entry_points(group=group):
            try:
                found = point.load()
            except Exception:  # somebody else's code may fail in any way
                _logger.exception("%s of %s cannot be loaded", point.name, point.value)
                continue
            if lack := _lack(table, found):
                _logger.error("%s of %s %s", point.name, point.value, lack)
            else:
                tables[table][point.name] = found
    return _joined(vocabulary, tables)


def extended(
    vocabulary: Vocabulary, root: Node, rules: Rules, folder: Path
) -> tuple[Vocabulary, list[Mistake]]:
    """The vocabulary with the extensions that a layout names, and what is wrong with those."""
    mistakes = []
    for node in root.of("extension"):
        name = rules.value(node, "file")
        if name is None:
            continue
        try:
            tables = _read(folder, name)
        except _ExtensionFault as fault:
            mistakes.append(Mistake(node.line, f"the extension {quoted(name)} {fault}"))
            continue
        known = vocabulary.visualizers.keys() | vocabulary.widgets.keys()
        for twice in sorted(known & {each for table in tables.values() for each in table}):
            text = f"the extension {quoted(name)} names {quoted(twice)}, which there is already"
            mistakes.append(Mistake(node.line, f"{text}; give it another name"))
        vocabulary = _joined(vocabulary, tables)
    return vocabulary, mistakes


class _ExtensionFault(Exception):  # noqa: N818 - it becomes a layout's mistake
    """What is wrong with an extension, to follow its name."""


def _joined(vocabulary: Vocabulary, tables: Mapping[str, Mapping[str, Any]]) -> Vocabulary:
    return Vocabulary(
        visualizers={**tables["VISUALIZERS"], **vocabulary.visualizers},
        widgets={**tables["WIDGETS"], **vocabulary.widgets},
    )


def _read(folder: Path, name: str) -> dict[str, dict[str, Any]]:
    parts = PurePosixPath(name)
    if parts.is_absolute() or ".." in parts.parts or parts.suffix != ".py":
        text = "is no Python file in the layout's folder or below it"
        raise _ExtensionFault(text)
    path = folder / parts
    if not path.is_file():
        text = f"is not there: {path}"
        raise _ExtensionFault(text)
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
        tables[table] = {str(offer): found for offer, found in offered.items()}
    if not any(tables.values()):
        text = "has neither a table VISUALIZERS nor a table WIDGETS"
        raise _ExtensionFault(text)
    return tables


def _run(path: Path) -> object:
    spec = importlib.util.spec_from_file_location(f"rune_extension_{path.stem}", path)
    if spec is None or spec.loader is None:
        text = "cannot be read as Python"
        raise _ExtensionFault(text)
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # somebody else's code may fail in any way
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST_REASON]
        text = f"cannot be run: {reason}"
        raise _ExtensionFault(text) from error
    return module


def _lack(table: str, found: object) -> str:
    """What a class lacks to be what its table says; empty if nothing."""
    if not inspect.isclass(found):
        return "is no class"
    if not isinstance(getattr(found, "rule", None), _RULES[table]):
        return f"has no attribute rule that is a {_RULES[table].__name__}"
    missing = [name for name in _METHODS[table] if not callable(getattr(found, name, None))]
    return f"has no method {missing[0]}" if missing else ""
