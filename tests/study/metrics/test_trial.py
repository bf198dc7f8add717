"""All metrics of a trial: of one that is known in full, of an empty one, and of models."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from rune_study.estimate import Estimate
from rune_study.metrics.awareness import AnswerKind, Query
from rune_study.metrics.effectiveness import Signal, signal
from rune_study.metrics.questionnaires import TLX_SCALES
from rune_study.metrics.registry import METRICS, measure
from rune_study.metrics.trial import (
    Contacts,
    MeasureSpec,
    Motion,
    Questionnaires,
    RobotData,
    Secondary,
    Travel,
    TrialData,
)
from rune_study.metrics.victims import Mark
from rune_study.simulate.operator_model import OperatorModel
from tests.support.cases import for_each
from tests.support.recovery import measured


def progress(*ends: tuple[float, float]) -> Signal:
    """Progress of 1 per second within spans of a trial of 100 s."""
    times = np.arange(1001) / 10
    return signal(times, sum(np.clip(times - begin, 0, end - begin) for begin, end in ends))


ROBOT = RobotData(
    name="rover",
    inputs=np.array([5, 7, 8.5, 9.75, 34, 34.5, 66, 67, 69, 71]),
    selections=np.array([33.0, 65.0]),
    progress=progress((0, 30), (34, 60), (66, 100)),
    travel=Travel(x=np.array([0, 3, 3]), y=np.array([0, 0, 4]), shortest=5.0, arrived=True),
    motion=Motion(
        times=np.array([0.0, 40.0]),
        linear=np.array([0.3, 0.3]),
        angular=np.zeros(2),
        pan=np.array([0.0, 1.0]),
    ),
    contacts=Contacts(
        times=np.array([0.0, 1.0, 2.5]),
        counts=np.array([0, 1, 2]),
        bumpers=np.array([0, 1, 0]),
        linear=np.array([0.1, 0.1, -0.1]),
    ),
    stick=signal([0, 30, 60], [0, 1, 0]),
)
FULL = TrialData(
    length=100.0,
    robots=(ROBOT,),
    marks=(Mark(time=20, x=1.2, y=1), Mark(time=30, x=9, y=9)),
    victims=np.array([(1, 1), (5, 5)]),
    seen=np.array([[1, 1], [0, 1]], bool),
    reachable=np.array([[1, 1], [1, 0]], bool),
    marked=np.array([(0, 0), (9, 9)]),
    surface=np.array([(0, 0.05)]),
    photons=np.array([0.1, 0.2, 0.3, math.nan]),
    queries=(Query(level=1, kind=AnswerKind.NUMBER, answer=3, truth=3),),
    secondary=Secondary(correct=30, seconds=100, correct_alone=40, seconds_alone=100),
    questionnaires=Questionnaires(tlx=dict.fromkeys(TLX_SCALES, 40), sus=(3,) * 10, sart=(4,) * 10),
)


def test_a_trial_by_hand() -> None:
    found = {name: each.value for name, each in measure(FULL).items() if each.known}
    wanted = {
        "te_mean": 0.9,
        "completion": 1,
        "episodes": 3,
        # 5 to 9.75, 33 to 34.5, 65 to 71
        "ie_mean": (4.75 + 1.5 + 6) / 3,
        "ie_inputs": 10 / 3,
        "rad_mission": 0.1225,
        "nt_seen": 2 / 3,
        "fo_measured": 0.92,
        "ft_secondary": 0.75,
        "first_victim": 20,
        "victims_found": 1,
        "victims_fraction": 0.5,
        "victims_false": 1,
        "victims_precision": 0.5,
        "victims_error": 0.2,
        "coverage": 2 / 3,
        "map_f1": 2 / 3,
        "map_precision": 0.5,
        "map_recall": 1,
        "bumps": 2,
        "bumps_front": 1,
        "bumps_rear": 1,
        "bumps_side": 0,
        "driven": 7,
        "path_ratio": 1.4,
        "spl": 5 / 7,
        "reversals_stick_fine": 1.2,
        "reversals_stick_coarse": 1.2,
        "camera_off_centre": 0.6,
        "command_rate": 0.1,
        "photon_p50": 0.2,
        "photon_p95": 0.29,
        "photon_missing": 1,
        "sagat_1": 1,
        "sagat_unanswered": 0,
        "tlx_raw": 40,
        "sus": 50,
        "sart": 16,
    }
    # TE falls to half where the work ends; its next sample is 0.1 s later.
    assert found.pop("nt_median") == pytest.approx(25.5, abs=0.11)
    tolerance = found.pop("nt_restricted_mean")
    assert tolerance == pytest.approx((20.25 + 25.5 + 29) / 3, abs=0.11)
    derived = {name: found.pop(name) for name in ("rad", "ft", "fo")}
    assert found == pytest.approx(wanted, abs=0.011)
    assert derived["fo"] == pytest.approx(1 + tolerance / found["ie_mean"])
    assert derived["rad"] == pytest.approx(1 / derived["fo"])
    assert derived["ft"] == pytest.approx(1 - derived["rad"])


@for_each("trial", [TrialData(length=0.0), TrialData(length=60.0, robots=(RobotData(name="r"),))])
def test_what_was_not_recorded_has_a_reason(trial: TrialData) -> None:
    found = measure(trial)
    assert set(found) == set(METRICS)
    for name, each in found.items():
        assert each.known != math.isnan(each.value), name
    known = {name for name, each in found.items() if each.known}
    assert known <= {"episodes", "rad_mission", "command_rate"}


@for_each(
    ("changes", "name", "why"),
    [
        ({"progress": None}, "nt_median", "no progress was recorded"),
        ({"progress": progress((80, 90))}, "fo", "no progress while the operator attended"),
        ({"inputs": np.empty(0)}, "ie_mean", "no interaction"),
        ({"inputs": np.empty(0)}, "rad", "no interaction"),
        (
            {"progress": progress((0, 100))},
            "nt_restricted_mean",
            "only 0 of 3 neglects ended with a drop",
        ),
        ({"travel": dataclasses.replace(ROBOT.travel, arrived=False)}, "path_ratio", "reached"),
        ({"wheel": None}, "reversals_visual", "steered by a wheel"),
    ],
)
def test_what_cannot_be_known_says_why(changes, name: str, why: str) -> None:
    trial = dataclasses.replace(FULL, robots=(dataclasses.replace(ROBOT, **changes),))
    found = measure(trial)[name]
    assert why in found.why
    assert math.isnan(found.value)


@for_each(
    ("changes", "names"),
    [
        ({"stick": signal([0, 30], [0, math.nan])}, {"fine", "coarse"}),
        ({"keys": signal([0, 30], [0, math.inf])}, {"reversals_keys"}),
        ({"progress": Signal(times=np.zeros(3), values=np.zeros(2))}, {"nt_median", "fo"}),
        ({"inputs": np.array([3.0, math.nan])}, {"ie_mean", "fo", "rad_mission", "nt_seen"}),
        ({"motion": Motion(times=np.zeros(3), linear=np.zeros(2), angular=np.zeros(3),
                           pan=np.zeros(3))}, {"camera_off_centre"}),
    ],
)  # fmt: skip
def test_bad_data_cost_only_the_metrics_that_need_them(changes, names: set[str]) -> None:
    trial = dataclasses.replace(FULL, robots=(dataclasses.replace(ROBOT, **changes),))
    found, whole = measure(trial), measure(FULL)
    lost = {name for name, each in found.items() if "cannot be used" in each.why}
    for name in names:
        assert any(each.endswith(name) for each in lost)
    others = set(METRICS) - lost - {"command_rate", "episodes"}
    assert {name: found[name] for name in others if whole[name].known} == {
        name: whole[name] for name in others if whole[name].known
    }


def test_the_interval_of_free_time_is_that_of_demand() -> None:
    found = measure(FULL)
    demand, free, robots = (found[name] for name in ("rad", "ft", "fo"))
    assert (free.low, free.high) == (1 - demand.high, 1 - demand.low)
    assert (demand.low, demand.high) == (1 / robots.high, 1 / robots.low)
    assert 0 < demand.low < demand.value < demand.high < 1


def test_a_robot_that_does_not_arrive_has_no_success() -> None:
    travel = dataclasses.replace(ROBOT.travel, arrived=False)
    found = measure(dataclasses.replace(FULL, robots=(dataclasses.replace(ROBOT, travel=travel),)))
    assert found["spl"].value == found["completion"].value == 0


def test_the_bound_of_the_restricted_mean_is_named() -> None:
    assert measure(FULL, MeasureSpec(tau=20.0))["fo"].note == "restricted to 20 s"
    assert "restricted to 29" in measure(FULL)["nt_restricted_mean"].note


def test_attention_of_two_robots_counts_once() -> None:
    two = dataclasses.replace(FULL, robots=(ROBOT, dataclasses.replace(ROBOT, name="other")))
    one, both = measure(FULL), measure(two)
    assert both["rad_mission"].value == one["rad_mission"].value
    assert both["episodes"].value == 2 * one["episodes"].value
    assert both["fo_measured"].value == pytest.approx(2 * one["fo_measured"].value)


def test_the_table_is_whole() -> None:
    for name, each in METRICS.items():
        assert name == each.name
        assert each.words.endswith(".")
        assert each.better in ("higher", "lower", "")


def played(model: OperatorModel, trials: int) -> list[dict[str, Estimate]]:
    return list(measured(model, range(trials), MeasureSpec(tau=60.0)))


def inside(found: list[dict[str, Estimate]], name: str, truth: float) -> float:
    """Share of the trials in whose interval the truth lies."""
    return float(np.mean([each[name].low <= truth <= each[name].high for each in found]))


@pytest.mark.parametrize("check_s", [0.0, 60.0])
def test_intervals_hold_the_truth_where_it_is_identifiable(check_s: float) -> None:
    model = OperatorModel(check_s=check_s)
    found = played(model, 100)
    assert inside(found, "nt_median", model.tolerance_median) >= 0.93
    assert inside(found, "ie_mean", model.interaction_mean) >= 0.88
    at = np.linspace(0.0, 60.0, 6001)
    alive = np.exp(-((at / model.tolerance_scale) ** model.tolerance_shape))
    truth = 1.0 + float(np.trapezoid(alive, at)) / model.interaction_mean
    assert inside(found, "fo", truth) >= 0.88
    assert np.mean([each["fo"].value for each in found]) == pytest.approx(truth, rel=0.03)


def test_an_operator_who_returns_at_the_drop_leaves_nothing_to_identify() -> None:
    for each in played(OperatorModel(notice_s=0.0), 20):
        assert "not identifiable" in each["nt_median"].why
        assert "not identifiable" in each["fo"].why
        assert each["ie_mean"].known


def test_measured_fan_out_is_a_plateau_over_the_team() -> None:
    active = [
        np.mean([each["fo_measured"].value for each in played(OperatorModel(robots=n), 10)])
        for n in (1, 4, 10)
    ]
    assert active == pytest.approx([0.94, 3.47, 5.13], rel=0.05)
