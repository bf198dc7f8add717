"""Reads the capabilities of stopped modules: runs their command with --describe."""

from __future__ import annotations

import json
import logging
import os
from collections import deque
from collections.abc import Iterable, Sequence

from hub.errors import ModuleStartError
from hub.robomon.module_lifecycle import ModuleLifecycle
from hub.robomon.process import ModuleProcess
from hub.robomon.wants import MAX_NAME
from hub.robomon.warm_parent import WarmParent

_logger = logging.getLogger(__name__)

TIMEOUT_S = 10.0
MAX_BYTES = 16_384
MAX_NAMES = 64
MAX_SHOWN_BYTES = 200


class CapabilityProbe:
    """Asks one module after the other; call `poll` repeatedly, it never waits."""

    def __init__(self, arguments: Sequence[str], parent: WarmParent | None) -> None:
        """Ask no module yet.

        Args:
            arguments: Added to a module's command.
            parent: Forks the processes.
        """
        self._parent = parent
        self._arguments = (*arguments, "--describe")
        self._waiting: deque[ModuleLifecycle] = deque()
        self._asked: set[str] = set()
        self._process: ModuleProcess | None = None
        self._life: ModuleLifecycle | None = None
        self._output = b""
        self._until = 0.0

    @property
    def pid(self) -> int:
        """The present process; 0: none."""
        return self._process.pid if self._process else 0

    def ask(self, lifecycles: Iterable[ModuleLifecycle]) -> None:
        """Ask each of these once."""
        for lifecycle in lifecycles:
            if lifecycle.spec.name not in self._asked:
                self._asked.add(lifecycle.spec.name)
                self._waiting.append(lifecycle)

    def poll(self, now: float) -> None:
        """Read the present module's answer, or ask the next; `now` is the time [s]."""
        if self._process is not None:
            self._listen(self._process, now)
        elif self._waiting:
            self._life = self._waiting.popleft()
            try:
                self._process = ModuleProcess(self._life.spec, self._arguments, self._parent)
            except ModuleStartError as error:
                _logger.warning("module %s %s", self._life.spec.name, error)
                return
            os.set_blocking(self._process.output, False)
            self._output, self._until = b"", now + TIMEOUT_S

    def close(self) -> None:
        """Ask no more modules."""
        self._waiting.clear()
        if self._process is not None:
            self._process.end()
            os.close(self._process.output)
            self._process = None

    def _listen(self, process: ModuleProcess, now: float) -> None:
        code = process.exit_code()
        try:
            while len(self._output) <= MAX_BYTES and (chunk := os.read(process.output, MAX_BYTES)):
                self._output += chunk
        except BlockingIOError:
            pass
        if code is None and now < self._until and len(self._output) <= MAX_BYTES:
            return
        process.end()
        os.close(process.output)
        self._process = None
        if self._life is not None and not self._life.asked:
            self._conclude(self._life, code)

    def _conclude(self, lifecycle: ModuleLifecycle, code: int | None) -> None:
        abilities = parse(self._output) if code == 0 else None
        if abilities is None:
            _logger.warning(
                "module %s does not say what it can do when it is run with --describe%s; "
                "what the robot file says is taken for it",
                lifecycle.spec.name,
                _last_words(self._output),
            )
        else:
            lifecycle.learned(*abilities)


def _last_words(output: bytes) -> str:
    """The part of a warning with a module's last line; empty: it wrote none."""
    line = output.strip().rpartition(b"\n")[2][:MAX_SHOWN_BYTES].decode(errors="replace")
    return f", but {line!r}" if line else ""


def parse(output: bytes) -> tuple[frozenset[str], frozenset[str]] | None:
    """A module's capabilities and needs, from its last line; None: that is no answer."""
    try:
        answer = json.loads(output.strip().rpartition(b"\n")[2])
        provides, needs = answer["provides"], answer["needs"]
        usable = all(
            isinstance(names, list)
            and len(names) <= MAX_NAMES
            and all(
                isinstance(name, str) and name.isidentifier() and len(name) <= MAX_NAME
                for name in names
            )
            for names in (provides, needs)
        )
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    return (frozenset(provides), frozenset(needs)) if usable else None
