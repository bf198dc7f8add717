"""The options of `rune-hub record` and `rune-hub play`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from hub.command_line import CommandParser, Commands, number_type
from hub.errors import RecordingError
from hub.inspection.run_options import hub_name
from hub.recording.live import words
from hub.recording.unpack_option import add_unpack
from hub.toml_reader import RefusedError

T = TypeVar("T")

_INSTALL = (
    "a library for recordings is missing; install it with pip install 'robot-user-nexus[record]'"
)
_LONGEST = 1000
"""Most letters of a text in `RecordCommand`."""
_FORMATS = ("RLE", "JPEG", "RAW", "WEBP")
"""As in `ImageCoding`, whose import costs every command 0.1 s."""


def add_record(commands: Commands, look: CommandParser) -> None:
    """Add both commands."""
    add_play(commands)
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
    add_topics(what)
    what.add_argument(
        "--pictures", type=reader(words.rate_of), default=5.0, metavar="RATE",
        help="pictures a second of each camera; 0: none (5/s)",
    )  # fmt: skip
    what.add_argument(
        "--size", type=reader(words.size_of), default=(320, 240), metavar="WxH",
        help="largest size of pictures (320x240)",
    )  # fmt: skip
    what.add_argument(
        "--format", choices=_FORMATS, default="WEBP",
        help="coding of pictures (%(default)s)",
    )  # fmt: skip
    what.add_argument(
        "--maps", type=reader(words.seconds_of), default=10.0, metavar="TIME",
        help="time between two maps; 0: none (10 s)",
    )  # fmt: skip
    what.add_argument("--ros-names", action="store_true", help="name topics as ROS 2 does: /tf")
    what.add_argument("--wake", action="store_true", help="keep modules running for the recording")
    ends = record.add_argument_group("when files end")
    ends.add_argument(
        "-d", "--duration", type=reader(words.seconds_of), default=0.0, metavar="TIME",
        help="end after this time",
    )  # fmt: skip
    ends.add_argument(
        "-b", "--max-bytes", type=reader(words.bytes_of), default=0, metavar="SIZE",
        help="end at this size of all files",
    )  # fmt: skip
    ends.add_argument(
        "--split-every", type=reader(words.split_of), default=(0.0, 0), metavar="TIME|SIZE",
        help="go on in another file after '10 min' or at '500 MB'",
    )  # fmt: skip
    ends.add_argument(
        "--least-free", type=reader(words.bytes_of), default=2**30, metavar="SIZE",
        help="stop before the disk has less than this free (1 GiB)",
    )  # fmt: skip
    record.add_argument("--json", action="store_true", help="say what happens as JSON lines")
    record.add_argument("--stop-with-stdin", action="store_true", help="end when stdin ends")
    _add_orders(record)


def run_record(options: argparse.Namespace) -> int:
    """Carry out one of the commands; returns the exit code.

    Raises:
        HubError: It cannot be done.
    """
    if options.command == "play":
        return _run_play(options)
    from hub.inspection import message_commands

    client = message_commands.connect(options.hub, options.command, options.keys)
    try:
        from hub.inspection import record_command
    except ImportError as error:
        raise RecordingError(_INSTALL) from error
    else:
        return record_command.record(client, options)
    finally:
        client.close()


def _run_play(options: argparse.Namespace) -> int:
    try:
        from hub.inspection import play_command
    except ImportError as error:
        raise RecordingError(_INSTALL) from error
    return play_command.play(options)


def add_play(commands: Commands) -> None:
    """Add the command that plays a recording."""
    play = commands.add_parser(
        "play",
        help="play a recording on a hub of its own, for consoles and modules",
        description="Play recordings on a bus of their own: `rune run auto --hub HOST:PORT` and "
        "modules see the robot of the recording. Nothing moves, and commands are refused. Keys: "
        "space pauses, left and right go 5 s, + and - change the rate, q ends.",
    )
    play.add_argument("files", nargs="+", type=Path, metavar="FILE", help="MCAP files or folders")
    add_unpack(play)
    play.add_argument(
        "--rate", type=number_type(float, 0.1, 100.0, "rate from 0.1 to 100"), default=1.0,
        metavar="X", help="seconds of the recording in a second (1)",
    )  # fmt: skip
    play.add_argument(
        "--start", type=reader(words.seconds_of), default=0.0, metavar="TIME",
        help="begin so long after its start",
    )  # fmt: skip
    play.add_argument(
        "--duration", type=reader(words.seconds_of), default=0.0, metavar="TIME",
        help="end after so much of the recording",
    )  # fmt: skip
    play.add_argument("--loop", action="store_true", help="begin again at the end")
    play.add_argument("--paused", action="store_true", help="stand still at the start")
    add_topics(play)
    play.add_argument("--robot", default="", help="which, if it has several")
    play.add_argument(
        "--as", dest="name", type=hub_name, default="", metavar="NAME",
        help="name of its hub on this machine, for --hub; without: the robot's with -recording",
    )  # fmt: skip
    play.add_argument("--json", action="store_true", help="say what happens as JSON lines")


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
    one.add_argument("--mark", metavar="TEXT", type=reader(_mark_text), help="mark this moment")
    one.add_argument(
        "--snapshot", nargs="?", const="", metavar="TEXT", type=reader(_short_text),
        help="keep the time around this moment as a file of its own",
    )  # fmt: skip
    orders.add_argument(
        "--before", type=reader(words.seconds_of), default=30.0, metavar="TIME",
        help="how much of a snapshot is before this moment (30 s)",
    )  # fmt: skip
    orders.add_argument(
        "--after", type=reader(words.seconds_of), default=10.0, metavar="TIME",
        help="how much is after it (10 s)",
    )  # fmt: skip


def add_topics(options: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add the options that choose topics, as `rune-hub record`, `play` and `log` share them."""
    options.add_argument(
        "-e", "--topics", nargs="+", type=reader(words.pattern_of), default=[], metavar="REGEX",
        help="only topics with one of these, such as GCM_RobotState",
    )  # fmt: skip
    options.add_argument(
        "-x", "--exclude", nargs="+", type=reader(words.pattern_of), default=[], metavar="REGEX",
        help="no topics with one of these",
    )  # fmt: skip


def _mark_text(text: object) -> str:
    """The words of a mark.

    Raises:
        RefusedError: There are none, or too many.
    """
    if not str(text).strip():
        reason = "a mark needs words: say what happens at this moment"
        raise RefusedError(reason)
    return _short_text(text)


def _short_text(text: object) -> str:
    """The words of a mark or a snapshot.

    Raises:
        RefusedError: There are too many.
    """
    if len(str(text)) > _LONGEST:
        reason = f"the text has {len(str(text))} letters; {_LONGEST} are the most"
        raise RefusedError(reason)
    return str(text)


def reader(read: Callable[[object], T]) -> Callable[[str], T]:
    """A reader of an argument."""

    def argument(text: str) -> T:
        try:
            return read(text)
        except RefusedError as error:
            raise argparse.ArgumentTypeError(str(error)) from error

    return argument
