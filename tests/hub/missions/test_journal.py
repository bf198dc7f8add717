"""The journal: what was written whole is read, whatever happens to the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import MissionFileError
from hub.missions import journal, journal_file
from hub.missions.journal_file import MAX_RECORDS, JournalFile, read

RECORDS = [{"is": "noted", "text": f"Ünfall {number}\n", "n": number} for number in range(6)]
WHOLE = b"".join(map(journal.encode, RECORDS))
ENDS = [len(b"".join(map(journal.encode, RECORDS[:count]))) for count in range(7)]

Records = list[dict[str, Any]]


def decoded(raw: bytes) -> tuple[Records, journal.Reading]:
    found: Records = []
    return found, journal.decode(raw, found.append, MAX_RECORDS)


def held(path: Path) -> tuple[Records, journal.Reading]:
    found: Records = []
    return found, read(path, found.append)


_TEXTS = st.text(max_size=40)
_VALUES = st.dictionaries(_TEXTS, _TEXTS | st.integers() | st.booleans(), max_size=4)


@given(records=st.lists(_VALUES, max_size=8))
def test_records_are_read_as_they_were_written(records: list[dict[str, Any]]) -> None:
    found, reading = decoded(b"".join(map(journal.encode, records)))
    assert found == records
    assert reading.damaged == 0


def test_a_journal_cut_at_any_byte_has_all_records_before_the_cut() -> None:
    for cut in range(len(WHOLE) + 1):
        found, reading = decoded(WHOLE[:cut])
        # A record counts when all of it is there; its line break alone may be missing.
        whole = sum(end - 1 <= cut for end in ENDS[1:])
        assert found == RECORDS[:whole]
        assert reading.damaged == 0


def test_a_flipped_bit_anywhere_costs_one_record_and_invents_none() -> None:
    for place in range(len(WHOLE)):
        for bit in range(8):
            raw = bytearray(WHOLE)
            raw[place] ^= 1 << bit
            read_back = decoded(bytes(raw))[0]
            assert all(record in RECORDS for record in read_back)
            assert len(read_back) >= len(RECORDS) - 1
            assert read_back == sorted(read_back, key=lambda record: record["n"])


@given(raw=st.binary(max_size=400))
def test_any_bytes_are_read_and_add_nothing(raw: bytes) -> None:
    found, _ = decoded(WHOLE + b"\n" + raw)
    assert found[: len(RECORDS)] == RECORDS


def test_a_torn_line_is_removed_and_what_follows_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    for cut in range(len(WHOLE) + 1):
        path.write_bytes(WHOLE[:cut])
        before, _ = held(path)
        file = JournalFile(path)
        file.append([{"is": "after"}])
        file.close()
        found, again = held(path)
        assert found == [*before, {"is": "after"}]
        assert again.damaged == 0


def test_all_records_of_one_call_are_written_or_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = JournalFile(tmp_path / "journal")
    file.append(RECORDS[:1])
    monkeypatch.setattr("os.fsync", _refuse)
    with pytest.raises(MissionFileError, match="no space"):
        file.append(RECORDS[1:3])
    monkeypatch.undo()
    assert held(tmp_path / "journal")[0] == RECORDS[:1]
    file.append(RECORDS[3:])
    file.close()
    assert held(tmp_path / "journal")[0] == [*RECORDS[:1], *RECORDS[3:]]


def test_a_journal_that_cannot_be_mended_is_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "journal"
    path.write_bytes(WHOLE[:-5])
    monkeypatch.setattr("os.ftruncate", lambda *_: _refuse(0))
    before = len(list(Path("/proc/self/fd").iterdir()))
    with pytest.raises(MissionFileError, match="no space"):
        JournalFile(path)
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_the_number_of_records_is_bounded_for_writer_and_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal_file, "MAX_RECORDS", 4)
    path = tmp_path / "journal"
    file = JournalFile(path)
    file.append(RECORDS[:3])
    with pytest.raises(MissionFileError, match="full"):
        file.append(RECORDS[3:])
    file.append(RECORDS[3:4])
    file.close()
    path.write_bytes(path.read_bytes() + b"0123")
    assert held(path)[0] == RECORDS[:4]
    for more in (journal.encode(RECORDS[4]), b"\n"):
        path.write_bytes(b"".join(map(journal.encode, RECORDS[:4])) + more)
        found: Records = []
        with pytest.raises(MissionFileError, match="more than 4 records"):
            read(path, found.append)
        assert found == RECORDS[:4]


def _refuse(_: int) -> None:
    raise OSError(28, "no space left on device")
