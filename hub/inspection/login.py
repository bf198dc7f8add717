"""Who is logged in where a command runs."""

from __future__ import annotations

import getpass


def login_name() -> str:
    """The name of the login; empty if the system does not say."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return ""
