"""`rune-hub vehicle forward`: another ground station sees what a hub's vehicle sends."""

from __future__ import annotations

import argparse
import contextlib
import socket
import time
from typing import Any, Final

import numpy as np

from hub.command_line import ExitCode
from hub.command_output import print_error, put, put_json, stdin_ended
from hub.errors import VehicleAddressError
from hub.gcm.autopilot import MAVLINK_FRAMES, MAVLINK_REQUEST, MavlinkFrames, MavlinkRequest
from hub.inspection.message_commands import connect
from hub.inspection.vehicle.vehicle_link import place_of
from hub.robots.mavlink.forwarding import FrameForwarder
from hub.robots.mavlink.link.address import VehicleLinkKind, vehicle_address

_LOOK_S: Final = 0.05
_REPORT_S: Final = 10.0
"""Time between two reports on a terminal [s]."""
_BACK: Final = {
    False: "what comes back is dropped",
    True: "its commands reach the vehicle while no other has control of the robot: they can arm it "
    "and change its mode, and Rune's limits and stops do not hold for what it then does by itself",
}
_LONGEST: Final = 65536
_AT_ONCE: Final = 20
"""Most datagrams of the station at once."""


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        HubError: The robot file or the address cannot be used, or no hub answers.
    """
    place = place_of(options)
    if not place.hub and not options.hub:
        print_error("name a robot file whose hub runs: the hub has the link, and passes frames on")
        return ExitCode.USAGE
    target = vehicle_address(options.to)
    if target.kind is not VehicleLinkKind.UDP:
        raise VehicleAddressError(options.to, "frames are passed on to udp://HOST:PORT")
    with contextlib.ExitStack() as stack:
        family, address = _found(options.to, target.host, target.port)
        link = stack.enter_context(socket.socket(family, socket.SOCK_DGRAM))
        link.settimeout(0.0)
        client = connect(options.hub or place.hub, "forward", None)
        stack.callback(client.close)
        forwarder = FrameForwarder()

        if options.commands:
            client.demand_right(MAVLINK_REQUEST)
            client.define(MAVLINK_REQUEST)

        def take(frames: MavlinkFrames, _how: object) -> None:
            for datagram in () if frames.sent else forwarder.datagrams(frames.data.tobytes()):
                with contextlib.suppress(OSError):  # the station is not there yet, or late
                    link.sendto(datagram, address)

        client.subscribe(MAVLINK_FRAMES, take)
        _say(options, "forwards", forwarder)
        report = time.monotonic() + _REPORT_S
        while not (options.stop_with_stdin and stdin_ended()):
            client.listen(_LOOK_S)
            wanted = _came_back(link, forwarder)
            if options.commands and wanted:
                data = np.frombuffer(wanted, np.uint8)
                client.publish(MAVLINK_REQUEST, MavlinkRequest(data=data))
            if time.monotonic() >= report:
                report += _REPORT_S
                _say(options, "forwarded", forwarder)
        _say(options, "ended", forwarder)
    return ExitCode.OK


def _found(text: str, host: str, port: int) -> tuple[int, Any]:
    """Family and address of the station.

    Raises:
        VehicleAddressError: Its name is not known.
    """
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except OSError as fault:
        reason = f"the name {host!r} is not known: {fault.strerror or fault}"
        raise VehicleAddressError(text, reason) from fault
    return family, address


def _came_back(link: socket.socket, forwarder: FrameForwarder) -> bytes:
    """Take what the station sent; returns what may be passed on."""
    wanted = b""
    for _ in range(_AT_ONCE):
        try:
            wanted += forwarder.came_back(link.recv(_LONGEST))
        except OSError:
            break
    return wanted


def _say(options: argparse.Namespace, event: str, forwarder: FrameForwarder) -> None:
    if options.json:
        facts = {"event": event, "passed": forwarder.passed, "dropped": forwarder.returned}
        put_json({**facts, "to": options.to})
    elif event == "forwards":
        put(f"frames of the vehicle go to {options.to}; {_BACK[options.commands]}; Ctrl-C ends it")
    else:
        put(f"{forwarder.passed} frames went there, {forwarder.returned} came back")
