"""One robot's pictures: asked for as the link carries them, taken, and counted."""

from __future__ import annotations

from collections.abc import Callable

from hub.errors import CodecError, HandlerFailedError, HubError, QueryTimeoutError
from hub.gcm import vision
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from rune_tui.link.picture_choice import PictureChoice
from rune_tui.link.requests import Requester
from rune_tui.model.console_state import PictureWish
from rune_tui.model.robot_state import PictureFlow


class PictureStream:
    """Used by the link's thread; `want` and `shown` by any other."""

    def __init__(
        self,
        client: Client,
        *,
        camera: str = "",
        take: Callable[[vision.Image, MessageInfo], int],
        fail: Callable[[str], None],
        clock: Callable[[], float],
    ) -> None:
        """Ask for nothing yet.

        Args:
            client: The client that asks.
            camera: Name of the camera; empty: the main one.
            take: Gets each picture, and returns its number for `shown`.
            fail: Gets in words why there is none; empty when there is one.
            clock: Monotonic time [s].
        """
        self._client = client
        self._clock = clock
        self._take = take
        self._choice = PictureChoice(camera)
        self._size: tuple[int, int] | None = None
        self._wish = PictureWish()
        self._wanted = False
        self._count = 0
        self._newest: vision.Image | None = None
        self._quality = 0
        self._requests = Requester(
            client,
            vision.IMAGE_REQUEST,
            vision.IMAGE,
            ask=self._ask,
            take=self._taken,
            fail=fail,
            clock=clock,
            busy=self._answered,
            refused=self._refused,
        )

    @property
    def round_trip(self) -> float:
        """Delay of the newest picture [s]; NaN before the first."""
        return self._requests.round_trip

    def follow(self, interval: float | None) -> None:
        """Ask no more often than every `interval` [s]; None: not at all."""
        self._wanted = interval is not None
        self._choice.interval = interval or 0.0
        self._requests.follow(self._choice.interval)

    def want(self, size: tuple[int, int] | None, wish: PictureWish | None) -> None:
        """Ask for pictures of this width and height [pixels], None for none, and of this kind."""
        self._size = size
        self._wish = wish or PictureWish()

    def shown(self, number: int) -> None:
        """The picture of this number is on the screen."""
        self._requests.shown = number

    def step(self) -> None:
        """Ask for one if it is time to."""
        self._requests.step()

    def flow(self, seconds: float) -> PictureFlow | None:
        """Statistics of the pictures since the last call."""
        count, self._count = self._count, 0
        newest = self._newest
        if newest is None or not self._wanted or self._size is None:
            return None
        return PictureFlow(
            coding=newest.coding,
            quality=self._quality,
            width_px=newest.width_px,
            height_px=newest.height_px,
            shrunk=self._choice.shrunk and self._measured,
            per_s=count / seconds,
        )

    @property
    def _measured(self) -> bool:
        """Whether the requests depend on the link's capacity."""
        return self._wish.coding is None and not self._client.near

    def _ask(self) -> vision.ImageRequest | None:
        size = self._size
        if size is None or not self._wanted:
            return None
        return self._choice.request(size, self._wish, near=self._client.near)

    def _taken(self, image: vision.Image, reception: MessageInfo) -> int:
        number = self._take(image, reception)
        self._newest = image
        self._count += 1
        return number

    def _answered(self, request: vision.ImageRequest, service: float) -> None:
        self._quality = request.quality
        if self._measured and self._choice.answered(request, service, self._clock()):
            self._requests.pace.forget()

    def _refused(self, request: vision.ImageRequest, error: HubError) -> None:
        if not self._measured:
            return
        if isinstance(error, QueryTimeoutError):
            self._choice.timed_out(self._clock())
        elif isinstance(error, HandlerFailedError | CodecError):
            self._choice.refused(request)
