"""Tables come back as they were written, and mistakes in them are sentences."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.data.rows import EventRow, MetricRow, TrialRow
from rune_study.data.tables import as_text, dictionary, read, write
from rune_study.errors import DataError

NUMBERS = st.floats(allow_nan=True, allow_infinity=True)
WORDS = st.text(st.characters(exclude_categories=("Cs", "Cc", "Cf", "Zl", "Zp")), max_size=20)
ROWS = st.builds(
    MetricRow,
    participant=st.integers(1, 99),
    trial=st.integers(0, 9),
    code=st.sampled_from("ABCD"),
    metric=st.sampled_from(["IE", "NT"]),
    value=NUMBERS,
    low=NUMBERS,
    why=WORDS,
)


@given(rows=st.lists(ROWS, max_size=5))
def test_a_table_comes_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[MetricRow]
) -> None:
    path = write(tmp_path_factory.getbasetemp() / "data", "metrics.csv", rows)
    assert repr(read(path, MetricRow)) == repr(rows)


def test_columns_are_found_by_their_names(tmp_path: Path) -> None:
    path = write(tmp_path, "trials.csv", [TrialRow(participant=7, trial=2, code="B")])
    head, line = path.read_text().splitlines()
    turned = [",".join(reversed(each.split(","))) for each in (head, line)]
    path.write_text("\n".join(turned) + "\n")
    (row,) = read(path, TrialRow)
    assert (row.participant, row.trial, row.code) == (7, 2, "B")


def test_mistakes_are_sentences(tmp_path: Path) -> None:
    path = write(tmp_path, "trials.csv", [TrialRow(participant=7, trial=2, code="B")])
    whole = path.read_text()
    path.write_text(whole.replace("7,", "seven,", 1))
    with pytest.raises(DataError, match="line 2: invalid literal"):
        read(path, TrialRow)
    path.write_text(whole.replace("code", "kode"))
    with pytest.raises(DataError, match="lacks the columns code"):
        read(path, TrialRow)
    with pytest.raises(DataError, match="cannot be read: No such file"):
        read(tmp_path / "none.csv", TrialRow)


def test_events_say_that_a_number_is_not_available_as_bids_wants() -> None:
    text = as_text("events.tsv", [EventRow(onset=1.5, duration=math.nan, trial_type="bump")])
    head, line = text.splitlines()
    assert head.split("\t")[:3] == ["onset", "duration", "trial_type"]
    assert line.split("\t")[:3] == ["1.5", "n/a", "bump"]


def test_the_dictionary_names_every_column() -> None:
    found = json.loads(dictionary({"IE": {"unit": "s"}}))
    assert found["tables"]["trials.csv"]["seconds"]["Units"] == "s"
    assert all(each["Description"] for table in found["tables"].values() for each in table.values())
    assert found["metrics"]["IE"]["unit"] == "s"
