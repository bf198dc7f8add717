"""`rune-hub shape`: a bad link between consoles and a hub, as an experiment needs it."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from hub.command_line import CommandParser, Commands, ExitCode, number_type
from hub.errors import EndpointError, HubError, LinkShaperError
from hub.table_text import json_text

if TYPE_CHECKING:
    from hub.ipc.client import Client
    from hub.shaper.profile import LinkProfile
    from hub.shaper.relay import Relay

_CONNECT_S = 5.0
_FIRST, _LAST = 2, 254
"""Addresses 127.0.0.N that are tried."""
_MOST_SEED = 0xFFFF_FFFF


def add_parser(commands: Commands, look: CommandParser) -> None:
    """Add the command."""
    shape = commands.add_parser(
        "shape",
        parents=[look],
        help="carry consoles' connections to a hub as a bad link would",
        description="A relay beside a hub, with delay, jitter, losses, a rate and blackouts. It "
        "prints the address where consoles connect. The same profile and seed give the same link "
        "again. When it ends, the link is cut.",
    )
    shape.add_argument("--profile", default="", metavar="NAME|FILE", help="how the link behaves")
    shape.add_argument(
        "--seed",
        type=number_type(int, 0, _MOST_SEED, f"whole number from 0 to {_MOST_SEED}"),
        default=1,
        help="which course of the profile (%(default)s)",
    )
    shape.add_argument(
        "--at", default="", metavar="ADDRESS", help="loopback address; without: a free 127.0.0.N"
    )
    shape.add_argument("--list", action="store_true", help="show the profiles, and end")
    shape.add_argument("--show", metavar="PROFILE", help="print a profile's file, and end")
    shape.add_argument("--log", type=Path, metavar="FILE", help="append states as JSON lines")
    shape.add_argument("--json", action="store_true", help="say what happens as JSON lines")
    shape.add_argument("--stop-with-stdin", action="store_true", help="end when stdin ends")


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        HubError: The profile has mistakes, no hub answers, or no address is free.
    """
    from hub.command_output import print_error, put
    from hub.shaper.profile import load_profile, profile_path

    if options.list:
        return _list_all(as_json=options.json)
    if options.show is not None:
        load_profile(options.show)
        put(profile_path(options.show).read_text().rstrip())
        return 0
    if not options.profile:
        print_error("say which --profile; `rune-hub shape --list` shows them")
        return ExitCode.USAGE
    return _relay(options, load_profile(options.profile))


def _list_all(*, as_json: bool) -> int:
    from hub.command_output import put_json
    from hub.inspection.output import table
    from hub.shaper.profile import load_profile, shipped_profiles

    profiles = [load_profile(name) for name in shipped_profiles()]
    if as_json:
        for each in profiles:
            put_json(_facts(each))
        return 0
    rows = [
        (
            each.name,
            each.purpose,
            f"{each.round_trip * 1e3:g} ({each.jitter * 1e3:.0f})",
            f"{each.down.loss * 100:g} ({each.down.burst:g})" if each.down.loss else "0",
            f"{each.down.rate / 1e3:g}",
        )
        for each in profiles
    ]
    table(("PROFILE", "PURPOSE", "RTT [ms]", "LOSS [%]", "[kbit/s]"), rows, words=2)
    return 0


def _facts(profile: LinkProfile) -> dict[str, object]:
    return {
        "name": profile.name,
        "purpose": profile.purpose,
        "round_trip_ms": round(profile.round_trip * 1e3, 3),
        "jitter_ms": round(profile.jitter * 1e3, 1),
        "loss": profile.down.loss,
        "burst": profile.down.burst,
        "rate_kbit": profile.down.rate / 1e3,
        "picture_rate_hz": profile.picture_rate,
        "sha256": profile.digest,
    }


def _relay(options: argparse.Namespace, profile: LinkProfile) -> int:
    from hub import hub_sockets
    from hub.command_output import stdin_ended
    from hub.inspection.message_commands import connect
    from hub.shaper.reporter import Reporter

    with contextlib.ExitStack() as stack:
        outputs: list[TextIO] = [sys.stdout] if options.json else []
        if options.log is not None:
            outputs.append(stack.enter_context(_opened_log(options.log)))
        address = hub_sockets.address_of(options.hub)
        client = connect(hub_sockets.tcp_of(address) or address, "shape", options.keys)
        try:
            relay = _listen(options, client, profile)
        except HubError:
            client.close()
            raise
        stack.enter_context(contextlib.closing(relay))
        reporter = Reporter(client, relay, profile, options.seed, outputs=outputs)
        stack.enter_context(contextlib.closing(reporter))
        _say_ready(options, relay, profile, outputs)
        reporter.start()
        relay.run(stdin_ended if options.stop_with_stdin else lambda: False)
    return 0


def _opened_log(path: Path) -> TextIO:
    """The file of the states.

    Raises:
        LinkShaperError: It cannot be written.
    """
    try:
        return path.open("a", encoding="utf-8")
    except OSError as error:
        message = f"{path} cannot be written: {error.strerror}; give --log another file"
        raise LinkShaperError(message) from error


def _listen(options: argparse.Namespace, client: Client, profile: LinkProfile) -> Relay:
    """The relay, at the address of the options, or at the first where all ports are free.

    Raises:
        EndpointError: There is none, or the hub has no TCP ports.
    """
    from hub.ipc.endpoints import TcpEndpoint, parse_endpoint
    from hub.shaper.relay import Relay

    hub = []
    for text in client.addresses:
        endpoint = parse_endpoint(text, beyond_loopback=True) if "tcp://" in text else None
        if not isinstance(endpoint, TcpEndpoint):
            message = f"the link shaper needs a hub at TCP, and not {text}: start it with --listen"
            raise EndpointError(message)
        hub.append((endpoint.host, endpoint.port))
    if options.at:
        parse_endpoint(f"tcp://{options.at}:0")  # of this machine only
        return Relay(options.at, hub, profile, options.seed)
    for number in range(_FIRST, _LAST):
        with contextlib.suppress(EndpointError):
            return Relay(f"127.0.0.{number}", hub, profile, options.seed)
    # The reason, such as a system without these addresses.
    return Relay(f"127.0.0.{_FIRST}", hub, profile, options.seed)


def _say_ready(
    options: argparse.Namespace, relay: Relay, profile: LinkProfile, outputs: list[TextIO]
) -> None:
    from hub.command_output import put

    endpoint = f"tcp://{relay.address}:{relay.ports[0]}"
    ready = {
        "event": "ready",
        "endpoint": endpoint,
        "hub": options.hub,
        "seed": options.seed,
        "started": relay.started,
        "at": time.time(),
        "pid": os.getpid(),
        **_facts(profile),
    }
    for output in outputs:
        output.write(json_text(ready) + "\n")
        output.flush()
    if not options.json:
        put(f"{profile.name}, seed {options.seed}: consoles connect with --hub {endpoint}")
        put("Ctrl-C ends it, which cuts the link.")
