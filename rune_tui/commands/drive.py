"""`rune drive`: finds a robot, starts its hub here, and opens the console on it.

| event | next |
| --- | --- |
| a vehicle is found | its robot file is written, and what was found is said |
| there is none, or its address is none | the end, with the reason |
| all of it is safe, or `--yes` | its hub starts, then the console |
| something is unsafe, or it is armed | the same after Enter |
| the console ends | its hub ends |
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any, Final

from hub.plain_text import plain
from rune_tui.commands.auto import with_file
from rune_tui.commands.demo import AUTO
from rune_tui.commands.own_hub import OwnHub
from rune_tui.errors import DriveAddressError

KINDS: Final = ("mavlink",)
"""The kinds of links to robots without a hub: the first word of an address."""


def run(options: argparse.Namespace, log: Path, show: Callable[[str, str], int]) -> int:
    """Drive what is at an address; returns the exit code.

    Args:
        options: Those of the command.
        log: File for the hub's log.
        show: Shows the console with the layout of a path, for the hub at an endpoint.

    Raises:
        DriveAddressError: The address has no kind of link.
        OwnHubError: The robot's hub did not start.
    """
    kind, _, address = options.address.partition(":")
    if kind not in KINDS or not address:
        text = f"{options.address!r} has no kind of link: write mavlink:udp://:14550, for instance"
        raise DriveAddressError(text)
    with tempfile.TemporaryDirectory(prefix="rune-drive-") as folder:
        path = options.output or Path(folder) / "robot.toml"
        code, found = _adopted(kind, address, path, options)
        if found is None:
            return code
        _say(f"{address}: a {found['title']}", *found["remarks"])
        if options.output is not None:
            _say(f"written: {path}")
        with closing(OwnHub(str(path), log, keeps=True)) as hub:
            if (found["unsafe"] or found["armed"]) and not options.yes:
                _wait_for_operator()
            with with_file([AUTO], hub.endpoint()) as (layout,):
                return show(layout, hub.endpoint())


def _adopted(
    kind: str, address: str, path: Path, options: argparse.Namespace
) -> tuple[int, dict[str, Any] | None]:
    """The exit code of `rune-hub adopt`, and what it found; it says itself what is wrong."""
    command = [sys.executable, "-m", "hub", "adopt", kind, address, "-o", str(path), "--json"]
    command += ["--system", str(options.system)]
    command += ["--key", str(options.key)] if options.key is not None else []
    _say(f"looking for a vehicle at {address}; this takes some seconds")
    done = subprocess.run(command, stdout=subprocess.PIPE, check=False)
    return done.returncode, json.loads(done.stdout) if done.returncode == 0 else None


def _wait_for_operator() -> None:
    sys.stderr.write("rune: Enter opens the console all the same, Ctrl-C ends: ")
    sys.stderr.flush()
    sys.stdin.readline()


def _say(*lines: str) -> None:
    sys.stderr.writelines(f"rune: {plain(line)}\n" for line in lines)
    sys.stderr.flush()
