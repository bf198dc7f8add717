"""One scene for all cases of a file that are played with the same body."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.conftest import leaving_nothing
from tests.system.stale_stick.actions import Scene
from tests.system.stale_stick.cases import playing


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
    """A driven robot; a file names its body as the parameter, if it is not the Magellan."""
    del nothing_left_behind
    body = str(getattr(request, "param", "magellan"))
    with playing(tmp_path_factory.mktemp(body), body) as opened:
        yield opened
