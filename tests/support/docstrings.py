"""What docstrings say, for pages that are made from them."""

from __future__ import annotations

import inspect
import re
from typing import Any


def meanings(kind: type[Any]) -> dict[str, str]:
    """What the docstrings of a dataclass and its bases say of its fields."""
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        section = inspect.cleandoc(each.__doc__ or "").partition("Attributes:\n")[2]
        for entry in re.split(r"\n(?=    \w)", f"\n{section}")[1:]:
            name, _, text = entry.strip().partition(": ")
            found[name] = " ".join(text.split())
    return found
