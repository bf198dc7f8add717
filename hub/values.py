"""The decorator of value classes: `dataclasses.dataclass`, with methods that are made at first use.

The standard decorator compiles six methods of each frozen class at once. A program imports hundreds
of classes and uses few, so that took a third of the time of our imports. The daemon does make them
at once, because the modules that are forked from it share them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn

__all__ = ["Making", "dataclass"]


class Making:
    """When the methods of the classes that are imported from now on are made.

    Attributes:
        at_once: With the class, as by the standard decorator.
    """

    at_once = False


if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(*, frozen: bool = False, **options: bool) -> Callable[[type], type]:
        """As `dataclasses.dataclass`; a subclass of a frozen class needs this decorator too."""

        def decorate(kind: type) -> type:
            if frozen and "order" not in options and _is_late(kind):
                return _with_late_methods(kind, **options)
            return dataclasses.dataclass(frozen=frozen, **options)(kind)

        return decorate


def _is_late(kind: type) -> bool:
    """Whether the methods of a class are made at first use: like its base's, if it has one."""
    bases = [base for base in kind.__mro__[1:] if dataclasses.is_dataclass(base)]
    return bases[0].__setattr__ is _refuse if bases else not Making.at_once


def _with_late_methods(
    kind: type[Any], *, slots: bool = False, kw_only: bool = False, eq: bool = True
) -> type[Any]:
    """The class as a frozen dataclass, with methods that replace themselves when first called."""
    decorate = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots, kw_only=kw_only)
    made = decorate(kind)

    def method_until_use(name: str) -> Callable[..., object]:
        def method(*arguments: object, **named: object) -> object:
            if made.__dict__[name] is method:
                setattr(made, name, _standard_method(made, name))
            result: object = made.__dict__[name](*arguments, **named)
            return result

        return method

    shared = {"__setattr__": _refuse, "__delattr__": _refuse}
    pickled = {"__getstate__": _state, "__setstate__": _restore} if slots else {}
    for name, method in (shared | pickled).items():
        if name not in kind.__dict__:
            setattr(made, name, method)
    for name in ("__init__", "__repr__", *(("__eq__", "__hash__") if eq else ())):
        if kind.__dict__.get(name) is None:
            setattr(made, name, method_until_use(name))
    return made


_OPTIONS = {
    "__init__": {"init": True, "frozen": True},
    "__repr__": {"repr": True},
    "__eq__": {"eq": True},
    "__hash__": {"unsafe_hash": True},
}
"""Options of the standard decorator by which it makes a method."""


def _standard_method(made: type[Any], name: str) -> object:
    """The method of a standard dataclass with the name and the fields of this one."""
    fields = dataclasses.fields(made)
    body: dict[str, object] = {field.name: field for field in fields}
    body["__annotations__"] = {field.name: field.type for field in fields}
    for each in ("__module__", "__qualname__", "__doc__", "__post_init__"):
        if hasattr(made, each):
            body[each] = getattr(made, each)
    options = {"init": False, "repr": False, "eq": False} | _OPTIONS[name]
    decorate: Callable[[type], type] = dataclasses.dataclass(**options)
    method: object = decorate(type(made.__name__, (), body)).__dict__[name]
    return method


def _refuse(value: object, name: str, *_: object) -> NoReturn:
    text = f"a {type(value).__name__} is frozen: its field {name!r} cannot change"
    raise dataclasses.FrozenInstanceError(text)


def _state(value: Any) -> list[object]:  # noqa: ANN401 - any dataclass
    return [getattr(value, field.name) for field in dataclasses.fields(value)]


def _restore(value: Any, state: list[object]) -> None:  # noqa: ANN401 - any dataclass
    for field, each in zip(dataclasses.fields(value), state, strict=True):
        object.__setattr__(value, field.name, each)
