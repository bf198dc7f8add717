"""A simulated robot with ROS as a process, and what a test does to it from outside."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from websockets import Subprotocol
from websockets.sync.client import ClientConnection, connect

from tests.support.running_command import RunningCommand

_SUBPROTOCOL: Final = Subprotocol("foxglove.sdk.v1")


@contextmanager
def client_of(address: str) -> Iterator[ClientConnection]:
    """A connection to a bridge, which is none of Rune's."""
    with connect(address, subprotocols=[_SUBPROTOCOL], max_size=None, max_queue=None) as client:
        yield client


class SimulatedRos:
    """`rune-hub sim-ros`, from start to end.

    Attributes:
        process: The process.
        trace: The file with its commands and motions.
        port: Its TCP port on loopback.
        encoding: Of its messages, "cdr" or "ros1".
    """

    def __init__(self, folder: Path, *options: str, port: int = 0) -> None:
        self.trace = folder / "trace.jsonl"
        self.encoding = "ros1" if "--ros1" in options else "cdr"
        self._options = options
        self._start(port)

    def _start(self, port: int) -> None:
        place = ("--trace", str(self.trace), "--port", str(port))
        self._command = RunningCommand("sim-ros", *place, *self._options)
        self.process = self._command.process
        self.port = int(self._command.ready["address"].rpartition(":")[2])

    @property
    def address(self) -> str:
        return f"ws://127.0.0.1:{self.port}"

    def lines(self) -> list[dict[str, Any]]:
        """All that it has written so far."""
        whole, _, _ = self.trace.read_text().rpartition("\n")
        return [json.loads(line) for line in whole.splitlines()]

    def commands(self) -> list[dict[str, Any]]:
        """The commands that reached it."""
        return [line for line in self.lines() if "twist" in line]

    def set_parameter(self, name: str, value: float) -> None:
        """Set one as another client of its bridge."""
        with client_of(self.address) as client:
            order = {"op": "setParameters", "id": "set"}
            client.send(json.dumps({**order, "parameters": [{"name": name, "value": value}]}))
            while not _is_answer(client.recv(timeout=5.0)):
                pass

    def kill(self) -> None:
        self._command.kill()

    def start_again(self) -> None:
        """Kill it, and start another one at the same port."""
        self.kill()
        self._start(self.port)

    def close(self) -> None:
        self._command.close()


def _is_answer(message: str | bytes) -> bool:
    return isinstance(message, str) and json.loads(message).get("id") == "set"
