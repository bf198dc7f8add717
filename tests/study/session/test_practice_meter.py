"""Metrics of the last part of practice follow from recordings that are still being written."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.gcm.ground_truth import GROUND_TRUTH
from hub.recording.anchor import TimeAnchor
from hub.recording.topics import topic_of
from hub.recording.writer import RecordingWriter, WriterLimits
from rune_study.metrics.trial import MeasureSpec
from rune_study.session.practice_meter import PracticeFiles, PracticeMeter, measured
from tests.study.trial_data.test_trial_data import truth
from tests.support.waiting import until

BEGIN = 1000.0


@pytest.fixture
def writer(tmp_path: Path) -> Iterator[RecordingWriter]:
    """A recording that goes on: a robot that drives half a metre each second for 10 s."""
    writer = RecordingWriter(
        tmp_path / "p.mcap", TimeAnchor(10**18, BEGIN), {}, WriterLimits(least_free=0)
    )
    for number in range(11):
        moment = BEGIN + number
        payload = GROUND_TRUTH.encode(truth(0.5 * number))
        writer.add(topic_of("magellan", GROUND_TRUTH), payload, moment, moment)
    until(lambda: writer.state.messages == 11, 10.0, "nothing is written")
    yield writer
    writer.close()


def files(writer: RecordingWriter) -> PracticeFiles:
    return PracticeFiles(
        consoles=writer.path.parent / "console.part",
        hubs=[writer.path],
        arena="",
        effectiveness="driven",
        measures=MeasureSpec(),
    )


@pytest.mark.parametrize(("begin", "driven"), [(0.0, 5.0), (4.0, 3.0)])
def test_only_the_last_part_counts(writer: RecordingWriter, begin: float, driven: float) -> None:
    part = BEGIN + begin, BEGIN + 10.0
    found = measured(files(writer), ["driven", "ie_mean"], *part, [])
    assert found == pytest.approx({"driven": driven})


def test_pauses_take_no_time(writer: RecordingWriter) -> None:
    pauses = [(BEGIN - 5.0, BEGIN + 2.0), (BEGIN + 4.0, BEGIN + 6.0)]
    whole = measured(files(writer), ["te_mean"], BEGIN, BEGIN + 10.0, [])
    shorter = measured(files(writer), ["te_mean"], BEGIN, BEGIN + 10.0, pauses)
    assert whole["te_mean"] == pytest.approx(0.5)
    assert shorter["te_mean"] == pytest.approx(4.0 / 6.0)  # the way in the first pause is out


def test_the_meter_computes_beside_the_trial(writer: RecordingWriter) -> None:
    meter = PracticeMeter(files(writer), ["driven"])
    meter.look(BEGIN, BEGIN + 10.0, [])
    until(lambda: bool(meter.values), 20.0, "there are no values")
    assert meter.values == pytest.approx({"driven": 5.0})
    meter.close()


def test_a_missing_recording_has_no_values(tmp_path: Path) -> None:
    nothing = PracticeFiles(
        consoles=tmp_path, hubs=[tmp_path / "none.mcap"], arena="", effectiveness="driven",
        measures=MeasureSpec(),
    )  # fmt: skip
    meter = PracticeMeter(nothing, ["driven"])
    meter.look(0.0, time.monotonic(), [])
    meter.close()
    assert meter.values == {}
    idle = PracticeMeter(nothing, ())
    idle.look(0.0, 1.0, [])
    idle.close()
