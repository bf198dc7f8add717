"""A robot with any body stops when its commands end, and stands until it is driven from neutral.

The cases are those of `stale_stick`. Thrust or wheels are commanded to stop within the same time
for all bodies; each kind has its own time until it is at rest. `make soak` plays all cases.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from tests.conftest import leaving_nothing
from tests.support.bodies import BODIES, CARRIER, REST_S, STILL
from tests.support.fake_hid import needs_virtual_devices
from tests.system import stale_stick
from tests.system.stale_stick import Case, once_and_often, play, playing
from tests.system.stale_stick_actions import Scene

pytestmark = needs_virtual_devices

REPETITIONS = 3
CASES = (
    stale_stick.UNPLUGGED,
    stale_stick.RELEASED,
    stale_stick.KILLED,
    stale_stick.ASLEEP,
    stale_stick.NETWORK_CUT,
    stale_stick.NAVIGATION_KILLED,
    stale_stick.NAVIGATION_FROZEN,
    stale_stick.HUB_KILLED,
    stale_stick.STOPPED,
)
QUICK = {
    "tracked": stale_stick.NAVIGATION_FROZEN,
    "blimp": stale_stick.KILLED,
    "rov": stale_stick.NAVIGATION_FROZEN,
    CARRIER: stale_stick.KILLED,
}
"""The case of each body in `make test`; `test_stale_stick` plays some with the Magellan."""


@pytest.fixture(scope="module", autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """The processes that a case starts stay for the next one."""
    with leaving_nothing():
        yield


@pytest.fixture(scope="module")
def scene(
    nothing_left_behind: None,
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[Scene]:
    del nothing_left_behind
    body = str(request.param)
    folder = tmp_path_factory.mktemp(body)
    with playing(folder, body) as opened:
        yield opened


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
