"""Rigs that end with their test.

What the long tests last is set in the environment: RUNE_SOAK_ROUNDS (deaths of central),
RUNE_SOAK_STUCK_S, RUNE_SOAK_DEAD_S, RUNE_SOAK_CROWD_S, RUNE_SOAK_CONNECTIONS, RUNE_SOAK_FRAMES,
RUNE_SOAK_ATTACK_S (an attack ends then at the latest) and RUNE_SOAK_MINUTES (the long run).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.soak.rig import Rig


@pytest.fixture
def make_rig(tmp_path: Path) -> Iterator[Callable[..., Rig]]:
    """Makes rigs: see `Rig`."""
    made: list[Rig] = []

    def make(**options: Any) -> Rig:
        folder = tmp_path / f"rig{len(made)}"
        folder.mkdir()
        made.append(Rig(folder, **options))
        return made[-1]

    yield make
    for rig in made:
        rig.close()
