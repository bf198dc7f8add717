"""Processes of real ROS 2, each test with a domain of its own."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from tests.real_ros.jazzy import MISSING, PYTHON, JazzyProcess

Start = Callable[..., JazzyProcess]
_numbers = itertools.count(os.getpid())
_MOST_DOMAINS = 100


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start a script by its name."""
    if not PYTHON.exists():
        pytest.skip(MISSING)
    domain = 1 + next(_numbers) % _MOST_DOMAINS
    with ExitStack() as stack:

        def begin(script: str, *words: str) -> JazzyProcess:
            made = JazzyProcess(script, *words, folder=tmp_path, domain=domain)
            return stack.enter_context(closing(made))

        yield begin
