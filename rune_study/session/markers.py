"""Markers for other instruments: Lab Streaming Layer, of the extra `lsl`."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from rune_study.errors import StudyError

STREAM = "RuneMarkers"
_CONFIGURATION = "LSLAPICFG"
_THIS_MACHINE = "[multicast]\nResolveScope = machine\n[ports]\nIPv6 = disable\n[log]\nlevel = -3\n"
"""Without a configuration of the laboratory, markers stay on this machine."""


def lsl_markers(source: str) -> Callable[[str], None]:
    """A function that sends a marker, stamped with the monotonic clock.

    Args:
        source: Identifies the session to the instruments that record it.

    Raises:
        StudyError: The library is not installed, or cannot be loaded.
    """
    if _CONFIGURATION not in os.environ:
        folder = Path(tempfile.mkdtemp(prefix="rune-lsl-"))
        (folder / "lsl.cfg").write_text(_THIS_MACHINE)
        os.environ[_CONFIGURATION] = str(folder / "lsl.cfg")
    try:
        import pylsl
    except (ImportError, RuntimeError, OSError) as fault:
        text = (
            "[markers] lsl = true needs Lab Streaming Layer; install it with "
            "pip install 'robot-user-nexus[lsl]'"
        )
        raise StudyError(text) from fault
    outlet = pylsl.StreamOutlet(pylsl.StreamInfo(STREAM, "Markers", 1, 0.0, "string", source))

    def send(text: str) -> None:
        outlet.push_sample([text], time.monotonic())  # local_clock() is the same clock

    return send


def no_markers(text: str) -> None:
    """Send nothing."""
    del text
