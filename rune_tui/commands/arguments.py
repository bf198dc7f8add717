"""The arguments of `rune`: commands, options and their values."""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

from hub.command_line import CommandParser, Commands, ShowVersion, add_completion, number_type
from hub.recording.unpack_option import add_unpack
from rune_tui.commands.demo import (
    ARENAS,
    AUTO,
    AUTOPILOT_PREFIX,
    AUTOPILOTS,
    DEMO_LAYOUT,
    ROBOTS,
)
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import GlyphSet

if TYPE_CHECKING:
    from rune_tui.model.operating_limits import OperatingLimits

_LONGEST_NAME = 64
_ASPECT_HELP = "height of a cell over its width, where the terminal does not say (2)"


def _variable(text: str) -> tuple[str, str]:
    name, is_given, value = text.partition("=")
    if is_given and name and text.isprintable():
        return name, value
    reason = f"{text!r} is no NAME=VALUE"
    raise argparse.ArgumentTypeError(reason)


def _size(text: str) -> tuple[int, int]:
    columns, _, rows = text.partition("x")
    if columns.isdigit() and rows.isdigit() and all(0 < int(n) <= 1000 for n in (columns, rows)):
        return int(columns), int(rows)
    reason = f"{text!r} is no size such as 120x40, each number 1 to 1000"
    raise argparse.ArgumentTypeError(reason)


def _limits(text: str) -> OperatingLimits:
    from rune_tui.model.operating_limits import OperatingLimits

    limits = OperatingLimits.read(text)
    if limits is None:
        reason = f"{text!r:.80} is none such as goals/off"
        raise argparse.ArgumentTypeError(reason)
    return limits


def _recording_folder(text: str) -> Path:
    """A folder for recordings; refused where none can be made, before any robot is driven."""
    if importlib.util.find_spec("lz4") is None:
        from rune_tui.files.user_files import NO_LZ4

        raise argparse.ArgumentTypeError(NO_LZ4)
    return Path(text)


def _name(text: str) -> str:
    name = text.strip()
    if not name or not name.isprintable() or len(name) > _LONGEST_NAME:
        reason = f"{text!r:.80} is no name of at most {_LONGEST_NAME} characters"
        raise argparse.ArgumentTypeError(reason)
    return name


_seconds = number_type(float, 0.0, 3600.0, "time from 0 to 3600 s")
_aspect = number_type(float, 1.0, 4.0, "ratio from 1 to 4, such as 2.2")


def parser() -> CommandParser:
    """The parser of the command line."""
    parser = CommandParser(
        prog="rune",
        description="Rune, the Robot-User Nexus: drive robots from a terminal.",
        epilog="Exit codes: 0 ok, 1 a fault, 2 wrong usage or layout, 3 no hub, 4 a recording "
        "that lacks something.",
    )
    parser.add_argument("--version", action=ShowVersion)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    layout_help = "a layout file, the name of a shipped layout, or auto: made for the robot"
    keys_help = "your key's file, for a hub on another machine"
    hub_help = "HOST, HOST:PORT or tcp://HOST:PORT instead of the layout's; once for each robot"
    ssh_help = "[USER@]HOST[:PORT]: go to the robot's hub through ssh; once for each robot"
    colors = [depth.value for depth in ColourDepth]
    colors_help = "what the terminal can show, where it does not say so itself"
    glyphs = [glyph_set.value for glyph_set in GlyphSet]
    glyphs_help = "what pictures are made of in truecolour (half); `rune terminal` shows each"

    run = commands.add_parser("run", help="open the console with a layout")
    run.add_argument("layouts", nargs="+", metavar="LAYOUT", help=layout_help)
    run.add_argument("--watch", action="store_true", help="follow the files when they are saved")
    run.add_argument("--hub", action="append", default=[], metavar="HUB", help=hub_help)
    run.add_argument("--ssh", action="append", default=[], metavar="HOST", help=ssh_help)
    run.add_argument("--keys", type=Path, help=keys_help)

    demo = commands.add_parser("demo", help="open the console on a simulated robot")
    demo.add_argument(
        "layout",
        nargs="?",
        help=f"a layout, {AUTO}, or one of the arenas {', '.join(ARENAS)}; "
        f"default: {DEMO_LAYOUT} for {ROBOTS[0]}, {AUTO} for another robot",
    )
    demo.advice = "--arena chooses the arena of a layout; rune demo --help says more"

    drive = _add_drive(commands)
    _add_layout(commands, keys_help)

    check = commands.add_parser("check", help="report all that is wrong with layout files")
    check.add_argument("layouts", nargs="+", metavar="LAYOUT", help=layout_help)

    shot = commands.add_parser("shot", help="draw a picture of a layout without a terminal")
    shot.add_argument("layout", help=layout_help)
    shot.add_argument("-o", "--output", type=Path, required=True, help="FILE.txt, .svg or .png")
    shot.add_argument(
        "--size", type=_size, default=(120, 40), metavar="COLUMNSxROWS", help="default: 120x40"
    )
    shot.add_argument("--seconds", type=_seconds, default=3.0, help="watch so long (%(default)s)")
    shot.add_argument("--colors", choices=colors, default=colors[0], help="default: %(default)s")
    source = shot.add_mutually_exclusive_group()
    source.add_argument("--hub", action="append", default=[], metavar="HUB", help=hub_help)
    shot.add_argument("--ssh", action="append", default=[], metavar="HOST", help=ssh_help)
    shot.add_argument("--keys", type=Path, help=keys_help)
    source.add_argument("--demo", action="store_true", help="on a simulated robot of its own")
    _add_robot_and_arena(demo, shot)
    shot.add_argument("--offline", action="store_true", help="draw it even if no hub answers")
    replay = _add_replay(commands)
    terminal, draw_test = _add_terminal(commands)
    _add_fleet(run, shot)
    _add_operator_and_record(run, demo, drive)
    for command in (run, demo, drive, shot, replay, terminal, draw_test):
        command.add_argument("--glyphs", choices=glyphs, help=glyphs_help)
    for command in (run, demo, drive, replay, terminal, draw_test):
        command.add_argument("--colors", choices=colors, help=colors_help)
        command.add_argument("--aspect", type=_aspect, metavar="RATIO", help=_ASPECT_HELP)
    joytest = _add_joytest(commands)
    _add_pad(commands, keys_help)
    _add_without_options(commands)
    for command in (run, demo, check, shot, replay, joytest):
        command.add_argument(
            "--set",
            type=_variable,
            action="append",
            default=[],
            metavar="NAME=VALUE",
            help="give a variable of the layout this value; as often as needed",
        )
    return parser


def _add_drive(commands: Commands) -> CommandParser:
    drive = commands.add_parser(
        "drive",
        help="find a vehicle or a robot with ROS, start its hub, and open the console on it",
        description="Find a vehicle with an autopilot or a robot with ROS, say what is unsafe in "
        "it, start a hub for it on this machine, and open the console with a layout made for it. "
        "The hub ends with the console. Nothing in the robot changes, and a vehicle is armed only "
        "when you arm it.",
        epilog="Exit codes: 0 ended by you, 1 a fault, or it cannot be driven, 2 wrong usage, 3 "
        "there is no vehicle or robot.",
    )
    drive.add_argument(
        "address",
        metavar="ADDRESS",
        help="mavlink:udp://:14550, mavlink:tcp://HOST:5760, mavlink:/dev/ttyACM0; with ROS: "
        "ws://HOST:8765 of a bridge for Foxglove, zenoh+tcp://HOST:7447 or zenoh+tls://HOST:7447 "
        "of a Zenoh router",
    )
    drive.add_argument(
        "--ssh",
        default="",
        metavar="[USER@]HOST[:PORT]",
        help="of a robot with ROS: go there by ssh; ADDRESS is as the robot sees it. Where Rune is "
        "installed there, its hub runs there",
    )
    drive.add_argument(
        "--namespace",
        default="",
        metavar="/NAME",
        help="of several robots with ROS, the one whose topics begin so; /: the one without a name",
    )
    drive.add_argument(
        "--tls",
        default="",
        metavar="FOLDER",
        help="folder with certificates, for zenoh+tls://; with --ssh it is on the robot",
    )
    drive.add_argument("-o", "--output", type=Path, metavar="FILE.toml", help="keep its robot file")
    system = number_type(int, 0, 255, "number from 0 to 255")
    drive.add_argument(
        "--system", type=system, default=0, metavar="N", help="its number; 0: the only one"
    )
    drive.add_argument("--key", type=Path, metavar="FILE", help="file of its signing key")
    drive.add_argument(
        "-y", "--yes", action="store_true", help="open the console also if something is unsafe"
    )
    return drive


def _add_replay(commands: Commands) -> CommandParser:
    replay = commands.add_parser(
        "replay",
        help="show a recording, as the console drew it",
        epilog="Space plays and pauses; the first row names the other keys. Exit codes: 0 ended by "
        "you, 1 nothing of a damaged file can be read, 2 wrong usage, or nothing can be shown.",
    )
    replay.add_argument("files", nargs="+", type=Path, metavar="FILE", help="a recording")
    add_unpack(replay)
    replay.add_argument("--layout", help="a layout in place of the recorded one")
    replay.add_argument(
        "--topics",
        action="store_true",
        help="show the topics as a tree, a table and a plot, also those of a recording of Rune",
    )
    replay.add_argument(
        "--start",
        default="0",
        metavar="TIME",
        help="begin there: 90, 1:30 or 1:02:30 (%(default)s)",
    )
    rate = number_type(float, 0.1, 100.0, "rate from 0.1 to 100")
    replay.add_argument("--rate", type=rate, default=1.0, help="log time over time (%(default)s)")
    replay.add_argument("--loop", action="store_true", help="begin again at the end")
    replay.add_argument(
        "--export",
        type=Path,
        metavar="FILE",
        help="write the picture at --start (.png, .svg, .txt), a video from there (.mp4, .gif), "
        "or a report of all (.html)",
    )
    replay.add_argument("--force", action="store_true", help="replace a file of this name")
    replay.add_argument("--end", metavar="TIME", help="end of a video; default: the recording's")
    fps = number_type(float, 0.1, 60.0, "number of frames from 0.1 to 60")
    replay.add_argument("--fps", type=fps, default=10.0, help="frames of a video (%(default)s 1/s)")
    scale = number_type(int, 2, 32, "width from 2 to 32")
    replay.add_argument(
        "--scale", type=scale, default=8, help="width of a cell in a video (%(default)s px)"
    )
    replay.add_argument(
        "--lossless", action="store_true", help="keep each pixel in an .mp4; some players fail"
    )
    replay.add_argument(
        "--as-seen", action="store_true", help="export without border, as it was on the screen"
    )
    return replay


def _add_operator_and_record(*commands: CommandParser) -> None:
    for command in commands:
        command.add_argument(
            "--operator",
            type=_name,
            metavar="NAME",
            help="your name as others read it, if not the login; a key's name is another",
        )
        command.add_argument(
            "--record",
            type=_recording_folder,
            metavar="DIR",
            help="record into a file in this folder from the start; `rune replay` shows it",
        )
        # An inherited socket of the program that conducts the console: `rune_tui/conducted.py`.
        command.add_argument("--conductor", type=int, help=argparse.SUPPRESS)
        # What it limits: `rune_tui/model/operating_limits.py`.
        command.add_argument("--limits", type=_limits, help=argparse.SUPPRESS)


def _add_fleet(*commands: CommandParser) -> None:
    place = "a router of the robots' fleet, tcp/HOST:PORT or tls/HOST:PORT; with tls, --keys is "
    for command in commands:
        command.add_argument(
            "--fleet", metavar="PLACE", help=f"{place}the folder of your certificate"
        )
        command.add_argument(
            "--fleet-name", default="rune", metavar="NAME", help="its name, for auto (%(default)s)"
        )
        command.add_argument(
            "--as",
            dest="fleet_operator",
            default="",
            metavar="ROLE:NAME",
            help="who you are in the fleet, as in your certificate (the only one in the folder, or "
            "operate: and your login)",
        )
        command.add_argument(
            "--only",
            action="append",
            default=[],
            metavar="ROBOT",
            help="with auto and --fleet: this robot; once for each; default: all that are there",
        )


def _add_without_options(commands: Commands) -> None:
    commands.add_parser("study", help="plan and run studies; rune study --help says more")
    add_completion(commands)


def _add_robot_and_arena(*commands: CommandParser) -> None:
    robot_help = "the simulated robot; default: the one that suits the arena"
    arena_help = "a shipped arena, or the path of one that you wrote"
    for command in commands:
        robot = command.add_mutually_exclusive_group()
        robot.add_argument("--robot", choices=ROBOTS, help=robot_help)
        robot.add_argument(
            "--autopilot",
            dest="robot",
            type=_autopilot,
            metavar="|".join(AUTOPILOTS),
            help="a simulated vehicle with an autopilot, driven over MAVLink",
        )
        command.add_argument("--arena", metavar="ARENA", help=arena_help)


def _autopilot(text: str) -> str:
    """The name of a robot of the demo."""
    if text in AUTOPILOTS:
        return AUTOPILOT_PREFIX + text
    message = f"{text!r} is none of {', '.join(AUTOPILOTS)}"
    raise argparse.ArgumentTypeError(message)


def _add_terminal(commands: Commands) -> tuple[CommandParser, CommandParser]:
    terminal = commands.add_parser("terminal", help="say what this terminal can do, and why")
    draw_test = commands.add_parser("draw-test", help="measure how fast this terminal draws")
    draw_test.add_argument(
        "--seconds", type=_seconds, default=5.0, metavar="S", help="how long it draws (5)"
    )
    for command in (terminal, draw_test):
        command.add_argument("--json", action="store_true", help="in one line, for machines")
    return terminal, draw_test


def _add_joytest(commands: Commands) -> CommandParser:
    joytest = commands.add_parser("joytest", help="show what joysticks report")
    joytest.add_argument(
        "layout", nargs="?", metavar="LAYOUT", help="show what becomes of it in this layout"
    )
    what = joytest.add_mutually_exclusive_group()
    what.add_argument("--list", action="store_true", help="list what is plugged in, and end")
    what.add_argument("--udev", action="store_true", help="print the rule that lets you read it")
    what.add_argument("--learn", action="store_true", help="print how layouts name what you move")
    joytest.add_argument("--json", action="store_true", help="the list, for programs")
    return joytest


def _add_pad(commands: Commands, keys_help: str) -> None:
    pad = commands.add_parser(
        "pad",
        help="send this machine's joystick to a console that runs elsewhere",
        description="Send a joystick of this machine to consoles that run elsewhere, on the robot "
        "for instance. It goes through the robot's hub. A console at that hub uses it "
        "if it fits a joystick of the layout and no other device is plugged in there.",
        epilog="Ctrl-C ends it. The console then releases all held controls, as it does after "
        "0.25 s of silence; a control must be neutral before it drives again. Exit codes: 0 ended "
        "by you, 2 wrong usage, or a key that may only watch, 3 no hub.",
    )
    pad.add_argument(
        "hub", nargs="?", default="", metavar="HOST", help="the robot's hub: HOST or HOST:PORT"
    )
    pad.add_argument("--keys", type=Path, metavar="FILE", help=keys_help)
    pad.add_argument(
        "--ssh",
        default="",
        metavar="[USER@]HOST[:PORT]",
        help="go to the robot through ssh; HOST is then its hub as seen from the robot (127.0.0.1)",
    )
    pad.add_argument(
        "--device",
        default="",
        metavar="N|NAME",
        help="which joystick: its number in `rune joytest --list`, or a part of its name; "
        "default: the first",
    )
    pad.add_argument(
        "--operator",
        type=_name,
        metavar="NAME",
        help="for the console of this operator only: the login there, or its own --operator, "
        "not the name of a key; default: for any at this hub",
    )


def _add_layout(commands: Commands, keys_help: str) -> None:
    layouts = commands.add_parser("layouts", help="list the layouts that come with Rune")
    layouts.add_argument("--json", action="store_true", help="JSON, one line a layout")
    layout = commands.add_parser("layout", help="make a layout for a robot")
    tasks = layout.add_subparsers(dest="task", required=True, metavar="TASK")
    auto = tasks.add_parser("auto", help="from what the robot's hub describes, to be edited")
    auto.add_argument("--hub", default="127.0.0.1", help="HOST or HOST:PORT (%(default)s)")
    auto.add_argument("--keys", type=Path, help=keys_help)
    auto.add_argument("-o", "--output", type=Path, help="the file; default: standard output")
