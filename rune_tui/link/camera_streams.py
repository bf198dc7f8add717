"""The pictures of all cameras of one robot: only of those that viewports show."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Set
from typing import TypeAlias

from hub.gcm import vision
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from rune_tui.link.picture_stream import PictureStream
from rune_tui.model.cameras import PictureNeed
from rune_tui.model.console_state import PictureWish
from rune_tui.model.robot_state import PictureFlow

Needs: TypeAlias = Mapping[str, PictureNeed]
"""The pictures that are needed of each camera."""


class CameraStreams:
    """Used by the link's thread; `want` and `shown` by any other.

    Cameras are named as in requests: the main one's name is empty.
    """

    def __init__(
        self,
        client: Client,
        take: Callable[[str, vision.Image, MessageInfo], int],
        keep: Callable[[Set[str]], None],
        fail: Callable[[str], None],
        clock: Callable[[], float],
    ) -> None:
        """Ask for nothing yet.

        Args:
            client: The client that asks.
            take: Gets each picture after its camera's name, and returns its number for `shown`.
            keep: Gets the shown cameras at each change: the pictures of others are out of date.
            fail: Gets in words why there is none; empty when all cameras answer.
            clock: Monotonic time [s].
        """
        self._client = client
        self._take = take
        self._keep = keep
        self._fail = fail
        self._clock = clock
        self._interval: float | None = None
        self._streams: dict[str, PictureStream] = {}
        self._faults: dict[str, str] = {}
        self._wanted: Needs = {}
        self._newest: tuple[Needs, PictureWish | None] | None = None

    @property
    def round_trip(self) -> float:
        """Delay of the newest picture [s]; NaN before the first."""
        delays = (self._streams[name].round_trip for name in sorted(self._wanted))
        return next((delay for delay in delays if not math.isnan(delay)), math.nan)

    def follow(self, interval: float | None) -> None:
        """Ask no camera more often than every `interval` [s]; None: not at all."""
        self._interval = interval
        for name, stream in self._streams.items():
            stream.follow(self.interval(name))

    def interval(self, camera: str) -> float | None:
        """Shortest time between two pictures of a camera [s]; None: it is not asked."""
        need = self._wanted.get(camera)
        if self._interval is None or need is None:
            return None
        return max(self._interval, need.interval_s)

    def want(self, needs: Needs, wish: PictureWish | None) -> None:
        """Ask for the pictures that these cameras need, of the operator's kind."""
        if (needs, wish) != self._newest:
            self._newest = needs, wish
            self._client.post(lambda: self._want(needs, wish))

    def _want(self, needs: Needs, wish: PictureWish | None) -> None:
        self._wanted = needs
        for name in needs.keys() - self._streams.keys():
            self._streams[name] = PictureStream(
                self._client,
                camera=name,
                take=functools.partial(self._taken, name),
                fail=functools.partial(self._note, name),
                clock=self._clock,
            )
        for name, stream in self._streams.items():
            need = needs.get(name)
            stream.follow(self.interval(name))
            stream.want(need.size if need is not None else None, wish)
        for name in self._faults.keys() - needs.keys():
            self._note(name, "")
        self._keep(needs.keys())

    def shown(self, number: int, camera: str) -> None:
        """The picture of this number, of this camera, is on the screen."""
        stream = self._streams.get(camera)
        if stream is not None:
            stream.shown(number)

    def step(self) -> None:
        """Ask the cameras whose time it is."""
        for stream in self._streams.values():
            stream.step()

    def flow(self, seconds: float) -> PictureFlow | None:
        """Statistics of the pictures of the first wanted camera since the last call."""
        flows = {name: stream.flow(seconds) for name, stream in self._streams.items()}
        return next((flows[name] for name in sorted(self._wanted) if flows[name]), None)

    def _taken(self, camera: str, image: vision.Image, reception: MessageInfo) -> int:
        if camera not in self._wanted:
            return 0  # asked before the choice of another camera
        return self._take(camera, image, reception)

    def _note(self, camera: str, why: str) -> None:
        if why:
            self._faults[camera] = why
        else:
            self._faults.pop(camera, None)
        self._fail(next(iter(self._faults.values()), ""))
