"""How much of the time a vehicle is driven over a radio that loses frames, and how fast it is.

The driver's state machine and the simulated autopilots share a simulated clock. Each drive begins
after the vehicle was armed; a share is of all drives of a kind and a loss.
"""

from __future__ import annotations

from benchmarks.figures import report, say
from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.profiles.profile import Setpoint
from tests.support.simulated_radio import RadioDrive

_LOSSES = (0.1, 0.2, 0.3)
_DELAY_S = 0.03
_SECONDS = 300.0
_SEEDS = (1, 2)
_SPEEDS = {"rover": 0.5, "sub": 0.3, "blimp": 0.15}


def main() -> None:
    """Measure all kinds with all losses."""
    for kind, speed in _SPEEDS.items():
        for loss in _LOSSES:
            say(f"{kind}, {loss:.0%} lost each way")
            driving = learning = travelled = 0.0
            for seed in _SEEDS:
                drive = RadioDrive(kind, seed, depth=5.0 if kind == "sub" else 0.0)
                drive.up.loss = drive.down.loss = loss
                drive.up.delay = drive.down.delay = _DELAY_S
                drive.drive()
                drive.wanted = Setpoint(ahead=speed)
                drive.run(6.0)
                drive.phases.clear()
                begun = drive.travelled
                drive.run(_SECONDS)
                driving += drive.share(AutopilotPhase.DRIVING) / len(_SEEDS)
                learning += drive.share(AutopilotPhase.LEARNING) / len(_SEEDS)
                travelled += (drive.travelled - begun) / _SECONDS / len(_SEEDS)
            note = f"{learning:.1%} learning, {travelled:.3f} m/s of {speed} m/s"
            name = f"mavlink_radio.{kind}_{100.0 * loss:.0f}_driving_percent"
            report(name, 100.0 * driving, "%", bar=99.9, better="higher", note=note)


if __name__ == "__main__":
    main()
