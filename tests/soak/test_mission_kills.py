"""Two hundred kills while somebody marks: nothing that was confirmed is lost."""

from __future__ import annotations

import os
import random
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from tests.system.mission_site import Site, killed_often

pytestmark = [pytest.mark.soak, pytest.mark.timeout(3600)]
KILLS = int(os.environ.get("RUNE_KILLS", "200"))


def test_two_hundred_kills_lose_no_confirmed_mark(
    tmp_path: Path, tell: Callable[..., None]
) -> None:
    with closing(Site(tmp_path)) as site:
        victims = random.Random(1).choices(["mapping", "console", "daemon"], [6, 2, 1], k=KILLS)
        counts = killed_often(site, victims, seed=1)
    tell(bars={"nothing is lost": counts["lost"] == 0, "marks": counts["confirmed"] > 0}, **counts)
