"""Profiles that tests make."""

from __future__ import annotations

import dataclasses
from typing import Any

from hub.shaper.profile import DirectionSpec, LinkProfile


def profile(**keys: Any) -> LinkProfile:
    """A profile whose directions are alike; keys of `LinkProfile` and of `DirectionSpec`."""
    own = {each.name for each in dataclasses.fields(LinkProfile)}
    one_way = DirectionSpec(**{name: value for name, value in keys.items() if name not in own})
    others = {name: value for name, value in keys.items() if name in own}
    return LinkProfile(**{"up": one_way, "down": one_way, **others})
