"""The allowed values of a message's fields: declared beside the field, checked at reception.

A declaration stands in the field's type: `x: Annotated[float, Range(-1e6, 1e6, unit="m")]`. A
value outside it is replaced:

| the field | the replacement |
| --- | --- |
| a number that may be NaN, in a state | NaN: not known |
| a number with `nearest`, but not NaN | the nearest number of the range |
| any other number; every number of a command | nothing: the message is refused |
| a text | its first letters, without control characters |
| a list or an array that is too long | nothing: the message is refused |

The reader of the message gets a note of each change and each refusal. A field without a declaration
stays as it is.
"""

from __future__ import annotations

import math
import struct
import typing
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from hub.errors import RangeError
from hub.ipc.formats import grammar as formats
from hub.ipc.formats.codegen import DTYPES, LETTERS
from hub.plain_text import bound_text, is_plain, plain
from hub.values import dataclass

Note = Callable[[str], object]
"""Gets a sentence on a changed value."""


def no_note(_: str) -> None:
    """Ignore the change."""


Fix = Callable[[Any, Note], Any]
"""From a value outside its range to its replacement; raises RangeError if there is none."""

_MOST_LANES: Final = 64
_FLOATS: Final = ("float", "double")


@dataclass(frozen=True, slots=True)
class Range:
    """The allowed values of a number, or of each number of an array.

    Attributes:
        low: The least.
        high: The largest.
        unit: Their unit; empty: none.
        nan: Whether NaN is allowed; it means "not known".
        infinite: Whether plus infinity is allowed as well.
        nearest: Whether a number outside becomes the nearest one.
    """

    low: float
    high: float
    unit: str = ""
    nan: bool = False
    infinite: bool = False
    nearest: bool = False

    @property
    def any_number(self) -> bool:
        """Whether every number is allowed."""
        return self.nan and self.infinite and self.low == -math.inf and self.high == math.inf

    def __str__(self) -> str:
        if self.any_number:
            return "any number" + ", in " * bool(self.unit) + self.unit
        others = ", infinite" * self.infinite + " or NaN" * self.nan
        low, high = bound_text(self.low), bound_text(self.high)
        return f"{low} to {high}{' ' * bool(self.unit)}{self.unit}{others}"


@dataclass(frozen=True, slots=True)
class Text:
    """The allowed texts of a field.

    Attributes:
        most: Most letters; a longer text is cut.
        lines: Whether it may have several lines.
    """

    most: int
    lines: bool = False


@dataclass(frozen=True, slots=True)
class Most:
    """The largest length of a list or an array.

    Attributes:
        count: Entries.
    """

    count: int


Declared = Range | Text | Most


@dataclass(frozen=True, slots=True, kw_only=True)
class Lanes:
    """An array of floats as one integer, a lane of bits for each.

    The bits of floats without a sign grow with the number. So one sum over all lanes carries into
    the sign of each lane with too large a number.

    Attributes:
        bits: Of the whole array.
        signs: The sign of each lane.
        above: Summand that carries into the sign of a lane above the largest allowed number.
        endless: Summand that carries into the sign of an infinite or NaN lane, if both are allowed.
    """

    bits: int
    signs: int
    above: int
    endless: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """How generated code checks one member.

    Attributes:
        outside: An expression that is true of `{value}` if it may be outside the declaration.
            It may use `infinity` and `lined`.
        fix: Called then.
        lanes: A faster check of the array, alone or with others; None: there is none.
    """

    outside: str
    fix: Fix
    lanes: Lanes | None = None


def declared(hint: Any) -> tuple[Declared, ...]:
    """The declarations in a field's type."""
    return tuple(each for each in getattr(hint, "__metadata__", ()) if isinstance(each, Declared))


def bare(hint: Any) -> Any:
    """The type itself, without its declarations."""
    return typing.get_args(hint)[0] if typing.get_origin(hint) is typing.Annotated else hint


def checks(
    declarations: tuple[Declared, ...], node: formats.Format, where: str, *, strict: bool
) -> tuple[Check, ...]:
    """The checks of a member, in order.

    Args:
        declarations: Of the field.
        node: The member's format.
        where: The message and the field, for people.
        strict: Whether a number outside its range always refuses the message.

    Raises:
        TypeError: A declaration does not fit the format.
    """
    made = [_check(each, node, where, strict=strict) for each in declarations]
    return tuple(check for check in made if check is not None)


def _check(each: Declared, node: formats.Format, where: str, *, strict: bool) -> Check | None:
    name = node.name if isinstance(node, formats.Primitive) else ""
    if isinstance(each, Text) and name == "string":
        return _text_check(each, where)
    if isinstance(each, Text) and _is_of_texts(node):
        return _texts_check(each, where)
    if isinstance(each, Most) and isinstance(node, formats.VariableArray):
        fix = _refuser(lambda value: f"{len(value)} entries, at most {each.count}", where)
        return Check(outside=f"len({{value}}) > {each.count}", fix=fix)
    if isinstance(each, Range) and name in LETTERS:
        return _number_check(each, name, where, strict=strict)
    if (
        isinstance(each, Range)
        and isinstance(node, (formats.FixedArray, formats.VariableArray))
        and getattr(node.element, "name", "") in _FLOATS
    ):
        return None if each.any_number else _array_check(each, node, where, strict=strict)
    text = f"{where}: {each} does not fit {node}"
    raise TypeError(text)


def _is_of_texts(node: formats.Format) -> bool:
    element = node.element if isinstance(node, formats.VariableArray) else None
    return isinstance(element, formats.Primitive) and element.name == "string"


def _text_check(text: Text, where: str) -> Check:
    def fix(value: str, note: Note) -> str:
        if not is_plain(value, lines=text.lines):
            note(f"{where} has control characters: they are taken as numbers")
            value = plain(value[: text.most], lines=text.lines)
        if len(value) > text.most:
            note(f"{where} is {len(value)} letters long: only {text.most} are taken")
        return value[: text.most]

    shown = "lined({value})" if text.lines else "{value}.isprintable()"
    return Check(outside=f"len({{value}}) > {text.most} or not {shown}", fix=fix)


def _texts_check(text: Text, where: str) -> Check:
    """The check of each text of an array."""
    one = _text_check(text, where)

    def fix(value: Sequence[str], note: Note) -> tuple[str, ...]:
        return tuple(one.fix(each, note) for each in value)

    return Check(outside=f"any({one.outside.format(value='each')} for each in {{value}})", fix=fix)


def lined(text: str) -> bool:
    """Whether a text of several lines is printable."""
    return is_plain(text, lines=True)


def _refuser(fault: Callable[[Any], str], where: str) -> Fix:
    def refuse(value: Any, _note: Note) -> Any:
        text = f"{where} is {fault(value)}"
        raise RangeError(text)

    return refuse


def _number_check(wanted: Range, name: str, where: str, *, strict: bool) -> Check | None:
    if name not in _FLOATS:
        kind = np.iinfo(DTYPES[name])
        if wanted.low <= kind.min and kind.max <= wanted.high:
            return None
        low, high = repr(int(wanted.low)), repr(int(wanted.high))
    else:
        low, high = repr(float(wanted.low)), repr(float(wanted.high))
    outside = f"not {low} <= {{value}} <= {high}"
    if wanted.nan:
        outside += " and {value} == {value}"
    if wanted.infinite:
        outside += " and {value} != infinity"
    fix = _number_fix(wanted, where, strict=strict)
    return Check(outside=outside, fix=fix)


def _number_fix(wanted: Range, where: str, *, strict: bool) -> Fix:
    fault = f"{where} is {{!r:.40}}, not {wanted}"

    def fix(value: Any, note: Note) -> Any:
        if not strict and wanted.nan:
            note(fault.format(value) + ": it is taken as not known")
            return math.nan
        if not strict and wanted.nearest and value == value:
            kept = type(value)(wanted.low if value < wanted.low else wanted.high)
            note(fault.format(value) + f": it is taken as {bound_text(kept)}")
            return kept
        raise RangeError(fault.format(value))

    return fix


def _array_check(
    wanted: Range, node: formats.FixedArray | formats.VariableArray, where: str, *, strict: bool
) -> Check:
    def within(value: Any) -> Any:
        kept = (value >= wanted.low) & (value <= wanted.high)
        if wanted.nan:
            kept |= np.isnan(value)
        if wanted.infinite:
            kept |= value == math.inf
        return kept

    def fix(value: Any, note: Note) -> Any:
        with np.errstate(invalid="ignore"):  # a signalling NaN may come from anywhere
            good = within(value)
        if good.all():
            return value
        first = value.reshape(-1)[int(np.argmin(good.reshape(-1)))]
        text = f"{where} has {first!s:.40}, not {wanted}"
        if strict or not wanted.nan:
            raise RangeError(text)
        note(text + ": it is taken as not known")
        kept = value.copy()
        kept[~good] = np.nan
        kept.flags.writeable = False
        return kept

    lanes = _lanes(wanted, node) if isinstance(node, formats.FixedArray) else None
    return Check(outside="{value}.size", fix=fix, lanes=lanes)


def _lanes(wanted: Range, node: formats.FixedArray) -> Lanes | None:
    """Lanes for an array of floats; None: this array has none."""
    name = getattr(node.element, "name", "")
    if wanted.low != 0.0 or node.count > _MOST_LANES:
        return None
    width = 8 * DTYPES[name].itemsize
    sign = 1 << (width - 1)

    def bits(number: float) -> int:
        return int.from_bytes(struct.pack("<" + LETTERS[name], number), "little")

    def everywhere(lane: int) -> int:
        return sum(lane << (width * place) for place in range(node.count))

    both = wanted.nan and wanted.infinite
    return Lanes(
        bits=width * node.count,
        signs=everywhere(sign),
        above=everywhere(sign - bits(wanted.high) - 1),
        endless=everywhere(sign - bits(math.inf)) if both else 0,
    )


def known() -> dict[str, Any]:
    """Names that expressions of checks may use."""
    return {"infinity": math.inf, "lined": lined, "read": int.from_bytes}


def suspect(arrays: Sequence[str], lanes: Sequence[Lanes]) -> str:
    """An expression that is true if one of these arrays needs a closer check.

    It needs `read`, which is `int.from_bytes`: other ways take several times as long here.

    Args:
        arrays: The variables that hold them.
        lanes: Of each.
    """
    signs = above = endless = at = 0
    for each in lanes:
        signs, above = signs | each.signs << at, above | each.above << at
        endless, at = endless | each.endless << at, at + each.bits
    raw = " + ".join(f"{array}.tobytes()" for array in arrays)
    large = f"(large := (bits + {above:#x}) & {signs:#x})"
    return (
        f"(bits := read({raw}, 'little')) & {signs:#x} or "
        f"({large} and large != (bits + {endless:#x}) & {signs:#x})"
    )
