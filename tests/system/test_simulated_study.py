"""A scripted operator plays whole studies, and the metrics find what he did."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

STUDY = """
title = "t"
seed = "s"
participants = {participants}
[session]
steps = ["consent", "trials"]
[defaults]
arena = "empty"
[[condition]]
layout = "search"
[[condition]]
layout = "two-robots"
robots = 2
[trial]
seconds = {seconds}
after = ["nasa-tlx"]
[metrics]
effectiveness = "driven"
"""
EFFORT_S = 0.25
"""From the script's clock to the console's: the key's way through terminal and event loop [s]."""
WORK = 0.1
"""Most by which the mean number of robots at work is wrong; they also start and brake."""


def simulated(folder: Path, on: str, **study: float) -> list[dict[str, str]]:
    """Play a study with as many operators as participants; returns its metrics."""
    (folder / "study.toml").write_text(STUDY.format(**study))
    command = [sys.executable, "-m", "rune_tui", "study", "simulate", str(folder), "--on", on]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "nt_median" in done.stdout
    return rows(folder / f"simulated-on-{on}" / "derived" / "metrics.csv")


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def check(
    metrics: list[dict[str, str]], truth: list[dict[str, str]], trials: int, seconds: float
) -> None:
    """Compare what was found with what the operator did."""
    found = {(row["participant"], row["trial"], row["metric"]): row for row in metrics}
    episodes: dict[tuple[str, str], list[dict[str, str]]] = {}
    for row in truth:
        episodes.setdefault((row["participant"], row["trial"]), []).append(row)
    assert len(episodes) == trials
    assert {row["robot"] for row in truth} == {"1", "2"}
    for trial, own in episodes.items():
        assert float(found[*trial, "episodes"]["value"]) == len(own)
        attended = sum(float(row["end"]) - float(row["begin"]) for row in own)
        mean = attended / len(own)
        assert float(found[*trial, "ie_mean"]["value"]) == pytest.approx(mean, abs=EFFORT_S)
        share = attended / seconds
        assert float(found[*trial, "rad_mission"]["value"]) == pytest.approx(share, abs=0.03)
        active = sum(float(row["until"]) - float(row["begin"]) for row in own) / seconds
        assert float(found[*trial, "fo_measured"]["value"]) == pytest.approx(active, abs=WORK)


@pytest.mark.soak
def test_a_session_is_played_by_keys_and_measured(tmp_path: Path) -> None:
    metrics = simulated(tmp_path, "console", participants=1, seconds=16)
    folder = tmp_path / "simulated-on-console"
    check(metrics, rows(folder / "truth.csv"), trials=2, seconds=16)
    counted = Counter(row["metric"] for row in metrics if row["value"])
    assert counted["tlx_raw"] == 2
    assert (folder / "report.html").exists()
    assert not list(tmp_path.glob("sub-*"))


@pytest.mark.soak
def test_trials_on_hubs_are_measured(tmp_path: Path) -> None:
    metrics = simulated(tmp_path, "hubs", participants=1, seconds=16)
    check(metrics, rows(tmp_path / "simulated-on-hubs" / "truth.csv"), trials=2, seconds=16)


@pytest.mark.soak
@pytest.mark.timeout(1500)
def test_a_study_of_minutes_is_played_by_keys_and_measured(tmp_path: Path) -> None:
    metrics = simulated(tmp_path, "console", participants=2, seconds=120)
    check(metrics, rows(tmp_path / "simulated-on-console" / "truth.csv"), trials=4, seconds=120)
