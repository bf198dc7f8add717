"""`rune-hub adopt ros`: writes the robot file of a robot with ROS."""

from __future__ import annotations

import argparse
import contextlib
import math
import time
from pathlib import Path

from hub.command_output import print_error, put_json
from hub.errors import RosAddressError
from hub.inspection.robot_file_output import RobotFileOutput
from hub.plain_text import plain
from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.proposal import RosProposal
from hub.robots.ros.asking.robot_text import robot_file
from hub.robots.ros.asking.survey import look_at
from hub.robots.ros.line_loop import LineLoop
from hub.robots.ros.opening import line_to
from hub.zenoh.router_tls import tls_settings


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        RosAddressError: An address is none, or takes no certificates.
        KeyFileError: Something is wrong with the certificates.
        RosSilentError: Nothing answers there.
    """
    output = RobotFileOutput(options.output, replace=options.force)
    if not output.is_free():
        return 1
    address = ros_address(options.address)
    if options.tls is not None and not address.takes_certificates:
        text = f"--tls is for a Zenoh router, such as zenoh+tls://HOST:7447, not {address.text!r}"
        raise RosAddressError(text)
    certificates = str(options.tls.resolve()) if options.tls is not None else ""
    if certificates:
        tls_settings(Path(certificates))  # what is wrong with them is said at once
    way = ros_address(options.through) if options.through else address
    with contextlib.closing(LineLoop(line_to(way, certificates))) as loop:
        found = look_at(loop, address, options.seconds, namespace=options.namespace)
    proposal = RosProposal(found)
    if refusal := proposal.refusal():
        print_error(f"{address.text}: {refusal}")
        return 1
    today = time.strftime("%Y-%m-%d")
    text = robot_file(proposal, name=options.name or "", today=today, certificates=certificates)
    if not output.write(text):
        return 1
    if options.json:
        put_json(_facts(proposal, options, text))
    else:
        title = plain(f"{address.text}: a {proposal.title}")
        output.report(text, title, *proposal.remarks())
    return 0


def _facts(proposal: RosProposal, options: argparse.Namespace, text: str) -> dict[str, object]:
    parts, stop = proposal.parts, proposal.stopping.seconds
    return {
        "path": str(options.output) if options.output is not None else None,
        "name": options.name or proposal.name,
        "address": proposal.found.address.text,
        "title": proposal.title,
        "armed": False,
        "text": text,
        "topics": sorted(parts.taken),
        "cmd_vel": parts.command.name if parts.command is not None else "",
        "stops_after_s": stop if 0.0 < stop < math.inf else None,
        "hold": proposal.hold,
        "unsafe": [{"name": each.name, "why": each.why} for each in proposal.dangers()],
        "remarks": [*proposal.remarks()],
    }
