"""Keeps the newest picture of a topic, by a thread with a line of its own.

| state | event | action |
| --- | --- | --- |
| asleep | a picture is wanted | subscribe |
| awake | none is wanted for 5 s | unsubscribe, forget the picture |
| awake | a picture comes more than 1 s late | connect again: what waits is dropped |

Without the last rule a thin network would show ever older pictures: the robot's end keeps many.
"""

from __future__ import annotations

import contextlib
import logging
import math
import threading
import time
from typing import Final

from hub.errors import CameraError
from hub.plain_text import plain
from hub.robots.ros.line import RosLine, RosMessage, RosTopic
from hub.robots.ros.line_loop import LineLoop
from hub.values import dataclass

_logger = logging.getLogger(__name__)

_WANTED_S: Final = 5.0
_LATE_S: Final = 1.0
_AGAIN_S: Final = 2.0
"""Least time between two such connections [s]."""
STALE_S: Final = 2.0
"""Age from which on a picture is not shown any more [s]."""
_LOOK_S: Final = 0.1
"""Longest time between two looks at what is wanted [s]."""
_CLOSE_S: Final = 0.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FedMessage:
    """A message, kept beyond its arrival.

    Attributes:
        payload: Its bytes.
        topic: Its topic.
        measured: When it was taken [s, monotonic].
    """

    payload: bytes
    topic: RosTopic
    measured: float


class PictureFeed:
    """The newest picture of one topic, and the camera's newest data.

    Attributes:
        info: The newest message of the topic `info`; None: none came yet.
    """

    def __init__(self, line: RosLine, topic: str, info: str) -> None:
        """Start to connect.

        Args:
            line: The line; it belongs to this object from now on.
            topic: The topic of pictures.
            info: The topic of the camera's data; empty: none.
        """
        self.info: FedMessage | None = None
        self._line = line
        self._topics = [each for each in (topic, info) if each]
        self._newest: FedMessage | None = None
        self._wanted = -math.inf
        self._awake = False
        self._renewed = -math.inf
        self._why = "it is not connected yet"
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ros-pictures", daemon=True)
        self._thread.start()

    def newest(self, now: float) -> FedMessage:
        """The newest picture.

        Raises:
            CameraError: There is none, or it is too old; the text gives the reason.
        """
        self._wanted = now
        picture, topic = self._newest, self._topics[0]
        if picture is not None and now - picture.measured <= STALE_S:
            return picture
        if self._why:
            text = f"no picture comes from {topic}: {self._why}"
        elif picture is None:
            text = f"no picture has come from {topic} yet; ask again in a moment"
        else:
            age = now - picture.measured
            text = f"no picture has come from {topic} for {age:.0f} s; see what its node does"
        raise CameraError(text)

    def close(self) -> None:
        """End the thread and leave the line."""
        self._ended.set()
        self._thread.join(_CLOSE_S)

    def _run(self) -> None:
        with contextlib.closing(LineLoop(self._line)) as loop:
            while not self._ended.is_set():
                loop.advance()
                self._follow()
                loop.wait(_LOOK_S)

    def _follow(self) -> None:
        """Subscribe while a picture is wanted."""
        state = self._line.state
        away = f"the line is away: {plain(state.why)[:200]}" if state.why else "the line is away"
        self._why = "" if state.up else away
        awake = time.monotonic() - self._wanted <= _WANTED_S
        if awake is self._awake:
            return
        self._awake = awake
        for topic, take in zip(self._topics, (self._take, self._inform), strict=False):
            if awake:
                self._line.subscribe(topic, take)
            else:
                self._line.unsubscribe(topic)
        if not awake:
            self._newest = None

    def _take(self, message: RosMessage) -> None:
        late, now = message.arrived - message.measured, message.arrived
        self._newest = _kept(message)
        if late > _LATE_S and now - self._renewed >= _AGAIN_S:
            self._renewed = now
            why = f"pictures of {message.topic.name} came {late:.1f} s late"
            _logger.warning("%s: connects again", why)
            self._line.reconnect(why)

    def _inform(self, message: RosMessage) -> None:
        self.info = _kept(message)


def _kept(message: RosMessage) -> FedMessage:
    payload = bytes(message.payload)
    return FedMessage(payload=payload, topic=message.topic, measured=message.measured)
