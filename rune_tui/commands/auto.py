"""`rune layout auto`: a layout from what a robot's hub describes."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from hub.errors import QueryError
from hub.gcm.body import ROBOT_DESCRIPTION, RobotBody
from hub.gcm.supervision import CAPABILITY_REPORTS
from hub.ipc.client import Client
from hub.ipc.security.client_keys import read_client_keys
from rune_tui.commands.demo import AUTO
from rune_tui.startup.auto_layout import layout_text

_ANSWER_S = 5.0
_LOOK_S = 0.1
"""Time between two looks whether all modules have said what they can do [s]."""


def auto_layout(
    hub: str, keys: Path | None = None, *, robot: str = "robot", fleet: str = ""
) -> str:
    """The text of a layout for the robot at a hub.

    Args:
        hub: Its endpoint.
        keys: The file of the operator's key, for a hub on another machine.
        robot: Name of the robot in the layout.
        fleet: The fleet in which it has that name; empty: the layout names the hub.

    Raises:
        HubError: No hub answers there, or it does not describe its robot.
    """
    client = Client(
        f"rune-{os.getpid()}-layout", hub, keys=read_client_keys(keys) if keys else None
    )
    try:
        client.wait_connected(_ANSWER_S)
        return layout_text(*_described(client), hub, robot=robot, fleet=fleet)
    finally:
        client.close()


@contextlib.contextmanager
def with_file(names: Sequence[str], hub: str, keys: Path | None = None) -> Iterator[list[str]]:
    """The names of layouts, with a file that is made in place of the name `AUTO`.

    The file is there until the end of the context.
    """
    if AUTO not in names or Path(AUTO).exists():
        yield [*names]
        return
    with tempfile.TemporaryDirectory(prefix="rune-auto-") as folder:
        path = Path(folder) / f"{AUTO}.xml"
        path.write_text(auto_layout(hub, keys), "utf-8")
        yield [str(path) if name == AUTO else name for name in names]


def _described(client: Client) -> tuple[RobotBody, set[str]]:
    """The body, and the capabilities once all modules have said theirs, or the time is over.

    A hub that starts listens before it describes its robot.
    """
    end = time.monotonic() + _ANSWER_S
    while True:
        try:
            body = client.last_value(ROBOT_DESCRIPTION, timeout=_ANSWER_S)
            reports = client.last_value(CAPABILITY_REPORTS, timeout=_ANSWER_S)
        except QueryError:
            if time.monotonic() >= end:
                raise
        else:
            if not reports.undeclared or time.monotonic() >= end:
                return body, {report.name for report in reports.capabilities}
        client.listen(_LOOK_S)
