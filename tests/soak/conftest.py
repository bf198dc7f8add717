"""Rigs that end with their test, and the line of figures that each test writes.

What the long tests last is set in the environment: RUNE_SOAK_ROUNDS (deaths of central),
RUNE_SOAK_STUCK_S, RUNE_SOAK_DEAD_S, RUNE_SOAK_CROWD_S, RUNE_SOAK_CONNECTIONS, RUNE_SOAK_FRAMES,
RUNE_SOAK_ATTACK_S (an attack ends then at the latest) and RUNE_SOAK_MINUTES (the long run).
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.soak.rig import Rig


def _finite(value: Any) -> Any:
    """The same without what JSON cannot say; what never happened has no figure."""
    if isinstance(value, dict):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(each) for each in value]
    return value if not isinstance(value, float) or math.isfinite(value) else None


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


@pytest.fixture
def tell(request: pytest.FixtureRequest, capfd: pytest.CaptureFixture[str]) -> Callable[..., None]:
    """Writes one JSON line with the test's name and figures, past pytest's capture.

    Then every bar has to hold: a test that fails tells of all it has found, not of the first.
    """

    def write(*, bars: dict[str, bool], **figures: Any) -> None:
        failed = [bar for bar, holds in bars.items() if not holds]
        with capfd.disabled():
            line = json.dumps({"test": request.node.name, **_finite(figures), "failed": failed})
            sys.stdout.write(f"\n{line}\n")
            sys.stdout.flush()
        assert failed == []

    return write
