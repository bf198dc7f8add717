"""The doctor on the hub of this machine: whether one of the robot's name runs, and its sockets."""

from __future__ import annotations

import contextlib
import getpass
import os
import socket
import tempfile
from pathlib import Path

from hub import hub_sockets, paths
from hub.errors import HubError, OtherVersionError
from hub.hub_sockets import NAMED
from hub.inspection import message_commands
from hub.inspection.doctor.finding import Finding, ok, problem, unknown, warning
from hub.inspection.kept import not_kept
from hub.ipc.client import Client
from hub.robots.description import RobotDescription

_ANSWER_S = 2.0
_LINGERING = Path("/var/lib/systemd/linger")
_LOGINS = Path("/run/user")


def hub(robot: RobotDescription) -> list[Finding]:
    """Whether a hub of this robot runs here, and who is connected."""
    try:
        there = modules_of_hub(robot.name)
    except OtherVersionError as error:
        text, _, remedy = str(error).partition("; ")
        return [problem(f"{robot.name} runs here: {text}", remedy)]
    except HubError as error:
        process = hub_sockets.process_at(NAMED + robot.name) or "not known"
        why = type(error).__name__
        text = f"{robot.name} runs here (process {process}), and does not answer ({why})"
        return [problem(text, "end its process, and start it again")]
    if there is None:
        return [ok(f"none of the name {robot.name} runs here")]
    return [ok(f"{robot.name} runs here, with {there}")]


def sockets(_robot: RobotDescription) -> list[Finding]:
    """Whether the folder for a hub's sockets can be made, and stays."""
    named = os.environ.get("XDG_RUNTIME_DIR", "")
    findings = []
    parent = paths.for_hubs()[0].parent
    if named and not os.environ.get("RUNE_RUNTIME_DIR") and named != str(parent):
        reason = "is too long" if len(named) > paths.LONGEST_FOR_SOCKETS else "is no folder"
        text = f"XDG_RUNTIME_DIR ({named}) {reason}; another folder is taken"
        advice = f"name a folder of up to {paths.LONGEST_FOR_SOCKETS} characters"
        findings.append(warning(text, advice))
    if _LOGINS in parent.parents and not (_LINGERING / getpass.getuser()).exists():
        text = f"{parent} is removed when this user logs out; a hub makes it again at a login"
        findings.append(warning(text, "loginctl enable-linger, or run the hub as a service"))
    try:
        with (
            tempfile.TemporaryDirectory(prefix="rune-doctor-", dir=parent) as folder,
            socket.socket(socket.AF_UNIX) as probe,
        ):
            probe.bind(f"{folder}/{hub_sockets.SOCKET}")
    except OSError as fault:
        text = f"no sockets can be made in {parent} ({fault.strerror})"
        return [*findings, problem(text, "set XDG_RUNTIME_DIR to a folder that you can write to")]
    return [*findings, ok(f"they can be made in {parent}")]


def modules_of_hub(name: str) -> str | None:
    """The clients of the hub of this name; None: it does not run here.

    Raises:
        HubError: It does not answer.
    """
    if not hub_sockets.process_at(NAMED + name):
        return None
    with contextlib.closing(_client_of(name)) as client:
        peers = client.directory.listing(_ANSWER_S).peers
        names = sorted(peer.name for peer in peers if peer.name != client.name)
        return ", ".join(names[:20]) or "nobody connected"


def kept(robot: RobotDescription) -> list[Finding]:
    """Whether the hub that runs keeps its recording and its mission."""
    if not hub_sockets.process_at(NAMED + robot.name):
        return [ok("no hub runs here that has a recording or a mission")]
    try:
        with contextlib.closing(_client_of(robot.name)) as client:
            lost = not_kept(client, client.directory.listing(_ANSWER_S).peers)
    except HubError as error:
        text = f"the hub that runs does not say what it keeps ({type(error).__name__})"
        return [unknown(text, "see the check `hub`")]
    advice = "look at the room on its disk and at the folders in the robot file"
    return [problem(each, advice) for each in lost] or [ok("the hub that runs reports no loss")]


def _client_of(name: str) -> Client:
    """A client of the hub of this name.

    Raises:
        HubError: No hub answers.
    """
    return message_commands.connect(f"{NAMED}{name}", "doctor", None)
