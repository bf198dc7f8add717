"""The pictures of the architecture page show the two ways as the imports are.

After a wanted change, draw them anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

import os

import pytest

from docs import draw_ways

_AGAIN = "draw them anew with python -m docs.draw_ways"


def test_the_pictures_of_the_two_ways_are_those_of_the_imports() -> None:
    for path, picture in draw_ways.pictures().items():
        if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
            path.write_text(picture, "utf-8")
        assert path.read_text("utf-8") == picture, f"{path.name} is out of date; {_AGAIN}"


def test_a_way_that_no_import_joins_is_an_error() -> None:
    with pytest.raises(LookupError, match=r"no import joins hub/pose\.py to rune_tui/app\.py"):
        draw_ways.joint("hub.pose", "rune_tui.app")
