"""The options of `rune-hub fleet`."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from hub.command_line import CommandParser, Commands, login_name, number_type
from hub.command_output import print_error, put
from hub.errors import HubError
from hub.ipc.endpoints import DEFAULT_ENDPOINT, endpoint_of
from hub.ipc.roles import Principal, Role
from hub.zenoh.fleet_keys import DEFAULT_FLEET, HOLDERS, MAX_NAME, check_fleet, parse_operator
from hub.zenoh.settings import (
    DEFAULT_PLACE,
    CertificateFiles,
    RouterPlace,
    client_settings,
    parse_place,
)

T = TypeVar("T")

_STRANGE = re.compile(r"[^A-Za-z0-9._-]", re.ASCII)
_days = number_type(int, 1, 36500, "number of days from 1 to 36500")


def add_fleet(commands: Commands) -> None:
    """Add the command."""
    fleet = commands.add_parser(
        "fleet",
        help="robots and operators that meet at a router of Zenoh",
        description="Join hubs and consoles of several machines at a router. Exit codes: 0 ok, 2 "
        "wrong usage, 3 no router or no hub.",
    )
    tasks = fleet.add_subparsers(dest="task", required=True, metavar="TASK")
    named = CommandParser(add_help=False)
    named.add_argument(
        "--fleet", type=_fleet, default=DEFAULT_FLEET, help="name of the fleet (%(default)s)"
    )
    router = tasks.add_parser("router", parents=[named], help="be the router, until Ctrl-C")
    router.add_argument(
        "--listen", type=_place, action="append", metavar="PLACE",
        help=f"tcp/HOST:PORT on this machine, or tls/HOST:PORT ({DEFAULT_PLACE})",
    )  # fmt: skip
    router.add_argument(
        "--connect", type=_place, action="append", default=[], metavar="PLACE",
        help="another router of the fleet to join with; may be given again",
    )  # fmt: skip
    router.add_argument("--tls", type=Path, metavar="FOLDER", help="folder of the certificates")
    look = CommandParser(add_help=False, parents=[named])
    add_connection(look, Role.OBSERVE)
    look.add_argument("--json", action="store_true", help="JSON, one line a robot")
    tasks.add_parser("list", parents=[look], help="the robots that are there")
    tasks.add_parser("status", parents=[look], help="who drives each robot, and how far it is away")
    gateway = tasks.add_parser(
        "gateway", help="join a robot with its fleet by hand; [fleet] in its file does it by itself"
    )
    gateway.add_argument("robot", help="its robot file, with a table [fleet]")
    gateway.add_argument(
        "--hub", type=endpoint_of, default=DEFAULT_ENDPOINT, help="of the robot (%(default)s)"
    )
    _add_mirror(tasks, named)
    _add_keys(tasks.add_parser("keys", help="certificates of robots, operators and the router"))


def add_connection(parser: CommandParser, role: Role) -> None:
    """Add the options of a program that joins a fleet as an operator, usually of this role."""
    parser.add_argument(
        "--connect", type=_place, default=parse_place(DEFAULT_PLACE), metavar="PLACE",
        help="where the router listens (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--as", dest="operator", type=_operator, metavar="ROLE:NAME",
        help="who you are, as in your certificate (the only one in the folder, or "
        f"{role.value}: and your login)",
    )  # fmt: skip
    parser.add_argument("--tls", type=Path, metavar="FOLDER", help="folder of your certificate")


def operator_of(options: argparse.Namespace, role: Role) -> Principal:
    """The operator of these options.

    Without one it is the operator of the only certificate, or else the login with this role. Of a
    login only the letters are kept that a key of a fleet can have.
    """
    named: Principal | None = options.operator
    if named is None and options.tls is not None:
        holder = CertificateFiles.only_operator(options.tls)
        named = parse_operator(holder) if holder else None
    login = _STRANGE.sub("_", login_name()).lstrip(".")[:MAX_NAME]
    return named or Principal(name=login or "operator", role=role)


def run_fleet(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        HubError: It cannot be done.
    """
    if options.task == "router":
        from hub.doors.fleet.router import run_router

        places = options.listen or [parse_place(DEFAULT_PLACE)]
        return run_router(places, options.tls, options.fleet, others=options.connect)
    if options.task == "gateway":
        from hub.doors.fleet.__main__ import main
        from hub.robots.robot_file import find_robot_file

        return main(["--robot", str(find_robot_file(options.robot)), "--hub", options.hub])
    if options.task == "mirror":
        from hub.doors.fleet.certificates import files_of
        from hub.doors.mirror.command import run_mirror

        who = operator_of(options, Role.OPERATE)
        files = None if options.tls is None else files_of(options.tls, str(who))
        return run_mirror(options, who, files)
    if options.task == "keys":
        return _run_keys(options)
    return _look(options)


def _look(options: argparse.Namespace) -> int:
    from hub.doors.fleet import fleet_status
    from hub.doors.fleet.certificates import files_of
    from hub.zenoh.fleet_session import open_fleet_session

    who = operator_of(options, Role.OBSERVE)
    files = None if options.tls is None else files_of(options.tls, str(who))
    place: RouterPlace = options.connect
    session = open_fleet_session(place, client_settings(place, certificates=files))
    try:
        if options.task == "list":
            return fleet_status.list_robots(session, options.fleet, place, as_json=options.json)
        return fleet_status.show_status(session, options.fleet, place, who, as_json=options.json)
    finally:
        session.close()


def _run_keys(options: argparse.Namespace) -> int:
    from hub.doors.fleet.certificates import Certificates

    certificates = Certificates(options.folder or _default_folder())
    if options.action == "make":
        files = certificates.make(options.name, options.role, days=options.days)
        put(f"{files.certificate}\n{files.key}\n{files.authority}")
        if options.role == "router" and files != certificates.of_router():
            print_error(
                f"copy them and list.toml into a folder on {options.name}, this certificate as "
                "router.pem and its key as router.key"
            )
        else:
            print_error(_use_of(options.role, options.name, certificates.folder))
    elif options.action == "remove":
        certificates.remove(options.name)
    else:
        from hub.doors.fleet.certificate_list import list_certificates

        list_certificates(certificates, as_json=options.json)
    return 0


def _use_of(role: str, name: str, folder: Path) -> str:
    """Where the files of a certificate go, and what takes them there."""
    if role == "router":
        return f"they stay here: rune-hub fleet router --listen tls/0.0.0.0:7447 --tls {folder}"
    if role == "robot":
        return f"copy them into a folder of {name}; `certificates` of [fleet] in its file names it"
    return (
        f"copy them into a folder where {name} works; there: "
        f"rune run auto --fleet tls/HOST:7447 --as {role}:{name} --keys FOLDER"
    )


def _add_mirror(tasks: Commands, named: CommandParser) -> None:
    mirror = tasks.add_parser(
        "mirror",
        parents=[named],
        help="show robots of a fleet as hubs of this machine; consoles do it by themselves",
        description="For each robot of a fleet that is there, open a hub on this machine that "
        "stands for it: what its clients subscribe to, ask and send goes through the fleet. It "
        "says where, and which robots go.",
    )
    add_connection(mirror, Role.OPERATE)
    mirror.add_argument(
        "--robot", action="append", default=[], metavar="NAME", help="only these robots"
    )
    mirror.add_argument("--folder", type=Path, help="private folder of the hubs (a new one)")
    mirror.add_argument("--json", action="store_true", help="say what happens as JSON lines")
    mirror.add_argument("--stop-with-stdin", action="store_true", help="end when stdin ends")


def _default_folder() -> Path:
    from hub.ipc.security.keyring import default_folder

    return default_folder().parent / "fleet"


def _add_keys(keys: CommandParser) -> None:
    where = CommandParser(add_help=False)
    where.add_argument("--folder", type=Path, help="of the certificates (~/.config/rune/fleet)")
    actions = keys.add_subparsers(dest="action", required=True, metavar="ACTION")
    make = actions.add_parser("make", parents=[where], help="make one, and say where its files are")
    make.add_argument("name", help="of the robot or operator; of a router, its host or address")
    make.add_argument(
        "--role", choices=HOLDERS, required=True, metavar="|".join(HOLDERS),
        help="observe: see all, and stop robots; operate: command as well; supervise: also take "
        "control from others",
    )  # fmt: skip
    make.add_argument(
        "--days", type=_days, default=730, help="how long it counts, in days (%(default)s)"
    )
    listing = actions.add_parser("list", parents=[where], help="show all with their last days")
    listing.add_argument("--json", action="store_true", help="JSON, one line each")
    remove = actions.add_parser("remove", parents=[where], help="let one count no more")
    remove.add_argument("name", help="such as operate:alice")


def _checked(read: Callable[[str], T], text: str) -> T:
    try:
        return read(text)
    except HubError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def _place(text: str) -> RouterPlace:
    return _checked(parse_place, text)


def _fleet(text: str) -> str:
    if text.startswith(("tcp/", "tls/")):
        message = f"{text!r} is a place; --fleet names a fleet, and --connect {text} its router"
        raise argparse.ArgumentTypeError(message)
    return _checked(check_fleet, text)


def _operator(text: str) -> Principal:
    return _checked(parse_operator, text)
