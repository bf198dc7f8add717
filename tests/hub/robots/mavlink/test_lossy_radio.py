"""A radio loses or delays frames: how long a vehicle is driven, and from when on it is not."""

import pytest

from hub.gcm.autopilot import AutopilotPhase
from hub.robots.mavlink.profiles.profile import Setpoint
from hub.robots.mavlink.vehicle.reasons import warnings
from tests.support.mavlink_numbers import GUIDED, INTERVAL
from tests.support.repetitions import repetitions
from tests.support.scripted_autopilot import ScriptedAutopilot, in_phase, reason
from tests.support.simulated_radio import RadioDrive

SPEEDS = {"rover": 0.5, "sub": 0.3, "blimp": 0.15}


@pytest.mark.parametrize("seed", range(repetitions(2, 40)))
@pytest.mark.parametrize("kind", SPEEDS)
def test_with_a_loss_of_30_percent_each_way_it_is_driven_and_never_learnt_again(kind, seed):
    drive = RadioDrive(kind, seed, depth=5.0 if kind == "sub" else 0.0)
    drive.up.loss = drive.down.loss = 0.3
    drive.up.delay = drive.down.delay = 0.03
    drive.drive()
    drive.run(12.0)  # the loss is known after 10 s
    drive.wanted = Setpoint(ahead=SPEEDS[kind])
    drive.run(6.0)
    drive.phases.clear()
    began = drive.travelled
    drive.run(60.0)
    assert drive.share(AutopilotPhase.DRIVING) >= 0.9
    assert drive.learnt == []
    assert (drive.travelled - began) / 60.0 >= 0.9 * SPEEDS[kind]
    assert drive.vehicle.liveness.lost(drive.now) == pytest.approx(0.51, abs=0.2)
    assert "of its echoes are lost" in " ".join(warnings(drive.vehicle, drive.now))


@pytest.mark.parametrize("seconds", [1.5, 3.0, 20.0])
def test_after_a_cut_it_is_driven_again_from_neutral_without_learning(seconds):
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.run(1.0)
    bench.deaf = bench.mute = True
    bench.run(seconds)
    assert bench.vehicle.phase is AutopilotPhase.GONE
    since, streams = bench.now + 0.001, len(bench.commands(INTERVAL))
    bench.deaf = bench.mute = False
    phases = set()
    while bench.vehicle.phase is not AutopilotPhase.DRIVING and bench.now < since + 5.0:
        bench.run(0.02)
        bench.velocity(ahead=0.5)
        phases.add(bench.vehicle.phase)
    assert phases == {AutopilotPhase.GONE, AutopilotPhase.DRIVING}
    assert bench.vehicle.must_be_neutral
    assert not list(bench.moving(since))
    assert len(bench.commands(INTERVAL)) == streams


@pytest.mark.parametrize(
    ("uptime", "gone", "since_boot"), [(60.0, 5.0, 2.0), (10.0, 60.0, 55.0), (3600.0, 30.0, 20.0)]
)
def test_a_boot_while_it_was_gone_is_noticed_and_it_is_learnt_again(uptime, gone, since_boot):
    bench = ScriptedAutopilot()
    bench.booted = bench.now - uptime
    bench.driving()
    bench.deaf = bench.mute = True
    bench.run(gone - since_boot)
    bench.boot()
    bench.armed, bench.mode = True, GUIDED  # nothing in its heartbeats shows the boot
    bench.run(since_boot)
    bench.deaf = bench.mute = False
    in_phase(bench, AutopilotPhase.LEARNING)
    assert reason(bench) == "it was booted"
    in_phase(bench, AutopilotPhase.ELSEWHERE)


def test_a_vehicle_that_does_not_answer_gets_neutral_sticks_while_its_mode_is_known():
    bench = ScriptedAutopilot().driving()
    bench.velocity(ahead=0.5)
    bench.deaf = True  # its heartbeats still come
    in_phase(bench, AutopilotPhase.GONE)
    since = bench.now + 0.001
    bench.velocity(ahead=0.5)
    bench.run(2.0)
    assert bench.names(since).count("MANUAL_CONTROL") >= 15
    bench.run(3.0)
    assert not list(bench.moving(since))
    assert "MANUAL_CONTROL" not in bench.names(bench.now - 1.5)


@pytest.mark.parametrize(
    ("delay", "words"),
    [(0.02, ""), (0.25, "its answers take 0.5 s"), (0.35, "its answers take 0.7 s")],
)
def test_a_delay_is_said(delay, words):
    drive = RadioDrive("rover", seed=1)
    drive.up.delay = drive.down.delay = delay
    drive.drive()
    drive.run(5.0)
    assert drive.vehicle.phase is AutopilotPhase.DRIVING
    assert words in " ".join(warnings(drive.vehicle, drive.now))
    assert bool(words) == bool([*warnings(drive.vehicle, drive.now)])


@pytest.mark.parametrize("delay", [0.6, 1.0, 3.0])
def test_a_delay_of_more_than_a_second_is_not_driven(delay):
    drive = RadioDrive("rover", seed=1)
    drive.drive()
    drive.wanted = Setpoint(ahead=0.5)
    drive.run(2.0)
    drive.up.delay = drive.down.delay = delay
    drive.until(AutopilotPhase.GONE, 4.0)
    drive.phases.clear()
    drive.run(20.0)
    assert drive.share(AutopilotPhase.DRIVING) == 0.0
    assert drive.why.startswith(f"its answers take {2.0 * delay:.1f} s, and it is driven up to 0.8")
    assert abs(drive.world.motion.state.ahead) < 0.02


def test_a_vehicle_that_answers_late_from_the_start_is_never_driven():
    drive = RadioDrive("rover", seed=1)
    drive.up.delay = drive.down.delay = 1.0
    drive.run(10.0)
    assert drive.vehicle.phase is AutopilotPhase.GONE
    assert drive.why.startswith("its answers take 2.0 s")
