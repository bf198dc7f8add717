"""Shapes that messages have in tests of definitions."""

from __future__ import annotations

import dataclasses
import enum
from dataclasses import dataclass
from typing import Any

from hub.ipc.definition import MessageDefinition


class Mode(enum.IntEnum):
    OFF = 0
    ON = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    x: int
    y: int


@dataclass(frozen=True, slots=True, kw_only=True)
class One:
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Nothing:
    pass


@dataclass(frozen=True, slots=True, kw_only=True)
class Even:
    number: int

    def __post_init__(self) -> None:
        if self.number % 2:
            text = "odd"
            raise ValueError(text)


@dataclass(kw_only=True)
class Open:
    x: int
    y: int


def define(kind: type[Any], text: str) -> MessageDefinition[Any]:
    return MessageDefinition(name="M", format=text, type=kind)


def payload(definition: MessageDefinition[Any], value: Any) -> bytes:
    return b"".join(definition.encode(value))


def plain(value: Any) -> Any:
    """The value with a mapping for every dataclass in it."""
    if dataclasses.is_dataclass(value):
        return {each.name: plain(getattr(value, each.name)) for each in dataclasses.fields(value)}
    return [plain(item) for item in value] if isinstance(value, tuple) else value
