"""No code of a recording runs: its layouts have no extensions, whatever their files are called."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from hub.recording.anchor import TimeAnchor
from hub.recording.recording_set import RecordingSet
from hub.recording.writer import RecordingWriter, WriterLimits
from rune_tui.errors import LogError
from rune_tui.model.own_records import LayoutRecord
from rune_tui.replay.logged_layouts import LoggedLayouts

LAYOUT = """<rune>
  <extension file="{named}"/>
  <robot name="r" hub="127.0.0.1"><capability name="NAV_STATE"/></robot>
  <view xsize="10" ysize="4"><widget handler="widgetQuit"><event key="q"/></widget></view>
</rune>
"""


@pytest.mark.parametrize(
    ("attached", "named"),
    [
        ("code.py", "code.py"),
        ("code.PY", "code.py"),  # one file where the file system ignores case
        ("code.Py", "code.Py"),
        ("parts/code.py", "parts/code.py"),
        ("code.py", "../code.py"),
        ("code.txt", "code.txt"),
    ],
)
def test_a_recorded_layout_has_no_extensions(tmp_path: Path, attached: str, named: str) -> None:
    marker = tmp_path / "ran"
    path = tmp_path / "console.mcap"
    anchor = TimeAnchor(time.time_ns(), 0.0)
    writer = RecordingWriter(path, anchor, {}, WriterLimits(least_free=0))
    writer.attach("layout.xml", "application/xml", LAYOUT.format(named=named).encode(), 0.0)
    writer.attach(attached, "text/plain", f"open({str(marker)!r}, 'w')".encode(), 0.0)
    writer.close()
    record = LayoutRecord(layout="x.xml", run=1, sha256="0", files=("layout.xml", attached))
    with RecordingSet.open([path]) as recording:
        with pytest.raises(LogError, match="has code, which does not run from a recording"):
            LoggedLayouts(recording).open(record)
        assert not marker.exists()
