"""A robot with any body stops when its commands end, and stands until it is driven from neutral.

The cases are those of `cases.py`. Thrust or wheels are commanded to stop within the same time
for all bodies; each kind has its own time until it is at rest. `make soak` plays all cases.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.support.bodies import BODIES, CARRIER, REST_S, STILL
from tests.support.fake_hid import needs_virtual_devices
from tests.system.stale_stick import cases
from tests.system.stale_stick.actions import Scene
from tests.system.stale_stick.cases import Case, once_and_often, play

pytestmark = needs_virtual_devices

REPETITIONS = 3
CASES = (
    cases.UNPLUGGED,
    cases.RELEASED,
    cases.KILLED,
    cases.ASLEEP,
    cases.NETWORK_CUT,
    cases.NAVIGATION_KILLED,
    cases.NAVIGATION_FROZEN,
    cases.HUB_KILLED,
    cases.STOPPED,
)
QUICK = {
    "tracked": cases.NAVIGATION_FROZEN,
    "blimp": cases.KILLED,
    "rov": cases.NAVIGATION_FROZEN,
    CARRIER: cases.KILLED,
}
"""The case of each body in `make test`; `test_stale_stick` plays some with the Magellan."""


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("scene", "body", "case", "count"),
    once_and_often(QUICK, BODIES, CASES, REPETITIONS),
    indirect=["scene"],
)
def test_it_stops_and_stands_until_it_is_driven_from_neutral(
    scene: Scene, body: str, case: Case, count: int, tell: Callable[..., None]
) -> None:
    play(scene, case, count, REST_S[body], tell, rolls=body not in STILL)
