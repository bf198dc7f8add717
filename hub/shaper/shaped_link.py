"""A link shaper as a process, for programs: studies, benchmarks and tests."""

from __future__ import annotations

import json
import selectors
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from hub.errors import LinkShaperError

_START_S = 20.0
_STOP_S = 3.0


class ShapedLink:
    """A bad link to a hub, from its making to `close`; use it with `with`.

    It also ends with this process, however that ends.

    Attributes:
        endpoint: Where consoles connect.
        ready: What the shaper said of itself: profile, sha256, seed, started, pid and more.
        state: Its newest state, as `rune-hub shape --json` prints it; empty: none yet.
        pid: Of the process.
    """

    def __init__(
        self,
        hub: str,
        profile: str,
        seed: int,
        *,
        at: str = "",
        keys: Path | None = None,
        log: Path | None = None,
    ) -> None:
        """Start it, and wait until it listens.

        Args:
            hub: The hub's endpoint.
            profile: Name of a shipped profile, or its file.
            seed: Which course of the profile.
            at: Loopback address where consoles connect; empty: a free one.
            keys: Key file, for the gateway of a hub.
            log: Gets all states as JSON lines; None: no file.

        Raises:
            LinkShaperError: It does not start; the text has its own reason.
        """
        command = [sys.executable, "-m", "hub", "shape", "--json", "--stop-with-stdin"]
        command += ["--hub", hub, "--profile", profile, "--seed", str(seed)]
        for option, value in (("--at", at), ("--keys", keys), ("--log", log)):
            command += [option, str(value)] if value else []
        self.state: dict[str, Any] = {}
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                process_group=0,
            )
        except OSError as error:
            text = f"the link shaper cannot be started: {error}"
            raise LinkShaperError(text) from error
        self.pid = self._process.pid
        self._output, self._errors = _pipe(self._process.stdout), _pipe(self._process.stderr)
        try:
            self.ready = self._wait()
        except BaseException:
            self.close()
            raise
        self.endpoint = str(self.ready["endpoint"])
        self._readers = [
            threading.Thread(target=self._follow, daemon=True),
            threading.Thread(target=self._errors.read, daemon=True),
        ]
        for each in self._readers:
            each.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def ended(self) -> bool:
        """Whether the process has ended, so that the link is cut."""
        return self._process.poll() is not None

    def close(self) -> None:
        """Cut the link."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        try:
            self._process.wait(_STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for each in getattr(self, "_readers", ()):
            each.join()
        self._output.close()
        self._errors.close()

    def _wait(self) -> dict[str, Any]:
        """What the shaper says when it listens.

        Raises:
            LinkShaperError: It ended, or takes too long.
        """
        end = time.monotonic() + _START_S
        with selectors.DefaultSelector() as selector:
            selector.register(self._output, selectors.EVENT_READ)
            if selector.select(max(0.0, end - time.monotonic())):
                line = self._output.readline()
                if line:
                    ready: dict[str, Any] = json.loads(line)
                    return ready
                why = self._errors.read(10_000).decode(errors="replace").strip()
                text = f"the link shaper did not start: {why.removeprefix('rune-hub: ')}"
                raise LinkShaperError(text)
        text = f"the link shaper did not start within {_START_S:.0f} s"
        raise LinkShaperError(text)

    def _follow(self) -> None:
        """Keep the newest state, until the process ends."""
        for line in self._output:
            self.state = json.loads(line)


def _pipe(made: IO[bytes] | None) -> IO[bytes]:
    if made is None:
        text = "the link shaper has no output"
        raise LinkShaperError(text)
    return made
