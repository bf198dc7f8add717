"""The model of an operator does what it says of itself."""

from __future__ import annotations

import numpy as np
import pytest

from rune_study.simulate.operator_model import OperatorModel, run

LONG = OperatorModel(seconds=200_000.0)


def test_the_same_seed_gives_the_same_trial() -> None:
    first, again, other = (run(OperatorModel(robots=2), seed) for seed in (1, 1, 2))
    assert all(
        np.array_equal(one.inputs, two.inputs)
        for one, two in zip(first.robots, again.robots, strict=True)
    )
    assert not np.array_equal(first.robots[0].inputs, other.robots[0].inputs)


def test_times_have_the_stated_means_and_median() -> None:
    trial = run(LONG, 3)
    assert np.mean(trial.tolerances) == pytest.approx(25.0, rel=0.03)
    assert np.median(trial.tolerances) == pytest.approx(LONG.tolerance_median, rel=0.03)
    assert np.mean(trial.interactions) == pytest.approx(6.0, rel=0.03)


def test_a_robot_works_for_one_operator_less_only_while_he_notices() -> None:
    (robot,) = run(LONG, 4).robots
    served = np.array([end for _, end in robot.working])[:-1]
    assert np.allclose(robot.selections[1:] - served, LONG.notice_s)


def test_more_robots_than_the_fan_out_add_no_work() -> None:
    def at_work(robots: int) -> float:
        model = OperatorModel(robots=robots, seconds=40_000.0)
        times = np.arange(0.0, model.seconds, 0.5)
        return float(sum(robot.rate(times).mean() for robot in run(model, 5).robots))

    assert OperatorModel().fan_out == pytest.approx(31 / 6)
    assert at_work(2) == pytest.approx(2 * 31 / 33, rel=0.05)
    assert at_work(12) == pytest.approx(31 / 6, rel=0.06)


def test_foresight_comes_before_the_stand_unless_a_probe_keeps_him_away() -> None:
    def share_seen(model: OperatorModel) -> float:
        (robot,) = run(model, 6).robots
        ends = robot.working[:-1, 1]
        return float(np.mean(ends < robot.selections[1:] - 1e-9))

    foresees = OperatorModel(foresight=0.5, seconds=100_000.0)
    probed = OperatorModel(foresight=0.5, probe_share=0.5, seconds=100_000.0)
    assert share_seen(foresees) == pytest.approx(0.5, abs=0.03)
    assert share_seen(probed) == pytest.approx(0.75, abs=0.03)
