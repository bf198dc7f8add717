"""Exports have what their formats ask for, and nothing that a spreadsheet would run."""

from __future__ import annotations

import csv
import dataclasses
import json
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rune_study.data.bids import write_bids
from rune_study.data.rows import MetricRow, TrialRow
from rune_study.data.store import StudyData, compute
from rune_study.data.xlsx import write_xlsx
from rune_study.errors import DataError
from rune_study.plan.study_file import read_study
from rune_study.plan.study_spec import StudySpec
from tests.study.data.test_derive import STUDY, nothing, play

SHEET = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"


@pytest.fixture
def study(tmp_path: Path) -> StudySpec:
    folder = tmp_path / "two layouts"
    folder.mkdir()
    (folder / "study.toml").write_text(STUDY)
    return read_study(folder)


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(
        csv.DictReader(path.read_text().splitlines(), delimiter="\t", quoting=csv.QUOTE_NONE)
    )


def test_a_dataset_has_the_files_of_bids(study: StudySpec, tmp_path: Path) -> None:
    play(study, lost=2)
    written = write_bids(study, compute(study, nothing), tmp_path / "bids", named=True)
    names = {path.relative_to(tmp_path / "bids").as_posix() for path in written}
    assert names == {
        "dataset_description.json",
        "README.md",
        "participants.tsv",
        "participants.json",
        "scans.json",
        "task-twolayouts_events.json",
        "task-twolayouts_beh.json",
        "sub-01/sub-01_scans.tsv",
        "sub-01/beh/sub-01_task-twolayouts_run-01_events.tsv",
        "sub-01/beh/sub-01_task-twolayouts_run-01_beh.tsv",
    }
    description = json.loads((tmp_path / "bids" / "dataset_description.json").read_text())
    assert description["Name"] == study.title
    assert description["BIDSVersion"]


def test_every_column_of_a_dataset_is_described(study: StudySpec, tmp_path: Path) -> None:
    play(study)
    folder = tmp_path / "bids"
    for table in (
        path
        for path in write_bids(study, compute(study, nothing), folder, named=True)
        if path.suffix == ".tsv"
    ):
        kind = table.stem.rpartition("_")[2]
        (about,) = folder.glob(f"*{kind}.json")
        known = json.loads(about.read_text())
        head, *lines = [line.split("\t") for line in table.read_text().splitlines()]
        assert all(known[name]["Description"] for name in head)
        assert lines
        assert all(len(line) == len(head) and all(line) for line in lines)


def test_runs_have_their_own_events_and_metrics(study: StudySpec, tmp_path: Path) -> None:
    play(study)
    write_bids(study, compute(study, nothing), tmp_path / "bids", named=True)
    sub = tmp_path / "bids" / "sub-01"
    for scan in rows_of(sub / "sub-01_scans.tsv"):
        metrics = rows_of(sub / scan["filename"])
        (driven,) = [row for row in metrics if row["metric"] == "driven"]
        assert float(driven["value"]) == pytest.approx(2.0)
        assert scan["layout"] == {"A": "hri-a", "B": "hri-b"}[scan["condition"]]
        events = rows_of(sub / scan["filename"].replace("_beh", "_events"))
        assert [row["trial_type"] for row in events] == ["trial-begin", "trial-end"]
        assert json.loads(events[1]["value"])["why"] == "time"
        assert events[0]["onset"] == "0.0"


def test_a_blind_dataset_names_codes_only(study: StudySpec, tmp_path: Path) -> None:
    play(study)
    written = write_bids(study, compute(study, nothing), tmp_path / "bids", named=False)
    assert not any("hri-" in path.read_text() for path in written)


def test_a_dataset_does_not_mix_with_other_files(study: StudySpec, tmp_path: Path) -> None:
    (tmp_path / "bids").mkdir()
    (tmp_path / "bids" / "mine.txt").touch()
    with pytest.raises(DataError, match="is not empty; name another folder"):
        write_bids(study, StudyData(trials=(), metrics=()), tmp_path / "bids", named=True)


def test_a_spreadsheet_has_a_sheet_for_each_table(tmp_path: Path) -> None:
    pytest.importorskip("xlsxwriter")
    trial = TrialRow(participant=1, trial=1, code="A", ended="=1+1")
    metric = MetricRow(participant=1, trial=1, code="A", metric="fo", value=float("inf"))
    data = StudyData(trials=(trial,), metrics=(metric, dataclasses.replace(metric, value=2.5)))
    with zipfile.ZipFile(write_xlsx(data, tmp_path / "study.xlsx")) as book:
        parts = {name: book.read(name) for name in book.namelist()}
    sheets = ElementTree.fromstring(parts["xl/workbook.xml"]).iter(f"{SHEET}sheet")
    assert [each.get("name") for each in sheets] == [
        "trials",
        "metrics",
        "probes",
        "wide",
        "dictionary",
    ]
    assert not any(b"<f>" in part for part in parts.values())
    numbers = ElementTree.fromstring(parts["xl/worksheets/sheet2.xml"]).iter(f"{SHEET}v")
    assert "2.5" in [each.text for each in numbers]
    texts = ElementTree.fromstring(parts["xl/sharedStrings.xml"]).iter(f"{SHEET}t")
    assert {"=1+1", "inf"} <= {each.text for each in texts}
