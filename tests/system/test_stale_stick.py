"""The oldest fault of the field, the stale stick: a robot that follows an old command of a stick.

`make soak` repeats each case, at random moments, directions and speeds, and holds it to the times.
On a machine that others use as well, the driver itself is held up at times. That time is written,
and does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from tests.conftest import leaving_nothing
from tests.support.bodies import REST_S
from tests.support.fake_hid import needs_virtual_devices
from tests.system.stale_stick import CASES, Case, play, playing
from tests.system.stale_stick_actions import Scene

pytestmark = needs_virtual_devices

REPETITIONS = 30


@pytest.fixture(scope="module", autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """The processes that a case starts stay for the next one."""
    with leaving_nothing():
        yield


@pytest.fixture(scope="module")
def scene(nothing_left_behind: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    del nothing_left_behind
    folder = tmp_path_factory.mktemp("stale-stick")
    with playing(folder, "magellan") as opened:
        yield opened


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
