"""`python -m rune_tui` is `rune`."""

from __future__ import annotations

import sys

from rune_tui.cli import main

if __name__ == "__main__":
    sys.exit(main())
