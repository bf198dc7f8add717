"""The place of a click where viewports lie over each other."""

from __future__ import annotations

import pytest

from rune_tui.controls.events import ControlEvent, Hit
from rune_tui.model.world import WorldPoint
from rune_tui.widgets.pointing import place_of

FAR, NEAR = (WorldPoint(x=x, y=0.0, uncertainty=0.1) for x in (5.0, 1.0))
LARGE = Hit(viewport="large", x=0.5, y=0.5, place=FAR, robot="rover", in_picture=(0.5, 0.5))
LINES = Hit(viewport="lines", x=0.5, y=0.5, robot="rover")
MAP = Hit(viewport="map", x=0.5, y=0.5, place=NEAR, robot="rover")


def small(robot: str = "rover", place: WorldPoint | None = NEAR) -> Hit:
    return Hit(viewport="small", x=0.5, y=0.5, place=place, robot=robot, in_picture=(0.1, 0.2))


@pytest.mark.parametrize(
    ("hits", "viewport", "place"),
    [
        ((LARGE,), "large", FAR),
        ((LINES, LARGE), "large", FAR),
        ((LINES, LARGE), "lines", FAR),
        ((small(), LARGE), "large", NEAR),
        ((small(place=None), LARGE), "large", None),
        ((small("blimp"), LARGE), "large", None),
        ((small(), LARGE), "small", NEAR),
        ((MAP, LARGE), "large", FAR),
        ((), "large", None),
    ],
)
def test_a_click_means_the_picture_that_is_seen_there(
    hits: tuple[Hit, ...], viewport: str, place: WorldPoint | None
) -> None:
    event = ControlEvent(name="mouse left", pressed=True, hits=hits)
    assert place_of(event, viewport, "rover") is place
