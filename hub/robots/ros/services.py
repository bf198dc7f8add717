"""The services of a robot with ROS that the driver calls: its stop, its lights."""

from __future__ import annotations

from typing import Final

from hub.plain_text import plain
from hub.robots.ros.commands import CDR, refusal, stop_request, switch_request
from hub.robots.ros.line import Payload, RosLine

TIMEOUT_S: Final = 1.0
"""Longest time for an answer [s]."""


class RosServices:
    """The calls of one body.

    Attributes:
        failed: Why the last call of a service failed, by its name.
    """

    def __init__(self, line: RosLine) -> None:
        self.failed: dict[str, str] = {}
        self._line = line

    def stop(self, name: str) -> None:
        """Call a service that stops the robot; without a name do nothing."""
        if not name:
            return
        type_name = self._type(name)
        if not type_name:
            return
        request = stop_request(type_name, self._encoding)
        if request is None:
            self.failed[name] = f"its type, {plain(type_name)[:80]}, is not known"
            return
        self._call(name, type_name, request)

    def switch(self, name: str, *, on: bool) -> None:
        """Call a std_srvs/SetBool."""
        type_name = self._type(name)
        if type_name:
            self._call(name, type_name, switch_request(self._encoding, on=on))

    def _type(self, name: str) -> str:
        """The type of a service; empty: it cannot be called, and why is noted."""
        state, found = self._line.state, self._line.graph.services.get(name)
        if state.up and found is not None:
            return found.type
        self.failed[name] = "the robot has none of this name" if state.up else "the line is away"
        return ""

    def _call(self, name: str, type_name: str, request: bytes) -> None:
        encoding = self._encoding

        def answered(payload: Payload | None, why: str) -> None:
            said = self._line.state.refusals.get(name, "")  # older bridges say it so
            words = said or why if payload is None else refusal(type_name, payload, encoding)
            if payload is not None and not words:
                self.failed.pop(name, None)
            else:
                self.failed[name] = plain(words or "it gives no answer")[:200]

        self._line.call(name, request, answered, TIMEOUT_S)

    @property
    def _encoding(self) -> str:
        """The encoding of the robot's services: that of its topics."""
        topics = self._line.graph.topics.values()
        return next((each.encoding for each in topics if each.encoding), CDR)
