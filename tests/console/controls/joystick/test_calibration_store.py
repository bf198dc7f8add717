from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.joystick.calibration import Calibration
from rune_tui.controls.joystick.calibration_store import CalibrationStore

STICK = Calibration(low=3, high=250, centre=120)
LEVER = Calibration(low=0, high=1023)


def test_what_was_found_is_there_again_after_a_restart() -> None:
    store = CalibrationStore()
    assert store.of("046d:c216:") == {}
    assert store.trouble == ""
    store.add("046d:c216:", {"x": STICK})
    store.add("046d:c216:", {"slider#2": LEVER})
    store.save()
    assert "rune" in store.path.parts
    again = CalibrationStore()
    assert again.of("046d:c216:") == {"x": STICK, "slider#2": LEVER}
    assert again.of("046d:c216:7") == {}
    assert [each.name for each in store.path.parent.iterdir()] == [store.path.name]


def stored(path: Path, **changes: Any) -> None:
    axis = {"low": 3, "high": 250, "centre": 120} | changes
    path.write_text(json.dumps({"version": 1, "devices": {"046d:c216:": {"x": axis}}}))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "null",
        "\x00\xff",
        '{"version": 2, "devices": {}}',
        '{"version": 1}',
        '{"version": 1, "devices": {"a": {"x": 7}}}',
        '{"version": 1, "devices": {"a": {"\\u001b[2J": {"low": 0, "high": 1}}}}',
        "[" * 100_000,
        " " * (1 << 19),
    ],
)
def test_a_file_that_makes_no_sense_is_told_of_and_kept_aside(tmp_path: Path, text: str) -> None:
    path = tmp_path / "joysticks.json"
    path.write_text(text, "latin-1")
    store = CalibrationStore(path)
    assert str(path) in store.trouble
    assert "uncalibrated" in store.trouble
    store.add("046d:c216:", {"x": STICK})
    store.save()
    assert path.with_suffix(".broken").read_text("latin-1") == text
    assert CalibrationStore(path).of("046d:c216:") == {"x": STICK}


@pytest.mark.parametrize(
    "changes",
    [
        {"low": 250},
        {"centre": 3},
        {"centre": 251},
        {"low": 1.5},
        {"low": True},
        {"high": 1 << 40},
        {"high": "250"},
        {"low": None},
    ],
)
def test_numbers_that_cannot_be_are_refused(tmp_path: Path, changes: dict[str, Any]) -> None:
    path = tmp_path / "joysticks.json"
    stored(path)
    assert CalibrationStore(path).of("046d:c216:") == {"x": STICK}
    stored(path, **changes)
    store = CalibrationStore(path)
    assert "046d:c216: x" in store.trouble
    assert store.of("046d:c216:") == {}


@given(st.binary(max_size=200))
def test_no_file_stops_the_console(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = tmp_path_factory.mktemp("store") / "joysticks.json"
    path.write_bytes(data)
    assert CalibrationStore(path).trouble


def test_a_file_that_cannot_be_written_leaves_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "joysticks.json"
    stored(path)
    store = CalibrationStore(path)
    store.add("x" * 300, {"x": Calibration(low=0, high="much", centre=None)})  # type: ignore[arg-type]
    path.unlink()
    path.mkdir()
    (path / "in the way").touch()
    with pytest.raises(OSError, match="directory"):
        store.save()
    assert [each.name for each in tmp_path.iterdir()] == ["joysticks.json"]


def test_of_more_devices_than_anybody_has_the_oldest_are_forgotten() -> None:
    store = CalibrationStore()
    for number in range(205):
        store.add(f"device {number}", {"x": STICK})
    store.save()
    again = CalibrationStore()
    assert again.trouble == ""
    assert again.of("device 4") == {}
    assert again.of("device 5") == {"x": STICK}


def test_a_pipe_in_place_of_the_file_keeps_nobody_waiting(tmp_path: Path) -> None:
    path = tmp_path / "joysticks.json"
    os.mkfifo(path)
    assert "no regular file" in CalibrationStore(path).trouble
