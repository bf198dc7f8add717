"""A vehicle behind a radio that loses 30 % each way, through a hub of real processes."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.gcm.geometry import Twist
from tests.system.autopilot_site import AutopilotSite

AHEAD = Twist.planar(0.5, 0.0)
PARAMETERS = ("SIM_RC_FAIL=1", "FS_TIMEOUT=0.1", "FS_GCS_ENABLE=1", "FS_GCS_TIMEOUT=2")
LOOKS = 240
EVERY_S = 0.5


@pytest.mark.soak
def test_it_is_driven_and_never_learnt_again(tmp_path: Path) -> None:
    with closing(AutopilotSite(tmp_path, "rover", PARAMETERS)) as site:
        site.drive()
        site.relay.loss = 0.3
        site.go_on(12.0)  # until the loss is known
        phases = []
        for _ in range(LOOKS):
            site.operator.twist = Twist() if "release" in site.autopilot.why else AHEAD
            site.go_on(EVERY_S)
            phases.append(site.phase)
        assert phases.count(AutopilotPhase.DRIVING) >= 0.9 * LOOKS, phases
        assert AutopilotPhase.LEARNING not in phases
        assert site.autopilot.lost == pytest.approx(0.51, abs=0.2)
        assert any("of its echoes are lost" in each for each in site.problems)
