"""Messages as tools of the ROS 2 world see them, worked out from the format alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from hub.ipc.definition import MessageDefinition
from hub.ipc.formats import grammar as formats
from hub.ipc.wire import control, definition_listing


def definition_of(tree: formats.Struct, ros_type: str = "") -> MessageDefinition[Any]:
    """A definition of a format, with the fields a0, a1 and so on, b0 inside them and so on."""
    entry = control.Define(
        name="Random_Message",
        format=str(tree),
        fields=_fields(tree, 0),
        keep="newest",
        plane="state",
        rate_hz=0.0,
        lifespan_s=1.0,
    )
    listed = definition_listing.from_listing(entry)
    kind = type(listed.type.__name__, (listed.type,), {"__slots__": (), "ros_type": ros_type})
    return MessageDefinition(name=listed.name, format=listed.format, type=kind)


def _fields(node: formats.Struct, depth: int) -> str:
    return ", ".join(
        f"{chr(ord('a') + depth)}{place}{_inner(member, depth + 1)}"
        for place, member in enumerate(node.members)
    )


def _inner(node: formats.Format, depth: int) -> str:
    if isinstance(node, formats.Struct):
        return "{" + _fields(node, depth) + "}"
    if isinstance(node, formats.Pointer):
        sign, inside = "*", node.target
    elif isinstance(node, (formats.FixedArray, formats.VariableArray)):
        sign, inside = "[]", node.element
    else:
        return ""
    shown = _inner(inside, depth)
    return sign + shown if shown else ""


def ros_value(tree: formats.Struct, value: Any) -> list[Any]:
    """The value of a message, every struct as the list of its fields."""
    if tree.next_place is not None:
        return [_nodes(tree, value)]
    return _struct(tree, value)


def _struct(node: formats.Struct, value: Any) -> list[Any]:
    return [
        _field(member, item)
        for member, item in zip(node.members, value, strict=True)
        if not isinstance(member, formats.SelfPointer)
    ]


def _nodes(node: formats.Struct, value: Any) -> list[Any]:
    nodes = []
    while value is not None:
        nodes.append(_struct(node, value))
        value = value[node.next_place]
    return nodes


def _field(node: formats.Format, value: Any) -> Any:
    if isinstance(node, formats.Struct):
        return _struct(node, value) if node.next_place is None else _nodes(node, value)
    if isinstance(node, formats.Pointer):
        if _is_list(node.target):
            return _nodes(node.target, value)
        return [] if value is None else [_element(node.target, value)]
    if isinstance(node, formats.FixedArray):
        element, items = node.element, _items(value)
        while isinstance(element, formats.FixedArray):
            items = [inner for item in items for inner in _items(item)]
            element = element.element
        return [_element(element, item) for item in items]
    if isinstance(node, formats.VariableArray):
        return [_element(node.element, item) for item in _items(value)]
    return value


def _items(value: Any) -> list[Any]:
    return value.reshape(-1).tolist() if isinstance(value, np.ndarray) else list(value)


def _is_list(node: formats.Format) -> bool:
    return isinstance(node, formats.Struct) and node.next_place is not None


def _element(node: formats.Format, value: Any) -> Any:
    """An element: arrays and lists have a struct of one field around them."""
    single = (formats.Primitive, formats.Enum)
    plain = isinstance(node, single) or (isinstance(node, formats.Struct) and not _is_list(node))
    return _field(node, value) if plain else [_field(node, value)]
