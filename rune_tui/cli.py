"""`rune`: arguments, errors in one sentence, exit codes."""

from __future__ import annotations

import argparse
import enum
import functools
import logging
import logging.handlers
import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.errors import ConsoleError, TunnelError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from rune_tui.layout.spec import LayoutSpec
    from rune_tui.layout.watching import LayoutSource
    from rune_tui.link.robot_links import RobotLinks
    from rune_tui.link.tunnel import Tunnel
    from rune_tui.terminal.questions import Answers
    from rune_tui.terminal.traits import Traits

_DEMO_LAYOUT = "demo"
_DEMO_ROBOT = "magellan"
_PICTURE_ENDINGS = (".txt", ".svg", ".png")
_LOG_BYTES = 1_000_000
_LONGEST_NAME = 64
_CONSOLE_LIBRARIES = ("textual", "rich", "PIL", "lxml", "platformdirs")


class _ShowVersion(argparse.Action):
    """Looks the version up when it is asked for: to import what finds it costs 30 ms."""

    def __init__(self, option_strings: Sequence[str], dest: str) -> None:
        text = "show program's version number and exit"
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, help=text)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        sys.stdout.write(f"rune {version('robot-user-nexus')}\n")
        parser.exit()


class ExitCode(enum.IntEnum):
    """How a command ends."""

    OK = 0
    FAULT = 1
    USAGE = 2
    NO_HUB = 3


class _UsageError(ConsoleError):
    """The command cannot be carried out as it was given."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `rune`; returns the exit code."""
    # NumPy's own threads, for products of large matrices, cost each process time at its start.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from hub.errors import CentralUnreachableError, HubError

    options = _parser().parse_args(arguments)
    commands = {
        "run": _run,
        "demo": _demo,
        "check": _check,
        "shot": _shot,
        "terminal": _terminal,
        "joytest": _joytest,
        "pad": _pad,
    }
    try:
        return commands[options.command](options)
    except KeyboardInterrupt:
        return ExitCode.OK
    except ModuleNotFoundError as error:
        if error.name not in _CONSOLE_LIBRARIES:
            raise
        text = f"{error.name} is missing; install it with pip install 'robot-user-nexus[console]'"
        sys.stderr.write(f"rune: {text}\n")
        return ExitCode.USAGE
    except (TunnelError, CentralUnreachableError) as error:
        sys.stderr.write(f"rune: {error}\n")
        return ExitCode.NO_HUB
    except (ConsoleError, HubError) as error:
        sys.stderr.write(f"rune: {error}\n")
        return ExitCode.USAGE
    except OSError as error:
        sys.stderr.write(f"rune: the output cannot be written: {error.strerror}\n")
        return ExitCode.FAULT


def _run(options: argparse.Namespace) -> int:
    _need_terminal()
    source = _source(options.layouts, options.set, watched=options.watch)
    _log_to_file()
    with _tunnels(options, source.layout) as tunnels:
        links = _links(
            source.layout, _endpoints(options.hub), options.keys, tunnels, options.operator
        )
        return _console(source, links, options)


def _demo(options: argparse.Namespace) -> int:
    from contextlib import ExitStack

    from rune_tui.demo import DemoHub

    _need_terminal()
    log = _log_to_file()
    with ExitStack() as stack:
        hubs = [stack.enter_context(DemoHub(_DEMO_ROBOT, log))]
        import rune_tui.app  # noqa: F401 - loaded while the hub starts

        source = _source([options.layout], options.set, watched=True)
        hubs += [stack.enter_context(DemoHub(_DEMO_ROBOT, log)) for _ in source.layout.robots[1:]]
        links = _links(source.layout, [hub.endpoint() for hub in hubs], operator=options.operator)
        return _console(source, links, options)


def _source(
    names: Sequence[str], variables: Sequence[tuple[str, str]], *, watched: bool
) -> LayoutSource:
    """The layouts of these names; all of them are read, so that none is found bad on the way."""
    from rune_tui.layout.watching import LayoutSource

    layouts = [_load(name, variables) for name in names]
    read = functools.partial(_load, variables=variables)
    return LayoutSource(names, read, layouts[0], watched=watched)


def _check(options: argparse.Namespace) -> int:
    from rune_tui.errors import LayoutError
    from rune_tui.layout.key_notes import key_notes

    code = ExitCode.OK
    for path in options.layouts:
        try:
            layout = _load(path, options.set)
        except LayoutError as error:
            sys.stderr.write(f"{error}\n")
            code = ExitCode.USAGE
        else:
            sys.stdout.write(f"{path}: ok\n")
            sys.stdout.writelines(f"  note: {note}\n" for note in key_notes(layout))
    return code


def _shot(options: argparse.Namespace) -> int:
    from contextlib import ExitStack

    from rune_tui import shot
    from rune_tui.demo import DemoHub

    path: Path = options.output
    if path.suffix not in _PICTURE_ENDINGS:
        text = f"{path}: the name has to end in one of {', '.join(_PICTURE_ENDINGS)}"
        raise _UsageError(text)
    layout = _load(options.layout, options.set)
    with ExitStack() as stack:
        hubs = _endpoints(options.hub)
        if options.demo:
            log = _log_to_file()
            demo = [stack.enter_context(DemoHub(_DEMO_ROBOT, log)) for _ in layout.robots]
            hubs = [hub.endpoint() for hub in demo]
        tunnels = stack.enter_context(_tunnels(options, layout))
        answered = shot.take(
            layout,
            _links(layout, hubs, options.keys, tunnels),
            size=options.size,
            seconds=options.seconds,
            depth=ColourDepth(options.colors),
            glyphs=GlyphSet(options.glyphs or GlyphSet.HALF),
            path=path,
        )
    if answered:
        return ExitCode.OK
    sys.stderr.write(f"rune: no hub answered, {path} shows that; is rune-hub running?\n")
    return ExitCode.NO_HUB


def _joytest(options: argparse.Namespace) -> int:
    from rune_tui import joytest

    if options.list or options.json:
        sys.stdout.write(joytest.listed(as_json=options.json))
    elif options.udev:
        sys.stdout.write(joytest.rules())
    elif options.learn:
        joytest.learn()
    else:
        _need_terminal()
        joytest.watch()
    return ExitCode.OK


def _pad(options: argparse.Namespace) -> int:
    from rune_tui import pad
    from rune_tui.layout.names import endpoint_of

    _refuse_two_ways(options)
    if not (options.hub or options.ssh):
        text = "say where the robot's hub is: `rune pad HOST`, or `rune pad --ssh USER@ROBOT`"
        raise _UsageError(text)
    _log_to_file()
    pad.run(
        endpoint_of(options.hub or "127.0.0.1"),
        ssh=options.ssh,
        keys=options.keys,
        device=options.device,
        operator=options.operator or "",
    )
    return ExitCode.OK


def _console(source: LayoutSource, links: RobotLinks, options: argparse.Namespace) -> int:
    from rune_tui.app import Console

    traits, answers, took, _ = _asked_terminal(options)
    return Console(source, links, traits, took if answers.complete else 0.0).run_to_end()


def _terminal(options: argparse.Namespace) -> int:
    from rune_tui.terminal.report import as_json, report

    _need_terminal()
    sys.stdout.write((as_json if options.json else report)(*_asked_terminal(options)))
    return ExitCode.OK


def _asked_terminal(options: argparse.Namespace) -> tuple[Traits, Answers, float, tuple[int, int]]:
    """What the terminal can do, what it said, how long that took [s], and its size."""
    from rune_tui.terminal.questions import Answers
    from rune_tui.terminal.traits import traits_of

    answers, took = Answers(), 0.0
    if sys.platform != "win32":
        from rune_tui.terminal.asking import ask_own

        answers, took = ask_own()
    columns, rows = shutil.get_terminal_size()
    depth = ColourDepth(options.colors) if options.colors else None
    glyphs = GlyphSet(options.glyphs) if options.glyphs else None
    traits = traits_of(
        answers, os.environ, (columns, rows), depth=depth, glyphs=glyphs, aspect=options.aspect
    )
    return traits, answers, took, (columns, rows)


def _load(name_or_path: str, variables: Sequence[tuple[str, str]]) -> LayoutSpec:
    from rune_tui.opening import open_layout

    return open_layout(name_or_path, dict(variables))


def _links(
    layout: LayoutSpec,
    hubs: Sequence[str],
    keys: Path | None = None,
    tunnels: Sequence[Tunnel] = (),
    operator: str | None = None,
) -> RobotLinks:
    from rune_tui.desk import operator_name
    from rune_tui.link.robot_links import RobotLinks

    return RobotLinks(
        layout, hubs, keys=keys, operator=operator or operator_name(), tunnels=tunnels
    )


def _tunnels(
    options: argparse.Namespace, layout: LayoutSpec
) -> AbstractContextManager[list[Tunnel]]:
    from rune_tui.link.tunnel import open_tunnels

    _refuse_two_ways(options)
    if options.ssh and "demo" in options and options.demo:
        text = "--demo brings its own robot; leave out one of --ssh and --demo"
        raise _UsageError(text)
    return open_tunnels(options.ssh, layout, _endpoints(options.hub))


def _refuse_two_ways(options: argparse.Namespace) -> None:
    if options.ssh and options.keys:
        text = "--keys is for a hub that is reached without ssh; leave out one of --ssh and --keys"
        raise _UsageError(text)


def _endpoints(hubs: Sequence[str]) -> list[str]:
    """HOST, HOST:PORT or whole endpoints as endpoints."""
    from rune_tui.layout.names import endpoint_of

    return [endpoint_of(hub) for hub in hubs]


def _need_terminal() -> None:
    if not all(stream and stream.isatty() for stream in (sys.stdin, sys.stderr)):
        text = "this needs a terminal; without one, `rune shot` draws a picture into a file"
        raise _UsageError(text)


def _log_to_file() -> Path:
    """Send the log to the user's log folder, away from the picture; the file."""
    import platformdirs

    folder = Path(platformdirs.user_log_dir("rune", appauthor=False))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "rune.log"
        handler = logging.handlers.RotatingFileHandler(
            path, maxBytes=_LOG_BYTES, backupCount=2, encoding="utf-8"
        )
    except OSError as error:
        text = f"the log cannot be written: {error}"
        raise _UsageError(text) from error
    handler.setFormatter(logging.Formatter("%(asctime)s console %(levelname)s %(message)s"))
    logging.basicConfig(level=logging.INFO, handlers=[handler])
    return path


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


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = -1.0
    if not 0.0 <= seconds <= 3600.0:
        reason = f"{text!r} is no time from 0 to 3600 s"
        raise argparse.ArgumentTypeError(reason)
    return seconds


def _name(text: str) -> str:
    name = text.strip()
    if not name or not name.isprintable() or len(name) > _LONGEST_NAME:
        reason = f"{text!r:.80} is no name of at most {_LONGEST_NAME} characters"
        raise argparse.ArgumentTypeError(reason)
    return name


def _aspect(text: str) -> float:
    try:
        ratio = float(text)
    except ValueError:
        ratio = 0.0
    if not 1.0 <= ratio <= 4.0:
        reason = f"{text!r} is no ratio from 1 to 4, such as 2.2"
        raise argparse.ArgumentTypeError(reason)
    return ratio


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="rune",
        description="Rune, the Robot-User Nexus: drive robots from a terminal.",
        epilog="Exit codes: 0 ok, 1 a fault, 2 wrong usage or layout, 3 no hub.",
    )
    parser.add_argument("--version", action=_ShowVersion)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    layout_help = "a layout file, or the name of a shipped layout"
    keys_help = "your key's file, for a hub on another machine"
    hub_help = "HOST, HOST:PORT or tcp://HOST:PORT instead of the layout's; once for each robot"
    ssh_help = "[USER@]HOST[:PORT]: go to the robot's hub through ssh; once for each robot"
    colors = [depth.value for depth in ColourDepth]
    colors_help = "what the terminal can show, where it does not say so itself"
    glyphs = [glyph_set.value for glyph_set in GlyphSet]
    glyphs_help = "what pictures are made of in truecolour (half); `rune terminal` shows each"
    aspect_help = "height of a cell over its width, where the terminal does not say (2)"

    run = commands.add_parser("run", help="open the console with a layout")
    run.add_argument("layouts", nargs="+", metavar="LAYOUT", help=layout_help)
    run.add_argument("--watch", action="store_true", help="follow the files when they are saved")
    run.add_argument("--hub", action="append", default=[], metavar="HUB", help=hub_help)
    run.add_argument("--ssh", action="append", default=[], metavar="HOST", help=ssh_help)
    run.add_argument("--keys", type=Path, help=keys_help)

    demo = commands.add_parser("demo", help="open the console on a simulated robot")
    demo.add_argument("layout", nargs="?", default=_DEMO_LAYOUT, help="default: %(default)s")

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
    terminal = commands.add_parser("terminal", help="say what this terminal can do, and why")
    terminal.add_argument("--json", action="store_true", help="in one line, for machines")
    for command in (run, demo):
        command.add_argument(
            "--operator",
            type=_name,
            metavar="NAME",
            help="who sits here, if not the login",
        )
    for command in (run, demo, shot, terminal):
        command.add_argument("--glyphs", choices=glyphs, help=glyphs_help)
    for command in (run, demo, terminal):
        command.add_argument("--colors", choices=colors, help=colors_help)
        command.add_argument("--aspect", type=_aspect, metavar="RATIO", help=aspect_help)
    joytest = commands.add_parser("joytest", help="show what joysticks report")
    what = joytest.add_mutually_exclusive_group()
    what.add_argument("--list", action="store_true", help="list what is plugged in, and end")
    what.add_argument("--udev", action="store_true", help="print the rule that lets you read it")
    what.add_argument("--learn", action="store_true", help="print how layouts name what you move")
    joytest.add_argument("--json", action="store_true", help="the list, for programs")
    _add_pad(commands, keys_help)
    for command in (run, demo, check, shot):
        command.add_argument(
            "--set",
            type=_variable,
            action="append",
            default=[],
            metavar="NAME=VALUE",
            help="give a variable of the layout this value; as often as needed",
        )
    return parser


def _add_pad(commands: argparse._SubParsersAction[argparse.ArgumentParser], keys_help: str) -> None:
    pad = commands.add_parser(
        "pad",
        help="send this machine's joystick to a console that runs elsewhere",
        description="Send a joystick of this machine to consoles that run elsewhere, on the robot "
        "for instance. It goes through the robot's hub. A console at that hub takes it "
        "where its layout has a joystick that it fits and nothing else is plugged in there.",
        epilog="Ctrl-C ends it. What is held is let go of there, as it is when this machine falls "
        "silent for 0.25 s; then nothing drives before it has been neutral. Exit codes: 0 ended "
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
        help="go to the robot through ssh; HOST is then its hub as the robot knows it (127.0.0.1)",
    )
    pad.add_argument(
        "--device",
        default="",
        metavar="N|NAME",
        help="which joystick: its place in `rune joytest --list`, or a part of its name; "
        "default: the first",
    )
    pad.add_argument(
        "--operator",
        type=_name,
        metavar="NAME",
        help="for the console of this operator only, as it stands in its control pane; "
        "default: for any at this hub",
    )
