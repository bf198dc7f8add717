"""Hashes of types, as ROS 2 computes them since Iron: REP 2011, RIHS01; pure.

The hash is over a text in JSON with all fields of the type and of those within it.
"""

from __future__ import annotations

import functools
import hashlib
import json
from typing import Any, Final

from hub.errors import RosMessageError
from hub.ros.known_types import known_text, known_texts
from hub.ros.schema import EMPTY, FieldText, full_name, msg_fields

_NUMBERS: Final = (
    *("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"),
    *("float32", "float64", "float128", "char", "wchar", "bool", "byte", "string"),
)
_FIRST, _ARRAY, _SEQUENCE = 2, 48, 144
"""Identities of types: of the first number, and the difference for arrays and sequences."""


def type_hash(name: str) -> str:
    """The hash of a type of `known_types`, such as "RIHS01_5f0f..."; empty: it is not known.

    Args:
        name: Such as "geometry_msgs/msg/TwistStamped".
    """
    return _hash(full_name(name), "")


def later_definition(name: str, hash_text: str) -> str:
    """The definition of a known type that got fields after ROS 2 Humble; empty: it is as it was.

    Args:
        name: Such as "sensor_msgs/msg/Range".
        hash_text: The hash with which a node has it.
    """
    later = known_texts().get(name, ())[1:]
    return next((text for text in later if _hash(name, text) == hash_text), "")


@functools.cache
def _hash(name: str, text: str) -> str:
    found: dict[str, Any] = {}
    try:
        _describe(name, found, text)
    except RosMessageError:
        return ""
    whole = {
        "type_description": found.pop(name),
        "referenced_type_descriptions": [found[each] for each in sorted(found)],
    }
    return f"RIHS01_{hashlib.sha256(json.dumps(whole).encode()).hexdigest()}"


def _describe(name: str, found: dict[str, Any], text: str | None = None) -> None:
    """Add a type with these fields, or those that are known, and those within it."""
    text = text or known_text(name)
    if text is None or "<=" in text:  # `msg_fields` leaves limits out
        refusal = f"the hash of {name[:80]} is not known"
        raise RosMessageError(refusal)
    described: dict[str, Any] = {"type_name": name}
    found[name] = described
    fields = tuple(msg_fields(text)) or (FieldText("uint8", EMPTY, None),)
    described["fields"] = [_field(each, name.rpartition("/")[0], found) for each in fields]


def _field(field: FieldText, package: str, found: dict[str, Any]) -> dict[str, Any]:
    inner, kind = "", 1
    number = "uint8" if field.kind == "char" else field.kind  # the generators of ROS 2 do so
    if number in _NUMBERS:
        kind = _FIRST + _NUMBERS.index(number)
    else:
        spelt = "std_msgs/Header" if field.kind == "Header" else field.kind
        inner = full_name(spelt) if "/" in spelt else f"{package}/{spelt}"
        if inner not in found:
            _describe(inner, found)
    if field.count is not None:
        kind += _ARRAY if field.count else _SEQUENCE
    return {
        "name": field.name,
        "type": {
            "type_id": kind,
            "capacity": field.count or 0,
            "string_capacity": 0,
            "nested_type_name": inner,
        },
    }
