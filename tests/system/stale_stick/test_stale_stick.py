"""The oldest fault of the field, the stale stick: a robot that follows an old command of a stick.

`make soak` repeats each case, at random moments, directions and speeds, and holds it to the times.
On a machine that others use as well, the driver itself is held up at times. That time is written,
and does not count.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.support.bodies import REST_S
from tests.support.fake_hid import needs_virtual_devices
from tests.system.stale_stick.actions import Scene
from tests.system.stale_stick.cases import CASES, Case, play

pytestmark = needs_virtual_devices

REPETITIONS = 30


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("case", "count"),
    [pytest.param(each, 1, id=f"once-{each.id}") for each in CASES if not each.covered]
    + [
        pytest.param(each, REPETITIONS, id=f"often-{each.id}", marks=pytest.mark.soak)
        for each in CASES
    ],
)
def test_the_robot_stops_and_stands_until_it_is_driven_from_neutral(
    scene: Scene, case: Case, count: int, tell: Callable[..., None]
) -> None:
    play(scene, case, count, REST_S["magellan"], tell)
