"""The commands of `rune`, their errors and exit codes."""

from __future__ import annotations

import argparse
import functools
import gc
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from hub.command_line import ExitCode, login_name, write_completion
from hub.ipc.endpoints import DEFAULT_ENDPOINT
from hub.plain_text import plain
from rune_tui.commands.arguments import parser
from rune_tui.commands.demo import AUTO, DEMO_LAYOUT
from rune_tui.commands.log_file import LogFile, log_to_file
from rune_tui.commands.own_terminal import ask_terminal
from rune_tui.compositor.depth import ColourDepth
from rune_tui.compositor.glyph_set import GlyphSet
from rune_tui.errors import ConsoleError, DamagedLogError, TunnelError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from rune_tui.layout.spec import LayoutSpec
    from rune_tui.layout.watching import LayoutArrivals, LayoutSource
    from rune_tui.link.fleet_mirrors import FleetMirrors
    from rune_tui.link.hub_tunnel import Tunnel
    from rune_tui.link.robot_links import RobotLinks

_WITHOUT_TERMINAL = "`rune joytest --list` lists what is plugged in"
_COLLECT_AFTER = 10_000
"""Number of new objects between garbage collections; Python's default is 700."""
_CONSOLE_LIBRARIES = ("textual", "rich", "PIL", "lxml", "platformdirs")


class _UsageError(ConsoleError):
    """The command's arguments do not fit."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `rune`; returns the exit code."""
    # NumPy's thread pool would lengthen the start.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # The start makes no garbage; collections would take a tenth of its time.
    gc.set_threshold(_COLLECT_AFTER)
    from hub.errors import CentralUnreachableError, HubError

    words = list(sys.argv[1:] if arguments is None else arguments)
    options = parser().parse_args(words[:1] if words[:1] == ["study"] else words)
    commands: dict[str, Callable[[argparse.Namespace], int]] = {
        "run": _run,
        "demo": _demo,
        "drive": _drive,
        "check": _check,
        "layout": _layout,
        "layouts": _layouts,
        "completion": lambda options: write_completion(parser, options.shell),
        "shot": _shot,
        "replay": _replay,
        "terminal": _terminal,
        "draw-test": _draw_test,
        "joytest": _joytest,
        "pad": _pad,
        "study": lambda _: _study(words[1:]),
    }
    try:
        return commands[options.command](options)
    except KeyboardInterrupt:
        return ExitCode.OK
    except ModuleNotFoundError as error:
        if error.name not in _CONSOLE_LIBRARIES:
            raise
        text = f"{error.name} is missing; install it with pip install 'robot-user-nexus[console]'"
        _report(text)
        return ExitCode.USAGE
    except (TunnelError, CentralUnreachableError) as error:
        _report(str(error))
        return ExitCode.NO_HUB
    except (ConsoleError, HubError) as error:
        _report(str(error))
        return ExitCode.FAULT if isinstance(error, DamagedLogError) else ExitCode.USAGE
    except OSError as error:
        _report(f"the output cannot be written: {error.strerror}")
        return ExitCode.FAULT


def _run(options: argparse.Namespace) -> int:
    from contextlib import ExitStack

    from rune_tui.commands.fleet import fleets_of

    _need_screen(options.layouts, options.set)
    with ExitStack() as stack:
        hubs = _endpoints(options.hub)
        fleets = stack.enter_context(fleets_of(options))
        names = stack.enter_context(_made(options.layouts, hubs, options, fleets))
        source = _source(names, options.set, watched=options.watch, arrivals=fleets.arrivals)
        log = log_to_file()
        tunnels = stack.enter_context(_tunnels(options, source.layout))
        links = _links(source.layout, hubs, options.keys, tunnels, options.operator, fleets)
        return _console(source, links, options, log)


def _made(
    names: Sequence[str],
    hubs: Sequence[str],
    options: argparse.Namespace,
    fleets: FleetMirrors,
) -> AbstractContextManager[list[str]]:
    """The names of layouts, with the path of a file that is made in place of the name auto."""
    from rune_tui.commands.auto import with_file

    if options.fleet and (options.hub or options.ssh):
        text = "--fleet finds the robots' hubs by itself; leave out --hub and --ssh"
        raise _UsageError(text)
    if options.fleet and [*names] == [AUTO]:
        from rune_tui.commands.fleet import with_fleet_files

        return with_fleet_files(fleets, options.fleet_name, options.only)
    if AUTO in names and options.ssh:
        text = "auto asks the hub itself: on the robot, `rune layout auto -o FILE` makes the file"
        raise _UsageError(text)
    return with_file(names, [*hubs, DEFAULT_ENDPOINT][0], options.keys)


def _layout(options: argparse.Namespace) -> int:
    from hub import files
    from rune_tui.commands.auto import auto_layout

    text = auto_layout(_endpoints([options.hub])[0], options.keys)
    if options.output is None:
        sys.stdout.write(text)
    else:
        files.write_output(options.output, text.encode(), sync=False)
    return ExitCode.OK


def _demo(options: argparse.Namespace) -> int:
    from contextlib import ExitStack

    from rune_tui.commands.auto import with_file
    from rune_tui.commands.demo import ARENAS, DemoHubs, demo_layout, demo_robots

    named, arena = options.layout or "", _arena(options.arena)
    if named in ARENAS and not Path(named).exists():
        named, arena = "", arena or named
    layout = demo_layout(arena, options.robot, named)
    _need_screen([layout], options.set)
    log = log_to_file()
    with ExitStack() as stack:
        hubs = stack.enter_context(DemoHubs(log.path))
        if layout in (DEMO_LAYOUT, AUTO):  # one robot, whose hub starts while the console is loaded
            robots, _ = demo_robots(["robot"], arena, options.robot)
            _say_start(1)
            hubs.start(robots, arena)
            import rune_tui.app  # noqa: F401

        if layout == AUTO:
            (layout,) = stack.enter_context(with_file([layout], hubs.endpoints()[0]))
        source = _source([layout], options.set, watched=True)
        roles = [each.name for each in source.layout.robots]
        robots, arena = demo_robots(roles, arena, options.robot)
        if not hubs:
            _say_start(len(robots))
        hubs.start(robots[len(hubs) :], arena)
        links = _links(source.layout, hubs.endpoints(), operator=options.operator)
        return _console(source, links, options, log)


def _drive(options: argparse.Namespace) -> int:
    from rune_tui.commands import drive

    _need_screen([], ())
    log = log_to_file()

    def show(layout: str, hub: str) -> int:
        source = _source([layout], (), watched=False)
        links = _links(source.layout, [hub], operator=options.operator)
        return _console(source, links, options, log)

    return drive.run(options, log.path, show)


def _say_start(robots: int) -> None:
    those = "a simulated robot" if robots == 1 else f"{robots} simulated robots"
    sys.stderr.write(f"rune: starting {those} and the console; this takes some seconds\n")
    sys.stderr.flush()


def _source(
    names: Sequence[str],
    variables: Sequence[tuple[str, str]],
    *,
    watched: bool,
    arrivals: LayoutArrivals | None = None,
) -> LayoutSource:
    """The layouts of these names; reads all now, so that mistakes appear at the start."""
    from rune_tui.layout.watching import LayoutSource

    layouts = [_load(name, variables) for name in names]
    read = functools.partial(_load, variables=variables)
    return LayoutSource(names, read, layouts[0], watched=watched, arrivals=arrivals)


def _check(options: argparse.Namespace) -> int:
    from rune_tui.errors import LayoutError
    from rune_tui.layout.arrangement_notes import arrangement_notes
    from rune_tui.layout.key_notes import key_notes

    code = ExitCode.OK
    for path in options.layouts:
        try:
            layout = _load(path, options.set)
        except LayoutError as error:
            sys.stderr.write(f"{plain(str(error), lines=True)}\n")
            code = ExitCode.USAGE
        else:
            sys.stdout.write(f"{plain(path)}: ok\n")
            sys.stdout.writelines(f"  {line}\n" for line in arrangement_notes(layout))
            sys.stdout.writelines(
                f"  note: {note}\n" for note in (*layout.notes, *key_notes(layout))
            )
    return code


def _arena(named: str | None) -> str:
    """Absolute path of an arena file; the name of a shipped arena as it is; empty if none."""
    path = Path(named or "")
    if path.suffix != ".toml":
        return named or ""
    if not path.is_file():
        text = f"there is no arena file {named}"
        raise _UsageError(text)
    return str(path.resolve())


def _layouts(options: argparse.Namespace) -> int:
    import json

    from rune_tui.startup.opening import shipped_layouts

    shipped = shipped_layouts()
    widest = max(map(len, shipped))
    for name, meaning in shipped.items():
        if options.json:
            sys.stdout.write(json.dumps({"name": name, "meaning": meaning}) + "\n")
        else:
            sys.stdout.write(f"{name:{widest}}  {meaning}\n")
    return ExitCode.OK


def _shot(options: argparse.Namespace) -> int:
    from contextlib import ExitStack

    from rune_tui.commands import shot
    from rune_tui.commands.demo import DemoHubs, demo_robots
    from rune_tui.commands.fleet import fleets_of
    from rune_tui.compositor.picture import PictureFile

    if (options.robot or options.arena) and not options.demo:
        text = "--robot, --autopilot and --arena choose what --demo starts; add --demo"
        raise _UsageError(text)
    arena = _arena(options.arena)
    path: Path = options.output
    glyphs = GlyphSet(options.glyphs or GlyphSet.HALF)
    output = PictureFile(path, depth=ColourDepth(options.colors), glyphs=glyphs)
    with ExitStack() as stack:

        def started(roles: Sequence[str]) -> list[str]:
            robots, where = demo_robots(roles, arena, options.robot)
            demo = stack.enter_context(DemoHubs(log_to_file().path))
            demo.start(robots, where)
            return demo.endpoints()

        hubs = _endpoints(options.hub)
        if options.demo and options.layout == AUTO:
            hubs = started(["robot"])
        fleets = stack.enter_context(fleets_of(options))
        name, *_ = stack.enter_context(_made([options.layout], hubs, options, fleets))
        layout = _load(name, options.set)
        if options.demo and not hubs:
            hubs = started([each.name for each in layout.robots])
        tunnels = stack.enter_context(_tunnels(options, layout))
        answered = shot.take(
            layout,
            _links(layout, hubs, options.keys, tunnels, fleets=fleets),
            size=options.size,
            seconds=options.seconds,
            offline=options.offline,
            output=output,
        )
    if answered or options.offline:
        return ExitCode.OK
    where = " and ".join(hubs or [robot.hub for robot in layout.robots])
    text = f"no hub answered at {where}, so {path} is not written; --offline still draws it"
    _report(text)
    return ExitCode.NO_HUB


def _replay(options: argparse.Namespace) -> int:
    from rune_tui.replay import opening

    if options.set and options.layout is None:
        text = "--set needs --layout: a recorded layout keeps the values that it had"
        raise _UsageError(text)
    layout = _load(options.layout, options.set) if options.layout is not None else None
    opened = opening.opener(options.files, layout, topics=options.topics, unpacked=options.unpack)
    if options.export is not None:
        from rune_tui.replay.exporting import export

        _report(*export(options, opened))
        return ExitCode.OK
    _need_screen([], ())
    log_to_file()
    from rune_tui.replay.command import show

    _report(*show(options, opened, lambda: ask_terminal(options)[:3]))
    return ExitCode.OK


def _joytest(options: argparse.Namespace) -> int:
    from rune_tui.commands import joytest

    if options.layout is not None:
        _watch_layouts_joysticks(options)
    elif options.list or options.json:
        sys.stdout.write(joytest.listed(as_json=options.json))
    elif options.udev:
        sys.stdout.write(joytest.rules())
    elif options.learn:
        joytest.learn()
    else:
        _need_terminal(instead=_WITHOUT_TERMINAL)
        joytest.watch()
    return ExitCode.OK


def _watch_layouts_joysticks(options: argparse.Namespace) -> None:
    from rune_tui.commands import joytest

    if options.list or options.json or options.udev or options.learn:
        text = "joytest takes a layout, or one of --list, --udev, --learn and --json, not both"
        raise _UsageError(text)
    joysticks = _load(options.layout, options.set).joysticks
    _need_terminal(instead=_WITHOUT_TERMINAL)
    if not joysticks:
        text = f"{options.layout} has no joystick; leave it out to see what is plugged in"
        raise _UsageError(text)
    joytest.watch(joysticks)


def _pad(options: argparse.Namespace) -> int:
    from hub.ipc.endpoints import endpoint_of
    from rune_tui.commands import pad

    _refuse_ssh_with_keys(options)
    if not (options.hub or options.ssh):
        text = "say where the robot's hub is: `rune pad HOST`, or `rune pad --ssh USER@ROBOT`"
        raise _UsageError(text)
    log_to_file()
    pad.run(
        endpoint_of(options.hub or "127.0.0.1"),
        ssh=options.ssh,
        keys=options.keys,
        device=options.device,
        operator=options.operator or "",
    )
    return ExitCode.OK


def _study(arguments: Sequence[str]) -> int:
    from rune_study.cli import main as study

    return study(arguments)


def _console(
    source: LayoutSource, links: RobotLinks, options: argparse.Namespace, log: LogFile
) -> int:
    from rune_tui.app import Console

    traits, answers, took, _ = ask_terminal(options)
    gc.freeze()  # loaded modules stay: garbage collection skips them
    round_trip = took if answers.complete else 0.0
    given = (source, links, traits, round_trip, log.trouble)
    if options.conductor is None:
        console = Console(*given)
    else:
        from rune_tui.conducted import ConductedConsole
        from rune_tui.model.operating_limits import NO_LIMITS

        console = conducted = ConductedConsole(*given)
        conducted.conduct_by(options.conductor, options.limits or NO_LIMITS)
    if options.record is not None:
        console.effects.record_into(options.record)
    return console.run_to_end()


def _terminal(options: argparse.Namespace) -> int:
    from rune_tui.terminal.report import as_json, report

    _need_terminal(instead="there is nothing to ask, so call it in the terminal itself")
    sys.stdout.write((as_json if options.json else report)(*ask_terminal(options)))
    return ExitCode.OK


def _draw_test(options: argparse.Namespace) -> int:
    _need_terminal(instead="there is nothing to draw on, so call it in the terminal itself")
    if sys.platform == "win32":
        text = "draw-test works on Unix only"
        raise _UsageError(text)
    from rune_tui.terminal.draw_speed import measure

    traits, _, _, size = ask_terminal(options)
    source, sink = sys.stdin.fileno(), sys.stderr.fileno()
    speed = measure(source, sink, traits, size, options.seconds)
    sys.stdout.write(speed.as_json() if options.json else speed.report())
    return ExitCode.OK if speed.frames else ExitCode.FAULT


def _load(name_or_path: str, variables: Sequence[tuple[str, str]]) -> LayoutSpec:
    from rune_tui.startup.opening import open_layout

    return open_layout(name_or_path, dict(variables))


def _links(
    layout: LayoutSpec,
    hubs: Sequence[str],
    keys: Path | None = None,
    tunnels: Sequence[Tunnel] = (),
    operator: str | None = None,
    fleets: FleetMirrors | None = None,
) -> RobotLinks:
    from rune_tui.link.robot_links import RobotLinks

    if fleets is not None and not hubs:
        fleets.follow(layout)
    who = operator or (fleets and fleets.place.operator_name) or login_name()
    return RobotLinks(layout, hubs, keys=keys, operator=who, tunnels=tunnels, fleets=fleets)


def _tunnels(
    options: argparse.Namespace, layout: LayoutSpec
) -> AbstractContextManager[list[Tunnel]]:
    from rune_tui.link.hub_tunnel import open_tunnels

    _refuse_ssh_with_keys(options)
    if options.ssh and "demo" in options and options.demo:
        text = "--demo brings its own robot; leave out one of --ssh and --demo"
        raise _UsageError(text)
    return open_tunnels(options.ssh, layout, _endpoints(options.hub))


def _refuse_ssh_with_keys(options: argparse.Namespace) -> None:
    if options.ssh and options.keys:
        text = "--keys is for a hub that is reached without ssh; leave out one of --ssh and --keys"
        raise _UsageError(text)


def _endpoints(hubs: Sequence[str]) -> list[str]:
    """Endpoints of HOST, HOST:PORT or whole endpoints."""
    from hub.ipc.endpoints import endpoint_of

    return [endpoint_of(hub) for hub in hubs]


def _need_screen(layouts: Sequence[str], variables: Sequence[tuple[str, str]]) -> None:
    """Refuse a terminal that cannot show the console; report mistakes of layouts first."""
    try:
        _need_terminal(sys.stdout, instead="`rune shot` draws a picture into a file")
    except _UsageError:
        for name in layouts:
            if name != AUTO:
                _load(name, variables)
        raise
    if os.environ.get("TERM", "") == "dumb":
        text = "this terminal can draw nothing (TERM is dumb); open rune in another one"
        raise _UsageError(text)


def _need_terminal(*streams: TextIO | None, instead: str) -> None:
    """Refuse to continue without a terminal; `instead` names an alternative."""
    if not all(stream and stream.isatty() for stream in (sys.stdin, sys.stderr, *streams)):
        text = f"this needs a terminal; without one, {instead}"
        raise _UsageError(text)


def _report(*texts: str) -> None:
    """Write sentences to standard error, without control characters of file names or ssh."""
    sys.stderr.writelines(f"rune: {plain(text, lines=True)}\n" for text in texts)
