"""Decoded messages of any encoding: values by the names of their fields."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hub.errors import RosMessageError
from hub.ros.schema import RosField, RosType
from hub.values import dataclass


class RosValue(ABC):
    """A decoded message, or one within it.

    A message within it is a `RosValue`, several are a tuple of them; numbers are arrays (n,).
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """The name of its type."""

    @abstractmethod
    def field(self, name: str) -> Any:  # noqa: ANN401 - fields have any type
        """The value of an own field; None: there is none."""

    @abstractmethod
    def fields(self) -> Iterator[tuple[str, Any]]:
        """Name and value of each field."""

    def get(self, path: str) -> Any:  # noqa: ANN401 - fields have any type
        """The value of a field such as `header.stamp`.

        Raises:
            RosMessageError: There is no such field.
        """
        value: Any = self
        for name in path.split("."):
            value = value.field(name) if isinstance(value, RosValue) else None
        if value is None:
            text = f"{self.name} has no field {path[:80]}"
            raise RosMessageError(text)
        return value


@dataclass(frozen=True, slots=True, eq=False)
class TypedValue(RosValue):
    """A message of a type of ROS.

    Attributes:
        type: Its type.
        values: The values of its fields, in their order.
    """

    type: RosType
    values: tuple[Any, ...]

    @property
    def name(self) -> str:
        """The name of its type."""
        return self.type.name

    def field(self, name: str) -> Any:  # noqa: ANN401 - fields have any type
        """The value of an own field; None: there is none."""
        at = self.type.place(name)
        return None if at < 0 else _of_type(self.type.fields[at], self.values[at])

    def fields(self) -> Iterator[tuple[str, Any]]:
        """Name and value of each field."""
        for each, value in zip(self.type.fields, self.values, strict=True):
            yield each.name, _of_type(each, value)


class NamedValue(RosValue):
    """A message whose fields have names and any values: mappings, lists, bytes, numbers, texts."""

    def __init__(self, name: str, values: Mapping[str, Any]) -> None:
        self._name = name
        self._values = values

    @property
    def name(self) -> str:
        """The name of its type."""
        return self._name

    def field(self, name: str) -> Any:  # noqa: ANN401 - fields have any type
        """The value of an own field; None: there is none."""
        return _named(f"{self._name}.{name}", self._values.get(name))

    def fields(self) -> Iterator[tuple[str, Any]]:
        """Name and value of each field."""
        for name in self._values:
            yield name, self.field(name)


def _of_type(each: RosField, value: Any) -> Any:  # noqa: ANN401 - fields have any type
    if isinstance(each.kind, str):
        return tuple(value) if isinstance(value, list) else value
    if each.count is None:
        return TypedValue(each.kind, value)
    return tuple(TypedValue(each.kind, item) for item in value)


def _named(name: str, value: Any) -> Any:  # noqa: ANN401 - fields have any type
    if isinstance(value, dict):
        return NamedValue(name, value)
    if isinstance(value, bytes | memoryview):
        return np.frombuffer(value, np.uint8)
    if not isinstance(value, list):
        return value
    if value and all(isinstance(each, int | float) for each in value):
        whole = all(isinstance(each, int) and abs(each) < 1 << 63 for each in value)
        return np.array(value, np.int64 if whole else np.float64)
    return tuple(_named(name, each) for each in value)
