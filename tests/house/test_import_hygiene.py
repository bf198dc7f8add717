"""What importing each half really loads, seen in a fresh interpreter."""

from __future__ import annotations

import subprocess
import sys

import pytest

CONSOLE_ONLY = {"textual", "rich", "lxml", "hid", "hidraw", "PIL", "rune_study", "rune_tui"}
ON_DEMAND = {"av"}


Step = tuple[str, set[str]]
"""Modules to import, and those that must not be loaded then."""


@pytest.mark.parametrize(
    "steps",
    [
        [
            ("hub.gcm.catalog", CONSOLE_ONLY | {"zmq"}),
            (
                "hub.cli, hub.robomon.daemon, hub.inspection.message_commands,"
                " hub.robots.simulated_camera, hub.modules.driver.__main__,"
                " hub.modules.navigation.__main__, hub.modules.vision.__main__,"
                " hub.modules.mapping.__main__, hub.robots.video_camera,"
                " hub.modules.autonomy.__main__",
                CONSOLE_ONLY | ON_DEMAND,
            ),
        ],
        [
            (
                "hub.cli, rune_tui.cli",
                CONSOLE_ONLY - {"rune_tui"} | {"zmq", "numpy", "importlib.metadata"},
            ),
            (
                "rune_tui.view, rune_tui.dispatch, rune_tui.layout.spec",
                {"textual", "rich", "hid", "hidraw", "zmq"},
            ),
            ("rune_tui.commands.shot", {"textual", "rich", "hid", "hidraw"}),
        ],
    ],
    ids=["hub", "console"],
)
def test_import_stays_light(steps: list[Step]) -> None:
    code = "import sys\n" + "".join(
        f"import {names}\nprint(*sorted({forbidden!r} & set(sys.modules)), sep=',')\n"
        for names, forbidden in steps
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = dict(zip((names for names, _ in steps), done.stdout.splitlines(), strict=True))
    assert loaded == dict.fromkeys(loaded, "")


_AS_ON_WINDOWS = """
import importlib.abc, os, pathlib, sys

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name in {"fcntl", "resource", "termios", "tty", "pty", "pwd", "grp"}:
            raise ModuleNotFoundError(name)

# What the standard library itself needs here stays; what we import is looked for anew.
import asyncio, subprocess
for name in ("fcntl", "resource", "termios", "tty", "pty", "pwd", "grp"):
    sys.modules.pop(name, None)
del os.memfd_create
sys.meta_path.insert(0, Missing())
"""


def test_the_console_needs_nothing_that_only_unix_has() -> None:
    names = "hub.ipc.client, rune_tui.cli, rune_tui.app, rune_tui.link.robot_link"
    code = f"{_AS_ON_WINDOWS}\nimport {names}\nprint('imported')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout == "imported\n", done.stderr[-2000:]
