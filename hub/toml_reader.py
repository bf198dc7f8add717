"""Reading TOML files that people write: every key is checked, all mistakes are gathered.

Arenas and robots are such files. A dataclass declares each key once, by `key` at the field that
gets its value; `tables_of` collects the keys, `read_table` reads them.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from hub.files import read_regular
from hub.nearest import did_you_mean
from hub.plain_text import bound_text, is_plain, plain
from hub.values import dataclass

MAX_FILE_BYTES = 1_000_000
TOP = "top of the file"
"""Name of the place outside of all tables."""
_HEADER = re.compile(r"\s*+\[++\s*+([^\[\]#]*[^\[\]#\s])\s*+\]++\s*+(?:#.*)?")
_PLAIN_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._-]*")
_LINE = 1000
"""Length of a line in which headers and keys are found [characters]."""
_DEEPEST = 16
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_TOO_DEEP = re.compile(rf"(?<![\w-]){_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{_DEEPEST}}}")
"""Most parts of a dotted key; the parser takes minutes for very long ones."""
_KEY = re.compile(r"""\s*(["']?)([\w-]+)\1\s*=""")

Reader = Callable[[object], Any]
"""Turns a TOML value into the key's value, or raises `RefusedError`."""
REQUIRED: Any = object()
_DECLARED = "key"


class RefusedError(ValueError):
    """A value that its key refuses; the text gives the reason."""


@dataclass(frozen=True, slots=True)
class Within:
    """A reader with a description of its values.

    Attributes:
        read: The reader.
        allowed: The values, for people.
    """

    read: Reader
    allowed: str

    def __call__(self, value: object) -> Any:  # noqa: ANN401 - the reader's type
        """Read a value."""
        return self.read(value)


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a table.

    Attributes:
        read: Its reader.
        default: Value where the key is absent; `REQUIRED` where it must not be.
        field: Name of the value, if it is not the key's.
        meaning: For people.
        without: The value of an absent key, for people; empty: the default shows it.
    """

    read: Reader
    default: Any = REQUIRED
    field: str = ""
    meaning: str = ""
    without: str = ""


def key(
    read: Reader,
    default: Any = REQUIRED,  # noqa: ANN401 - as the reader makes it
    meaning: str = "",
    *,
    at: str = "",
    without: str = "",
) -> Any:  # noqa: ANN401 - what dataclasses want for a field
    """The field of a dataclass that gets the value of a key.

    Args:
        read: See `Key`, as for the others.
        default: For file and field.
        meaning: For people.
        at: Where the key stands, if it is not called as the field: "NAME", or "TABLE.NAME" where
            several tables fill one dataclass, or "TABLE." for the field's own name there.
        without: For people.
    """
    declared = Key(read, default, meaning=meaning, without=without)
    given = {} if default is REQUIRED else {"default": default}
    return dataclasses.field(**given, metadata={_DECLARED: (at, declared)})


@functools.lru_cache(maxsize=64)
def tables_of(kind: Any) -> Mapping[str, Mapping[str, Key]]:  # noqa: ANN401 - a dataclass
    """The keys that the fields of a dataclass declare: table, name in the file, key."""
    tables: dict[str, dict[str, Key]] = {}
    for field in dataclasses.fields(kind):
        if _DECLARED in field.metadata:
            at, declared = field.metadata[_DECLARED]
            table, _, name = at.rpartition(".")
            named = dataclasses.replace(declared, field=field.name)
            tables.setdefault(table, {})[name or field.name] = named
    return tables


def keys_of(kind: Any) -> Mapping[str, Key]:  # noqa: ANN401 - a dataclass
    """The keys that the fields of a dataclass declare for one table."""
    return tables_of(kind)[""]


def repeated(name: str, count: int) -> str:
    """The place of a repeated table in mistakes: the `count`-th [[name]] of the file."""
    return f"[[{name}]] {count}"


class Problems(list[str]):
    """What is wrong with a file, a sentence each, which begins with its line where that is known.

    A line is found by looking for headers of tables and keys at the beginning of lines, as people
    write them; what stands inside of other values is not found.
    """

    def __init__(self, text: str = "") -> None:
        super().__init__()
        self._lines: dict[tuple[str, str], int] = {}
        place = TOP
        counts: dict[str, int] = {}
        for number, line in enumerate(text.splitlines(), 1):
            start = line[:_LINE]
            if header := _HEADER.fullmatch(start):
                place = f"[{header[1]}]"
                if start.lstrip().startswith("[["):
                    counts[place] = counts.get(place, 0) + 1
                    self._lines.setdefault((place, ""), number)
                    place = repeated(header[1], counts[place])
                self._lines.setdefault((place, ""), number)
            elif key := _KEY.match(start):
                self._lines.setdefault((place, key[2]), number)

    def add(self, place: str, text: str, key: str = "") -> None:
        """Add a sentence about a place, or a key there."""
        text = plain(text)
        header = _header(place)
        key = "" if "," in place else key
        line = self._lines.get((header, key)) or self._lines.get((header, ""))
        if line is None:  # an unknown table, or a value in the place of one
            table = f"[{key}]" if place == TOP else header
            line = self._lines.get((table, "")) or self._lines.get((TOP, table.strip("[]")))
        sentence = (f"line {line}: " if line else "") + text
        if sentence not in self:
            self.append(sentence)


def _header(place: str) -> str:
    """The header of a place that is named without brackets: "start", "wall 2, doorway 1"."""
    if place == TOP or place.startswith("["):
        return place
    name, _, count = place.partition(",")[0].partition(" ")
    return repeated(name, int(count)) if count.isdecimal() else f"[{name}]"


def number(low: float, high: float) -> Within:
    """A number from `low` to `high`."""

    def read(value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            text = f"{shorten(value)} is not a number"
            raise RefusedError(text)
        # An integer of any length is valid TOML, so it is compared before it is converted.
        if not low <= value <= high:
            text = f"{shorten(value)} is not between {bound_text(low)} and {bound_text(high)}"
            raise RefusedError(text)
        return float(value)

    return Within(read, f"{bound_text(low)} to {bound_text(high)}")


def degrees(low: float, high: float) -> Within:
    """An angle from `low` to `high` degrees, in radians."""
    within = number(low, high)
    return Within(lambda value: math.radians(within(value)), within.allowed)


def whole_number(low: int, high: int) -> Within:
    """A whole number from `low` to `high`."""
    within = number(low, high)

    def read(value: object) -> int:
        if isinstance(value, float):
            text = f"{value!r} is not a whole number"
            raise RefusedError(text)
        return int(within(value))

    return Within(read, f"{low} to {high}")


def numbers(count: int, low: float, high: float) -> Within:
    """A list of `count` numbers from `low` to `high`, as a tuple."""
    one = number(low, high)

    def read(value: object) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            text = f"{shorten(value)} is not a list of {count} numbers"
            raise RefusedError(text)
        return tuple(one(item) for item in value)

    return Within(read, f"each {one.allowed}")


def truth(value: object) -> bool:
    """Read true or false."""
    if not isinstance(value, bool):
        reason = f"{shorten(value)} is neither true nor false"
        raise RefusedError(reason)
    return value


def text(longest: int, *, any_character: bool = False) -> Within:
    """A text of 1 to `longest` characters, printable unless any are allowed."""

    def read(value: object) -> str:
        if not isinstance(value, str) or not 1 <= len(value) <= longest:
            reason = f"{shorten(value)} is not a text of 1 to {longest} characters"
            raise RefusedError(reason)
        if not any_character and not is_plain(value):
            reason = f"{shorten(value)} has characters that cannot be shown"
            raise RefusedError(reason)
        return value

    return Within(read, f"up to {longest} characters")


def plain_name(longest: int) -> Reader:
    """A name that is safe as that of a file and on a terminal, of 1 to `longest` characters."""

    def read(value: object) -> str:
        if isinstance(value, str) and len(value) <= longest and _PLAIN_NAME.fullmatch(value):
            return value
        reason = (
            f"{shorten(value)} is no name of 1 to {longest} letters (a to z), digits, "
            "'.', '_' and '-', with no '.' or '-' first"
        )
        raise RefusedError(reason)

    return read


def several(one: Reader, most: int) -> Reader:
    """A list of 1 to `most` values that are read by `one`, as a tuple."""

    def read(value: object) -> tuple[Any, ...]:
        if not isinstance(value, list) or not 1 <= len(value) <= most:
            reason = f"{shorten(value)} is not a list of 1 to {most} values"
            raise RefusedError(reason)
        return tuple(one(item) for item in value)

    return read


def variables(longest: int, most: int) -> Reader:
    """A table of up to `most` environment variables, as pairs of name and text."""

    def read(value: object) -> tuple[tuple[str, str], ...]:
        if not isinstance(value, dict) or len(value) > most:
            reason = f"{shorten(value)} is not a table of up to {most} variables"
            raise RefusedError(reason)
        for name, content in value.items():
            if not (name.isascii() and name.isidentifier() and isinstance(content, str)):
                reason = f"{shorten(name)} is no variable with a text"
                raise RefusedError(reason)
            if len(content) > longest or "\0" in content:
                reason = f"the text of {shorten(name)} cannot be that of a variable"
                raise RefusedError(reason)
        return tuple(value.items())

    return read


def choice(names: Iterable[str] | Mapping[str, Any]) -> Within:
    """One of the names; the value of a name, if they are a mapping."""
    known = dict(names) if isinstance(names, Mapping) else {name: name for name in names}

    def read(value: object) -> Any:  # noqa: ANN401 - the mapping's type
        if isinstance(value, str) and value in known:
            return known[value]
        reason = f"{shorten(value)} is none of {', '.join(known)}{did_you_mean(value, known)}"
        raise RefusedError(reason)

    return Within(read, ", ".join(f"`{name}`" for name in known))


def shown(key: Key) -> str:
    """The value of an absent key, for people; empty: the key is required."""
    if key.default is REQUIRED or key.without:
        return key.without
    value = key.default.value if isinstance(key.default, enum.Enum) else key.default
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


def shorten(value: object) -> str:
    """How a value is shown in a message."""
    try:
        shown = repr(value)
    except ValueError:  # Python refuses to write whole numbers of thousands of digits
        return "a number of many digits"
    return shown if len(shown) <= 40 else shown[:37] + "..."


def load(
    path: Path, error: Callable[[str, list[str]], Exception]
) -> tuple[dict[str, Any], Problems]:
    """The content of a TOML file, and an empty list for its mistakes.

    Args:
        path: The file.
        error: Makes the exception from the file's name and the problems.

    Raises:
        Exception: Made by `error`: it cannot be read, is too large, or is not TOML.
    """
    try:
        raw = read_regular(path, MAX_FILE_BYTES)
    except (OSError, ValueError) as fault:
        reason = getattr(fault, "strerror", None) or str(fault)
        raise error(str(path), [f"cannot be read: {reason}; check its path"]) from fault
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise error(str(path), [f"is not UTF-8 text at byte {fault.start}"]) from fault
    if (deep := _TOO_DEEP.search(text)) is not None:
        line = text.count("\n", 0, deep.start()) + 1
        reason = f"line {line}: a key has more than {_DEEPEST} parts between its dots"
        raise error(str(path), [reason])
    try:
        return tomllib.loads(text), Problems(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as fault:
        raise error(str(path), [f"is not TOML: {fault}; correct it there"]) from fault


def apply_settings(data: dict[str, Any], settings: Iterable[str], problems: Problems) -> None:
    """Put values in place of a file's.

    Args:
        data: The content of the file; it is changed.
        settings: Each as "TABLE.KEY=VALUE"; a value that is no TOML counts as text.
        problems: Gets the mistakes in the settings.
    """
    for setting in settings:
        names, is_given, text = setting.partition("=")
        table, dot, key = names.partition(".")
        if not (is_given and dot and table and key) or not isinstance(data.get(table, {}), dict):
            problems.append(f"--set {shorten(setting)}: write TABLE.KEY=VALUE")
            continue
        try:
            value = tomllib.loads(f"value = {text}")["value"]
        except (tomllib.TOMLDecodeError, RecursionError, ValueError):
            value = text
        data.setdefault(table, {})[key] = value


def read_table(
    keys: Mapping[str, Key],
    values: object,
    place: str,
    problems: Problems,
    *,
    tables: Iterable[str] = (),
) -> dict[str, Any]:
    """The values of one table by field name; mistakes are added to `problems`.

    A value that is missing and has no default is None. `tables` are names that are known in this
    place as well and read elsewhere.
    """
    if not isinstance(values, dict):
        problems.add(place, f"{place}: {shorten(values)} is not a table")
        values = {}
    for name in values:
        if name not in keys and name not in tables:
            hint = did_you_mean(name, [*keys, *tables])
            problems.add(place, f"{place}: unknown key {shorten(name)}{hint}", name)
    fields: dict[str, Any] = {}
    for name, key in keys.items():
        field = key.field or name
        fields[field] = None if key.default is REQUIRED else key.default
        if name in values:
            try:
                fields[field] = key.read(values[name])
            except RefusedError as refused:
                problems.add(place, f"{place}, key '{name}': {refused}", name)
        elif key.default is REQUIRED:
            problems.add(place, f"{place}: key '{name}' is missing")
    return fields
