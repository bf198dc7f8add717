"""Where files of ours belong."""

from __future__ import annotations

from pathlib import Path

import pytest

from hub import paths


def test_folders_are_where_the_xdg_specification_wants_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert paths.for_maps() == tmp_path / "rune" / "maps"
    monkeypatch.setenv("XDG_DATA_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert paths.for_maps() == tmp_path / ".local" / "share" / "rune" / "maps"
    assert paths.for_maps("/elsewhere") == Path("/elsewhere")


def test_service_has_the_log_folder_that_systemd_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGS_DIRECTORY", "/var/log/rune-hub:/other")
    assert paths.for_logs() == Path("/var/log/rune-hub")
    assert paths.for_logs("/wanted") == Path("/wanted")


def test_sockets_have_a_folder_with_a_short_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", "/" + "x" * 100)
    assert len(str(paths.for_sockets())) <= paths.LONGEST_FOR_SOCKETS
