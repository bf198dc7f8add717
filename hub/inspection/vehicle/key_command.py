"""`rune-hub vehicle key`: makes a signing key, and gives it to a vehicle when asked."""

from __future__ import annotations

import argparse
import contextlib
import getpass
import secrets
import sys
from pathlib import Path
from typing import Final

from hub.command_line import ExitCode
from hub.command_output import print_error, put
from hub.errors import KeyFileError
from hub.inspection.vehicle.vehicle_link import (
    claimed,
    find_at,
    hub_with_autopilot,
    open_session,
    place_of,
)
from hub.robots.mavlink.asking.findings import VehicleFinder
from hub.robots.mavlink.asking.signing_setup import SigningSetup
from hub.robots.mavlink.wire.signing import SigningClock
from hub.robots.mavlink.wire.signing_key import key_of_phrase, read_signing_key, write_signing_key

_LENGTH: Final = 32
_LONGEST_PHRASE: Final = 1000
_PROOF_S: Final = 3.0
"""How long to wait for a first signed frame [s]."""


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        HubError: The key's file, the robot file or the address cannot be used, or there is no
            vehicle.
    """
    path: Path = options.file
    if options.setup is None or not path.exists():
        phrase = _phrase() if options.phrase else None
        if phrase == "":
            print_error("the phrase is empty; no key was made")
            return ExitCode.USAGE
        key = secrets.token_bytes(_LENGTH) if phrase is None else key_of_phrase(phrase)
        write_signing_key(path, key)
        put(f"{path} has a new key; name it in the robot file: [mavlink] key_file")
        if options.setup is not None:
            put("now the vehicle gets it")
    elif options.phrase:
        raise KeyFileError(path, "it is there; give --phrase with a new file")
    return _set_up(options, read_signing_key(path)) if options.setup is not None else ExitCode.OK


def _phrase() -> str:
    """A phrase from the terminal, or a line of standard input."""
    if sys.stdin.isatty():
        return getpass.getpass("phrase: ")[:_LONGEST_PHRASE]
    return sys.stdin.readline(_LONGEST_PHRASE).rstrip("\r\n")


def _set_up(options: argparse.Namespace, key: bytes) -> int:
    options.vehicle = options.setup
    place = place_of(options)
    if hub := hub_with_autopilot(place):
        print_error(f"its hub runs at {hub}: end it first; the vehicle has no new key")
        return ExitCode.FAULT
    old = str(options.key or "")
    stamp = SigningClock(Path(f"{options.file}.stamp")).next()
    with contextlib.closing(open_session(place.address, old, place.station)) as session:
        finder = find_at(session, place, options.seconds)
        setup = SigningSetup(_system(finder), key, stamp)
        with claimed(session, _system(finder)) as rival:
            if rival:
                print_error(f"{rival} has this vehicle: end it first; the vehicle has no new key")
                return ExitCode.FAULT
            if not (armed := finder.vehicle is not None and finder.vehicle.armed):
                session.ask(setup, _PROOF_S)
    if armed or setup.armed:
        print_error(
            "it is armed: disarm it first; it does not have the key, so give this command again"
        )
        return ExitCode.FAULT
    signed = open_session(place.address, str(options.file), place.station)
    with contextlib.closing(signed) as session:
        session.ask(proof := VehicleFinder(_system(finder), reads=False), _PROOF_S)
    if not proof.components:
        print_error(
            "the key was sent, and no frame with its signature came: the vehicle did not take it, "
            "or this is a link where it does not sign, such as USB"
        )
        return ExitCode.FAULT
    put("the vehicle signs its frames with this key now")
    return ExitCode.OK


def _system(finder: VehicleFinder) -> int:
    return finder.vehicle.system if finder.vehicle is not None else 0
