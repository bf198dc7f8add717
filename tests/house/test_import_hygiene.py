"""What importing each half really loads, seen in a fresh interpreter."""

from __future__ import annotations

import subprocess
import sys

import pytest

CONSOLE_ONLY = {"textual", "rich", "lxml", "hid", "PIL", "rune_tui"}


@pytest.mark.parametrize(
    ("statement", "forbidden"),
    [
        (
            "import hub.cli, hub.robomon.daemon, hub.inspection.commands, hub.robots.magellan,"
            " hub.modules.driver.__main__, hub.modules.navigation.__main__,"
            " hub.modules.vision.__main__",
            CONSOLE_ONLY,
        ),
        ("import hub.gcm.catalog", CONSOLE_ONLY | {"zmq"}),
        (
            "import rune_tui.view, rune_tui.dispatch, rune_tui.layout.spec",
            {"textual", "rich", "hid", "zmq"},
        ),
        ("import rune_tui.shot", {"textual", "rich", "hid"}),
        ("import hub.cli, rune_tui.cli", CONSOLE_ONLY - {"rune_tui"} | {"zmq", "numpy"}),
    ],
)
def test_import_stays_light(statement: str, forbidden: set[str]) -> None:
    code = f"{statement}\nimport sys\nprint(*sorted({forbidden!r} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
