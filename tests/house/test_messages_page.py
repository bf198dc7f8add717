"""The page of messages says the fields as the dataclasses of `hub.gcm` declare them.

After a wanted change, write it anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

import dataclasses
import enum
import inspect
import os
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hub.gcm.catalog import MESSAGES
from hub.ipc import ros_schema
from hub.ipc.formats import grammar, ranges
from hub.ipc.formats.dataclass_codec import DataclassCodec
from tests.support.docstrings import meanings

_PAGE = Path(__file__).parents[2] / "docs" / "messages.md"
_HEAD = """# Messages, field by field

The dataclasses of `hub/gcm` declare these fields: type, range and meaning. From there come the
format on the wire, the checks of receivers and this page. The [hub guide](hub-guide.md#messages)
says who sends what to whom; the [protocol](protocol.md#formats) explains the formats.
"""

_FRAMES = ("map", "odom", "base_link")
_OVERVIEW = """## Rates, units and frames

Units are those of ROS REP 103: m, rad, s, m/s, rad/s, and 0 to 1 for shares. A field with another
one says so. Axes are x forward, y left, z up; yaw turns first, then pitch, then roll. Frames are
those of REP 105:

| frame | counts from |
| --- | --- |
| `map` | the robot's first place, corrected by what it sees |
| `odom` | the robot's place at the start of its dead reckoning, which drifts |
| `base_link` | the robot: on the ground where it turns |
| a sensor or camera, by its name | its own place, as `GCM_RobotDescription` has it |
| `NAME_optical` of a camera | the same place, with z ahead and x to the right |

A message without a rate comes at a change or on demand. Types that ROS 2 does not have are in the
package `rune_msgs`.
"""


def _values(hint: Any) -> str:
    """What a field may hold."""
    if isinstance(hint, type) and issubclass(hint, enum.IntEnum):
        return ", ".join(f"{each.value} {each.name}" for each in hint)
    said = []
    for each in ranges.declared(hint):
        if isinstance(each, ranges.Range):
            said.append(str(each))
        elif isinstance(each, ranges.Text):
            said.append(f"at most {each.most} letters")
        else:
            said.append(f"at most {each.count}")
    return "; ".join(said)


def _wire(node: grammar.Format, record: DataclassCodec | None) -> str:
    """The format, with the name of a dataclass instead of its members."""
    text = str(node)
    inner = getattr(node, "element", node)
    return text.replace(str(inner), record.kind.__name__) if record else text


def _table(record: DataclassCodec, tree: grammar.Struct) -> Iterator[str]:
    said = meanings(record.kind)
    hints = typing.get_type_hints(record.kind, include_extras=True)
    yield "| field | on the wire | values | meaning |"
    yield "| --- | --- | --- | --- |"
    for member, node in zip(record.members, tree.members, strict=True):
        meaning = said.get(member.name, "")
        if member.counts:
            meaning = f"elements of `{member.counts}`; Rune writes it"
        values = _values(hints.get(member.name))
        name = member.name if member.counts else f"`{member.name}`"
        yield f"| {name} | `{_wire(node, member.record)}` | {values} | {meaning} |"


def _inner(record: DataclassCodec, tree: Any) -> Iterator[tuple[DataclassCodec, grammar.Struct]]:
    """The dataclasses inside one, innermost first."""
    for member, node in zip(record.members, tree.members, strict=True):
        if member.record is not None:
            struct = getattr(node, "element", node)
            yield from _inner(member.record, struct)
            yield member.record, struct


def _page() -> str:
    lines = [_HEAD, *_overview(), ""]
    shown: dict[type[Any], tuple[DataclassCodec, grammar.Struct]] = {}
    for definition in MESSAGES:
        lines += [f"## {definition.name}", "", _about(definition.type), ""]
        if dataclasses.fields(definition.type):
            lines += [*_table(definition.record, definition.tree), ""]
        shown |= {each[0].kind: each for each in _inner(definition.record, definition.tree)}
    for kind, (record, tree) in shown.items():
        lines += [f"## {kind.__name__}, inside messages", "", _about(kind), ""]
        lines += [*_table(record, tree), ""]
    return "\n".join(lines).rstrip() + "\n"


def _overview() -> Iterator[str]:
    """Rates, frames and types of ROS 2 of all messages."""
    yield _OVERVIEW
    yield "| message | rate | frames | type in ROS 2 |"
    yield "| --- | --- | --- | --- |"
    for each in MESSAGES:
        inner = [record.kind for record, _ in _inner(each.record, each.tree)]
        said = "".join(kind.__doc__ or "" for kind in (each.type, *inner))
        frames = [f"`{name}`" for name in _FRAMES if f"`{name}`" in said]
        rate = f"{each.rate_hz:g} Hz" if each.rate_hz else ""
        ros = ros_schema.ros_type(each) if dataclasses.fields(each.type) else ""
        yield f"| `{each.name}` | {rate} | {', '.join(frames)} | `{ros}` |"


def _about(kind: type[Any]) -> str:
    return inspect.cleandoc(kind.__doc__ or "").partition("\nAttributes:")[0].strip()


def test_page_of_messages_is_that_of_the_dataclasses() -> None:
    wanted = _page()
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        _PAGE.write_text(wanted)
    assert _PAGE.read_text() == wanted, "write it anew, as this file's docstring says"


def test_every_field_has_a_meaning() -> None:
    missing = [
        f"{record.kind.__name__}.{member.name}"
        for definition in MESSAGES
        for record, _ in [*_inner(definition.record, definition.tree), (definition.record, None)]
        for member in record.members
        if not member.counts and not meanings(record.kind).get(member.name)
    ]
    assert not missing, f"say in the docstring what these are: {sorted(set(missing))}"


def test_the_hub_guide_says_of_each_message_where_it_comes_from() -> None:
    guide = (_PAGE.parent / "hub-guide.md").read_text()
    rows = "".join(line for line in guide.splitlines() if line.startswith("| `"))
    missing = [each.name for each in MESSAGES if f"`{each.name}`" not in rows]
    assert not missing, f"docs/hub-guide.md has no row for them: {missing}"
