"""Files that a user names are written as a shell writes them."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

from hub import files


def test_a_pipe_gets_the_content_and_stays_a_pipe(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    with closing(os.fdopen(os.open(path, os.O_RDWR | os.O_NONBLOCK), "rb", 0)) as reader:
        files.write_output(path, b"content")
        assert reader.read(64) == b"content"
    assert path.is_fifo()


def test_a_link_stays_and_the_file_that_it_leads_to_is_written(tmp_path: Path) -> None:
    file, link = tmp_path / "file", tmp_path / "link"
    link.symlink_to(file)
    for content in (b"new", b"newer"):
        files.write_output(link, content)
        assert file.read_bytes() == content
        assert link.is_symlink()
    assert {*tmp_path.iterdir()} == {file, link}
