"""Files of joysticks in the user's configuration directory."""

from __future__ import annotations

from pathlib import Path

import platformdirs


def user_file(name: str) -> Path:
    """Where such a file is."""
    return platformdirs.user_config_path("rune", appauthor=False) / name
