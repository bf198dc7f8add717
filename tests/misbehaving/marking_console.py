"""A console that marks without end, and says what the robot has confirmed; it is killed meanwhile.

    python -m tests.misbehaving.marking_console HUB FIRST

Each line of its output is JSON: what the robot said is on its disk, as number, x and note.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import sys

import numpy as np

from hub.gcm import mapping
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo

MOST = 60
"""Points; when there are so many, their notes are changed."""
AGAIN_S = 0.5


class MarkingConsole:
    """Sends one command at a time, again until it is confirmed."""

    def __init__(self, hub: str, first: int) -> None:
        self._client = Client("marking-console", hub)
        self._counter = itertools.count(first)
        self._points: dict[int, mapping.InterestPoint] = {}
        self._command: mapping.PointCommand | None = None
        self._client.subscribe(mapping.INTEREST_POINTS, self._heard, last=True)
        self._client.every(AGAIN_S, self._send)

    def run(self) -> None:
        while True:
            self._client.listen(1.0)

    def _heard(self, message: mapping.InterestPoints, reception: MessageInfo) -> None:
        del reception
        self._points = {point.number: point for point in message.points}
        for point in message.points:
            if point.kept:
                sys.stdout.write(json.dumps([point.number, point.x, point.note]) + "\n")
        sys.stdout.flush()
        wanted = self._command.point if self._command else None
        confirmed = wanted is None or any(
            point.kept and point.note == wanted.note for point in message.points
        )
        if confirmed:
            self._command = self._next()
            self._send()

    def _next(self) -> mapping.PointCommand:
        count = next(self._counter)
        note = f"{count:06}"
        if len(self._points) < MOST:
            point = mapping.InterestPoint(
                kind=mapping.PointKind.VICTIM, x=float(count), y=1.0, by="Ada", note=note,
                thumbnail=np.full(200, count % 256, np.uint8),
            )  # fmt: skip
        else:
            numbers = sorted(self._points)
            point = dataclasses.replace(self._points[numbers[count % MOST]], note=note)
        return mapping.PointCommand(point=point)

    def _send(self) -> None:
        if self._command is not None:
            self._client.publish(mapping.POINT_COMMAND, self._command)


if __name__ == "__main__":
    MarkingConsole(sys.argv[1], int(sys.argv[2])).run()
