"""`rune-hub log`: looks at recordings, and makes others of them."""

from __future__ import annotations

import argparse
import math
import os
import shutil
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from hub.command_output import print_error, put, put_json
from hub.errors import RecordingError
from hub.inspection.output import span, table
from hub.paths import for_recordings
from hub.plain_text import plain
from hub.recording.recording_set import RecordingSet
from hub.recording.tools.copies import Copied, CopyOptions, copy, recover
from hub.recording.tools.facts import RecordingFacts, as_json, facts_of_recording
from hub.recording.tools.selection import Selection, date
from hub.recording.tools.tables import write_tables
from hub.robots.mavlink import tlog
from hub.toml_reader import RefusedError, plain_name

_ENDINGS = (".mcap", ".db3", ".mcap.zstd", ".db3.zstd")
_MOST_FILES = 1_000_000
_PATIENCE_S = 1.0
"""Work that takes longer says how far it has got [s]."""
_BETWEEN_S = 0.2


class ProgressLine:
    """Says on a terminal how far long work has got, on one line of standard error."""

    def __init__(self) -> None:
        self._due = time.monotonic() + _PATIENCE_S
        self._shown = False
        self._wanted = sys.stderr.isatty()

    def __call__(self, share: float) -> None:
        """Show the share that is done, if it is time to."""
        if self._wanted and time.monotonic() >= self._due:
            self._due = time.monotonic() + _BETWEEN_S
            self._shown = True
            sys.stderr.write(f"\r{100 * min(1.0, max(0.0, share)):3.0f} %")
            sys.stderr.flush()

    def end(self) -> None:
        """Remove the line."""
        if self._shown:
            sys.stderr.write("\r     \r")
            sys.stderr.flush()
            self._shown = False


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        RecordingError: It cannot be done.
    """
    progress = ProgressLine()
    try:
        if options.task == "info":
            return max([_info(path, options, progress) for path in options.files])
        if options.task == "ls":
            return _list(options.folder, as_json_lines=options.json)
        if options.task == "csv":
            return _tables(options, progress)
        return _report(_copied(options, progress), options, progress)
    except KeyboardInterrupt:
        progress.end()
        print_error("interrupted: no new file is written")
        return 1
    finally:
        progress.end()


def _info(path: Path, options: argparse.Namespace, progress: ProgressLine) -> int:
    facts = facts_of_recording(path, progress, quick=options.quick, unpacked=options.unpack)
    progress.end()
    if options.json:
        put_json(as_json(facts))
    else:
        _show(facts, quick=options.quick)
    return 1 if facts.faults else 0


def _show(facts: RecordingFacts, *, quick: bool) -> None:
    length = (facts.end - facts.start) / 1e9
    put(plain(f"{facts.path}: {facts.messages} messages, {_size(facts.size)}, {span(length)}"))
    if facts.messages:
        put(f"from {date(facts.start)} to {date(facts.end)}")
    for name, content in facts.about.items():
        words = ", ".join(f"{key} {value}" for key, value in content.items())
        put(plain(f"{name}: {words}"[:400]))
    if facts.attachments:
        put(plain(f"files within it: {', '.join(facts.attachments)}"[:400]))
    _show_topics(facts, quick=quick)
    for mark in facts.marks:
        put(plain(f"mark {mark.number} at {date(mark.stamp)}  {mark.text}").rstrip())
    _show_times(facts)
    for topic, count in facts.lost.items():
        put(plain(f"{count} messages of {topic} were lost by the writer"))
    if quick:
        put("only the index was read: sizes, losses, gaps, jumps, marks and damage are not known")
    if not facts.finished:
        put("unfinished: it has no index; `rune-hub log recover` makes a file with one")
    for fault in facts.faults:
        put(plain(f"fault: {fault}"))


def _show_times(facts: RecordingFacts) -> None:
    for begin, end in facts.gaps:
        put(f"no messages for {span((end - begin) / 1e9)} from {date(begin)}")
    for stamp, back in facts.jumps or ():
        put(f"the clock jumps back by {span(back / 1e9)} at {date(stamp)}")
    if facts.looked and facts.jumps is None:
        put("jumps of the clock are not known: the messages are read in the order of their stamps")


def _show_topics(facts: RecordingFacts, *, quick: bool) -> None:
    rows = [
        (
            plain(each.topic.name),
            plain(each.topic.schema_name),
            str(each.messages),
            f"{each.rate_hz:.1f} Hz" if each.rate_hz else "",
            _size(each.bytes) if each.bytes >= 0 else "",
            str(each.missing) if each.missing >= 0 else "",
            f"{each.longest_gap / 1e9:.2f} s" if each.longest_gap >= 0 else "",
        )
        for each in facts.topics
    ]
    if rows and quick:
        table(("topic", "type", "messages"), [row[:3] for row in rows], words=2)
    elif rows:
        heads = ("topic", "type", "messages", "rate", "size", "missing", "longest gap")
        _fitting_table(heads, rows)


def _fitting_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Write a table of topics; a narrow terminal gets fewer columns."""
    wide = shutil.get_terminal_size().columns if sys.stdout.isatty() else math.inf
    left_out: set[int] = set()
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    for name in ("type", "size"):
        kept = [each for place, each in enumerate(widths) if place not in left_out]
        if sum(kept) + 2 * (len(kept) - 1) > wide:
            left_out.add(heads.index(name))
    shown = [
        [cell for place, cell in enumerate(row) if place not in left_out] for row in (heads, *rows)
    ]
    table(shown[0], shown[1:], words=2 - len(left_out & {1}))


def _list(folder: Path | None, *, as_json_lines: bool) -> int:
    root = folder or for_recordings()
    rows, code = [], 0
    unread: list[OSError] = []
    for path in _recordings_in(root, unread):
        try:
            facts = facts_of_recording(path, lambda _: None, quick=True)
        except RecordingError as error:
            code = 1
            _say_unread(path, str(error), as_json_lines=as_json_lines)
            continue
        code = 1 if facts.faults else code
        if as_json_lines:
            put_json(as_json(facts))
            continue
        rows.append(
            (
                plain(str(path.relative_to(root) if path != root else path)),
                date(facts.start)[:19] if facts.start else "",
                "damaged" if facts.faults else "" if facts.finished else "unfinished",
                span((facts.end - facts.start) / 1e9),
                str(facts.messages),
                str(len(facts.topics)),
                _size(facts.size),
            )
        )
    for fault in unread:
        code = 1
        text = f"{fault.filename} cannot be read: {fault.strerror}"
        _say_unread(fault.filename, text, as_json_lines=as_json_lines)
    heads = ("recording", "begun", "state", "lasted", "messages", "topics", "size")
    if rows:
        table(heads, rows, words=3)
    elif not as_json_lines and not code:
        put(f"there are no recordings in {root}")
    return code


def _say_unread(path: Path | str, fault: str, *, as_json_lines: bool) -> None:
    if as_json_lines:
        put_json({"path": str(path), "faults": [fault]})
    else:
        print_error(fault)


def _recordings_in(root: Path, unread: list[OSError]) -> Iterator[Path]:
    """Files and bags in a folder and in those within it, in order.

    Args:
        root: The folder.
        unread: Gets the errors of folders that cannot be read.

    Raises:
        RecordingError: There is no such folder, or it has too many files.
    """
    if not root.is_dir():
        text = f"there is no folder {root}"
        raise RecordingError(text)
    found = sorted(_files_in(root, unread))
    bags = {path.parent for path in found if path.name == "metadata.yaml"}
    for path in sorted({*bags, *(each for each in found if _is_recording(each))}):
        if path.parent not in bags:
            yield path


def _files_in(root: Path, unread: list[OSError]) -> Iterator[Path]:
    """All files in a folder and in those within it that can be read.

    Raises:
        RecordingError: They are too many.
    """
    count = 0
    for folder, _, names in os.walk(root, onerror=unread.append):
        count += len(names)
        if count > _MOST_FILES:
            text = f"{root} has more than {_MOST_FILES} files; name a folder in it"
            raise RecordingError(text)
        yield from (Path(folder, name) for name in names)


def _is_recording(path: Path) -> bool:
    return path.name.endswith(_ENDINGS) and not path.name.startswith(".") and path.is_file()


def _copied(options: argparse.Namespace, progress: ProgressLine) -> Copied:
    if options.task == "recover":
        return recover(
            options.files[0],
            options.output,
            compression=options.compression,
            replace=options.force,
            progress=progress,
            damaged=options.damaged,
            unpacked=options.unpack,
        )
    how = CopyOptions(
        compression=options.compression,
        replace=options.force,
        newest=options.newest,
        ros_names=options.ros_names,
    )
    if options.task == "convert" and options.files[0].suffix == tlog.ENDING:
        return _from_tlog(options, how, progress)
    with RecordingSet.open(options.files, unpacked=options.unpack) as recording:
        selection = _selection(options)
        if options.task == "convert" and options.output.suffix == tlog.ENDING:
            return tlog.to_tlog(recording, options.output, selection, how, progress)
        return copy(recording, options.output, selection, how, progress)


def _from_tlog(options: argparse.Namespace, how: CopyOptions, progress: ProgressLine) -> Copied:
    """Make a recording of the log of a ground station.

    Raises:
        RecordingError: A part of it is asked for, or it cannot be done.
    """
    part = (*options.topics, *options.exclude, options.start, options.end, options.around)
    if any(part) or options.ros_names or len(options.robot) > 1:
        text = "a log of a ground station is converted as a whole; cut the recording afterwards"
        raise RecordingError(text)
    try:
        robot = plain_name(32)(options.robot[0]) if options.robot else "vehicle"
    except RefusedError as error:
        raise RecordingError(str(error)) from error
    return tlog.from_tlog(options.files[0], options.output, how, progress, robot=robot)


def _selection(options: argparse.Namespace) -> Selection:
    return Selection(
        topics=tuple(options.topics),
        exclude=tuple(options.exclude),
        robots=tuple(options.robot),
        start=options.start,
        end=options.end,
        around=options.around,
        before_s=options.before,
        after_s=options.after,
    )


def _report(copied: Copied, options: argparse.Namespace, progress: ProgressLine) -> int:
    """Say what a copy has; returns the exit code."""
    progress.end()
    if options.json:
        facts = {
            "path": str(copied.path),
            "messages": copied.messages,
            "bytes": copied.bytes,
            "unreadable_bytes": copied.unreadable,
            "missing": copied.missing if copied.missing >= 0 else None,
            "faults": list(copied.faults),
        }
        put_json(facts)
        return _code(copied)
    put(plain(f"{copied.messages} messages ({_size(copied.bytes)}) are in {copied.path}"))
    for fault in copied.faults:
        print_error(fault)
    if options.task == "recover":
        missing = "" if copied.missing < 0 else f", {copied.missing} messages of its index"
        put(f"lost: {copied.unreadable} bytes that cannot be read{missing}")
        if copied.unreadable and not options.damaged:
            put("`--damaged` keeps also messages that are found in damaged parts, as a replay does")
    return _code(copied)


def _code(copied: Copied) -> int:
    """The exit code: 1 where something could not be read."""
    return 1 if copied.faults or copied.unreadable or copied.missing > 0 else 0


def _tables(options: argparse.Namespace, progress: ProgressLine) -> int:
    with RecordingSet.open(options.files, unpacked=options.unpack) as recording:
        tables = write_tables(
            recording,
            options.output,
            _selection(options),
            progress,
            most=options.most,
            replace=options.force,
        )
        faults = list(recording.faults)
    progress.end()
    for each in tables:
        if options.json:
            facts = {"path": str(each.path), "topic": each.topic, "rows": each.rows}
            put_json({**facts, "unreadable": each.unreadable})
        else:
            more = f", {each.unreadable} do not fit their definition" if each.unreadable else ""
            put(plain(f"{each.path}: {each.rows} rows{more}"))
    for fault in faults:
        print_error(fault)
    return 1 if faults or any(each.unreadable for each in tables) else 0


def _size(count: int) -> str:
    """A length [bytes] in the unit that suits it."""
    for unit, name in ((10**9, "GB"), (10**6, "MB"), (10**3, "kB")):
        if count >= unit:
            return f"{count / unit:.1f} {name}"
    return f"{count} B"
