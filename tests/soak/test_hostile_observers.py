"""Ten hostile observers for some seconds: nobody who matters loses the hub, and stops are acted on.

benchmarks/hostile.py measures the same for a minute, with bars on times.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.system.attacked_hub import MIX, AttackedHub

ATTACK_S = float(os.environ.get("RUNE_SOAK_ATTACK_S", "8"))
STOPPED_S = 1.0
"""Generous: many processes share this machine [s]."""


@pytest.fixture
def attacked_hub(tmp_path: Path) -> Iterator[AttackedHub]:
    with ExitStack() as stack:
        yield AttackedHub(stack, tmp_path)


@pytest.mark.soak
@pytest.mark.timeout(300)
@pytest.mark.parametrize("attacks", [MIX, ("lists",) * 10], ids=["mix", "lists"])
def test_hostile_observers_take_the_hub_from_nobody(
    attacked_hub: AttackedHub, attacks: tuple[str, ...]
) -> None:
    with attacked_hub.attackers(attacks, ATTACK_S + 20.0):
        seen = attacked_hub.measure(ATTACK_S)
    assert seen.gone == []
    assert max(seen.stops) < STOPPED_S
    assert seen.queries
