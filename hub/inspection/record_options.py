"""The options of `rune-hub record`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from hub.command_line import CommandParser, Commands
from hub.errors import RecordingError
from hub.recording.live import words
from hub.toml_reader import RefusedError

T = TypeVar("T")

_FORMATS = ("RLE", "JPEG", "RAW", "WEBP")
"""As in `ImageCoding`, whose import costs every command 0.1 s."""


def add_record(commands: Commands, look: CommandParser) -> None:
    """Add the command."""
    record = commands.add_parser(
        "record",
        parents=[look],
        help="record what is published, or have the robot record it",
        description="Record all that is published at a hub, as it comes, into an MCAP file on this "
        "machine, until Ctrl-C. Keys: m marks a moment, s goes on in another file, space pauses, q "
        "ends. With --start, --stop, --split, --mark or --snapshot: order the robot's recorder. "
        "Exit codes: 0 complete, 1 something is not recorded, 2 wrong usage, 3 no hub.",
    )
    record.add_argument("-o", "--output", type=Path, metavar="FILE", help="a new file")
    what = record.add_argument_group("what is recorded")
    what.add_argument(
        "-e", "--topics", nargs="+", type=_read(words.pattern_of), default=[], metavar="REGEX",
        help="only topics with one of these, such as GCM_RobotState",
    )  # fmt: skip
    what.add_argument(
        "-x", "--exclude", nargs="+", type=_read(words.pattern_of), default=[], metavar="REGEX",
        help="no topics with one of these",
    )  # fmt: skip
    what.add_argument(
        "--pictures", type=_read(words.rate_of), default=5.0, metavar="RATE",
        help="pictures a second of each camera; 0: none (5/s)",
    )  # fmt: skip
    what.add_argument(
        "--size", type=_read(words.size_of), default=(320, 240), metavar="WxH",
        help="largest size of pictures (320x240)",
    )  # fmt: skip
    what.add_argument(
        "--format", choices=_FORMATS, default="WEBP",
        help="coding of pictures (%(default)s)",
    )  # fmt: skip
    what.add_argument(
        "--maps", type=_read(words.seconds_of), default=10.0, metavar="TIME",
        help="time between two maps; 0: none (10 s)",
    )  # fmt: skip
    what.add_argument("--ros-names", action="store_true", help="name topics as ROS 2 does: /tf")
    what.add_argument("--wake", action="store_true", help="keep modules running for the recording")
    ends = record.add_argument_group("when files end")
    ends.add_argument(
        "-d", "--duration", type=_read(words.seconds_of), default=0.0, metavar="TIME",
        help="end after this time",
    )  # fmt: skip
    ends.add_argument(
        "-b", "--max-bytes", type=_read(words.bytes_of), default=0, metavar="SIZE",
        help="end at this size of all files",
    )  # fmt: skip
    ends.add_argument(
        "--split-every", type=_read(words.split_of), default=(0.0, 0), metavar="TIME|SIZE",
        help="go on in another file after '10 min' or at '500 MB'",
    )  # fmt: skip
    ends.add_argument(
        "--least-free", type=_read(words.bytes_of), default=2**30, metavar="SIZE",
        help="stop before the disk has less than this free (1 GiB)",
    )  # fmt: skip
    record.add_argument("--json", action="store_true", help="say what happens as JSON lines")
    _add_orders(record)


def run_record(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        HubError: It cannot be done.
    """
    from hub.inspection import message_commands

    client = message_commands.connect(options.hub, options.command, options.keys)
    try:
        from hub.inspection import record_command
    except ImportError as error:
        text = "mcap is missing; install it with pip install 'robot-user-nexus[record]'"
        raise RecordingError(text) from error
    else:
        return record_command.record(client, options)
    finally:
        client.close()


def recording_settings(file: Path | None) -> list[str]:
    """The settings of a robot file for a hub that records into a file from its start."""
    if file is None:
        return []
    if file.exists():
        text = f"{file} exists already; give another name"
        raise RecordingError(text)
    values = {
        "modules.recorder": '{ run = "hub.modules.recorder" }',
        "recording.always": "true",
        "recording.keep": "0",
        "recording.file": json.dumps(str(file.absolute())),
    }
    return [f"{name}={value}" for name, value in values.items()]


def _add_orders(record: CommandParser) -> None:
    orders = record.add_argument_group("orders to the robot's own recorder")
    one = orders.add_mutually_exclusive_group()
    one.add_argument(
        "--start", nargs="?", const="", metavar="NAME", help="begin a recording of this name"
    )
    one.add_argument("--stop", action="store_true", help="end the recording")
    one.add_argument("--split", action="store_true", help="go on in another file")
    one.add_argument("--mark", metavar="TEXT", help="mark this moment")
    one.add_argument(
        "--snapshot", nargs="?", const="", metavar="TEXT",
        help="keep the time around this moment as a file of its own",
    )  # fmt: skip
    orders.add_argument(
        "--before", type=_read(words.seconds_of), default=30.0, metavar="TIME",
        help="how much of a snapshot is before this moment (30 s)",
    )  # fmt: skip
    orders.add_argument(
        "--after", type=_read(words.seconds_of), default=10.0, metavar="TIME",
        help="how much is after it (10 s)",
    )  # fmt: skip


def _read(read: Callable[[object], T]) -> Callable[[str], T]:
    """A reader of an argument."""

    def argument(text: str) -> T:
        try:
            return read(text)
        except RefusedError as error:
            raise argparse.ArgumentTypeError(str(error)) from error

    return argument
