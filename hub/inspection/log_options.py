"""The options of `rune-hub log`."""

from __future__ import annotations

import argparse
from pathlib import Path

from hub.command_line import CommandParser, Commands, number_type
from hub.errors import RecordingError
from hub.inspection.record_options import add_topics, reader
from hub.recording.live import words
from hub.recording.unpack_option import add_unpack

_most = number_type(int, 1, 10**9, "whole number above 0")


def add_log(commands: Commands) -> None:
    """Add the command."""
    log = commands.add_parser(
        "log",
        help="look at recordings, and make others of them",
        description="Look at recordings (MCAP files, folders of their splits, bags of rosbag2), "
        "and make other files of them. Times are +90s (after the start), =-10s (before the end), "
        "14:03:22 or '2026-11-22 14:03:22'. Exit codes: 0 complete, 1 something cannot be read, "
        "2 wrong usage or no recording.",
    )
    tasks = log.add_subparsers(dest="task", required=True, metavar="TASK")
    info = tasks.add_parser("info", help="topics, rates, sizes, losses, gaps, marks, faults")
    info.add_argument("files", nargs="+", type=Path, metavar="FILE", help="file or folder")
    info.add_argument("--quick", action="store_true", help="what the index says, at once")
    listing = tasks.add_parser("ls", help="the recordings in a folder")
    listing.add_argument(
        "folder", nargs="?", type=Path, help="without: where robots on this machine keep them"
    )
    copies = [
        _copy(tasks, "cut", "a span of time, as a new file", "FILE"),
        _copy(tasks, "merge", "several recordings as one file, on one time line", "FILE..."),
        _copy(tasks, "filter", "some topics or robots, as a new file", "FILE"),
        _copy(
            tasks,
            "convert",
            "the same packed otherwise, as ROS 2 names it, to or from .tlog",
            "FILE",
        ),
        _table(tasks),
        _recovery(tasks),
    ]
    for task in (info, *copies):
        add_unpack(task)
    for task in (info, listing, *copies):
        task.add_argument("--json", action="store_true", help="JSON, one line a recording")


def _copy(tasks: Commands, name: str, text: str, source: str) -> CommandParser:
    task = tasks.add_parser(name, help=text)
    several = name == "merge"
    task.add_argument(
        "files", nargs="+" if several else 1, type=Path, metavar=source, help="file or folder"
    )
    output = "new file; with --ros-names a new folder, a bag of rosbag2, if it ends not in .mcap"
    task.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help=output)
    _add_selection(task)
    task.add_argument(
        "--newest", action="store_true",
        help="begin with the newest message of each topic before the span",
    )  # fmt: skip
    task.add_argument("--ros-names", action="store_true", help="name topics as ROS 2 does: /tf")
    _add_writing(task)
    return task


def _table(tasks: Commands) -> CommandParser:
    task = tasks.add_parser("csv", help="a table for each topic, with a column for each field")
    task.add_argument("files", nargs=1, type=Path, metavar="FILE", help="file or folder")
    task.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FOLDER", help="folder of the tables"
    )
    _add_selection(task)
    task.add_argument(
        "--most", type=_most, default=1000, metavar="N",
        help="leave out arrays with more values (%(default)s)",
    )  # fmt: skip
    task.add_argument("--force", action="store_true", help="replace files of these names")
    return task


def _recovery(tasks: Commands) -> CommandParser:
    task = tasks.add_parser(
        "recover", help="what is whole of a damaged or unfinished file, with an index"
    )
    task.add_argument(
        "files", nargs=1, type=Path, metavar="FILE", help="the file or folder; it stays"
    )
    task.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="new file")
    task.add_argument(
        "--damaged", action="store_true",
        help="keep also messages of damaged parts, as rune replay shows them; they may be wrong",
    )  # fmt: skip
    _add_writing(task)
    return task


def _add_selection(task: CommandParser) -> None:
    what = task.add_argument_group("which part")
    add_topics(what)
    what.add_argument(
        "--robot", action="append", default=[], metavar="NAME",
        help="only topics of this robot; as often as needed",
    )  # fmt: skip
    what.add_argument("--from", dest="start", default="", metavar="TIME", help="first moment")
    what.add_argument(
        "--to", dest="end", default="", metavar="TIME", help="last moment, such as --to=-10s"
    )
    what.add_argument(
        "--around", default="", metavar="MARK", help="the time around a mark: its number or text"
    )
    what.add_argument(
        "--before", type=reader(words.seconds_of), default=30.0, metavar="TIME",
        help="how much of it is before the mark (30 s)",
    )  # fmt: skip
    what.add_argument(
        "--after", type=reader(words.seconds_of), default=10.0, metavar="TIME",
        help="how much is after it (10 s)",
    )  # fmt: skip


def _add_writing(task: CommandParser) -> None:
    task.add_argument(
        "--compression", choices=("lz4", "zstd", "none"), default="lz4",
        help="how it is packed (%(default)s)",
    )  # fmt: skip
    task.add_argument("--force", action="store_true", help="replace a file of this name")


def run_log(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        RecordingError: It cannot be done.
    """
    try:
        from hub.inspection import log_commands
    except ImportError as error:
        text = f"{error.name} is missing; install it with pip install 'robot-user-nexus[record]'"
        raise RecordingError(text) from error
    return log_commands.run(options)
