"""Writes definitions of known types with all types that they use, as bridges send them.

In ROS 1 a time is no type of its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final

from hub.errors import RosMessageError
from hub.ros.known_types import known_text
from hub.ros.schema import NUMBERS, TEXT, full_name

_LINE: Final = "=" * 80
_FIRST_WORD: Final = re.compile(r"^([A-Za-z]\w*(?:/\w+)*)", re.MULTILINE)
_TIMES: Final = {"builtin_interfaces/Time": "time", "builtin_interfaces/Duration": "duration"}

_NONE: Final[Mapping[str, str]] = {}


def definition_text(name: str, encoding: str, more: Mapping[str, str] = _NONE) -> str:
    """The definition of a type, and after a line of `=` each type within it.

    Args:
        name: The type, such as "nav_msgs/msg/Odometry".
        encoding: "ros2msg" or "ros1msg".
        more: Fields of types besides the known ones, by their names.

    Raises:
        RosMessageError: The type is not known.
    """
    old = encoding == "ros1msg"
    texts = {full_name(name): _text(full_name(name), more, old=old)}
    waiting = [full_name(name)]
    while waiting:
        for used in _used(texts[waiting.pop(0)]):
            if used not in texts:
                texts[used] = _text(used, more, old=old)
                waiting.append(used)
    first, *others = texts.items()
    parts = (f"{_LINE}\nMSG: {short_name(used)}\n{text}" for used, text in others)
    return first[1] + "".join(parts)


def short_name(name: str) -> str:
    """A type's name with its two parts, as ROS 1 has it: "std_msgs/Header"."""
    return name.replace("/msg/", "/").replace("/srv/", "/")


def _text(name: str, more: Mapping[str, str], *, old: bool) -> str:
    text = more.get(name) or known_text(name, 1 if old else 2)
    if text is None:
        refusal = f"{name[:80]} is no type that Rune knows"
        raise RosMessageError(refusal)
    if old:
        text = _FIRST_WORD.sub(lambda found: _TIMES.get(found[1], found[1]), text)
    return text


def _used(text: str) -> Iterator[str]:
    """The types of the fields that are none of the language's own."""
    for kind in _FIRST_WORD.findall(text):
        if kind not in NUMBERS and kind not in (TEXT, *_TIMES.values()):
            yield full_name(kind)
