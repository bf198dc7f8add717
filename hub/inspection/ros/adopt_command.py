"""`rune-hub adopt ros`: writes the robot file of a robot with ROS."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import sys
import time
from pathlib import Path

from hub import files
from hub.inspection.output import print_error, put
from hub.plain_text import plain
from hub.robots.ros.address import ros_address
from hub.robots.ros.asking.proposal import RosProposal
from hub.robots.ros.asking.robot_text import robot_file
from hub.robots.ros.asking.survey import look_at
from hub.robots.ros.opening import line_to


def run(options: argparse.Namespace) -> int:
    """Carry out the command; returns the exit code.

    Raises:
        RosAddressError: The address is none.
        RosSilentError: Nothing answers there.
    """
    output: Path | None = options.output
    if output is not None and output.exists() and not options.force:
        print_error(f"{output} is there; give another name, or --force to replace it")
        return 1
    address = ros_address(options.address)
    with contextlib.closing(line_to(address)) as line:
        found = look_at(line, address, options.seconds, namespace=options.namespace)
    proposal = RosProposal(found)
    if refusal := proposal.refusal():
        print_error(f"{address.text}: {refusal}")
        return 1
    text = robot_file(proposal, name=options.name or "", today=time.strftime("%Y-%m-%d"))
    if output is not None:
        try:
            files.replace(output, text.encode())
        except OSError as fault:
            print_error(f"{output} cannot be written: {fault.strerror}")
            return 1
    _report(proposal, options, text)
    return 0


def _report(proposal: RosProposal, options: argparse.Namespace, text: str) -> None:
    """Say what was found."""
    if options.json:
        put(json.dumps(_facts(proposal, options, text)))
        return
    if options.output is None:
        put(text.rstrip())
    say = put if options.output is not None else _aside
    say(plain(f"{proposal.found.address.text}: a {proposal.title}"))
    for remark in proposal.remarks():
        say(remark)
    if options.output is not None:
        say(f"written: {options.output}; `rune-hub run {options.output}` starts its hub")


def _aside(line: str) -> None:
    sys.stderr.write(plain(line) + "\n")


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
