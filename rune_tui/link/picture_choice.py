"""The choice of pictures on a link of limited capacity; pure.

Measured, not assumed: how long robot and link are busy with one picture decides. Where that is too
long for 15 pictures a second, the quality drops first, then the rate to 5 a second. The size
drops last, to a useful least size.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final

from hub.gcm.vision import ImageCoding, ImageRequest
from hub.values import dataclass
from rune_tui.model.console_state import PictureWish

LEAST_WIDTH_PX: Final = 64
"""Least width of pictures that are reduced for a slow link."""
_USE: Final = 0.8
"""How much of its time a link may be busy with pictures."""
_FULL_RATE_S, _FAIR_RATE_S, _LEAST_RATE_S = _USE / 15.0, 0.125, 0.2
"""Time per picture at 15 pictures a second with room for other messages, at 8, and at 5. People
explore at walking speed with at least 5 [s]."""
_PROBE: Final = 3.0
"""A better step is tried if its estimated time is at most this multiple of the limit: a part of the
robot's work, which does not grow with the bytes."""
_NO_HELP: Final = 1.15
"""A lower step is no gain if the higher one takes at most this multiple of its time."""
_SETTLED, _SURE = 3, 5
"""Answers before a step is left: downwards, upwards."""
_FAR_TOO_MUCH: Final = 4.0
"""A step that takes this multiple of the limit is left at once."""
_DWELL_S: Final = 1.0
_BAR_S, _LONGEST_BAR_S = 5.0, 120.0
"""Time until a failed step is tried again [s]; it doubles each time."""
_NEW: Final = 0.3
"""Weight of each new measurement in the mean."""


@dataclass(frozen=True, slots=True)
class Step:
    """One step of quality, rate and size.

    Attributes:
        size: Bytes, compared with the other steps.
        service: How long robot and link may be busy with one picture [s].
        quality: Of the file.
        scale: Width and height, relative to the shown picture.
        exact: Whether run lengths of the wished quality are sent, not a file.
    """

    size: float
    service: float
    quality: int
    scale: float = 1.0
    exact: bool = False


# Bytes of a 160x96 picture of the yellow arena as WebP, with the noise of a small camera; as JPEG
# they are twice as many, in the same proportions. Quality 5 is the least that shows a door.
STEPS: Final = (
    Step(0.4, math.inf, 5, scale=0.5),
    Step(0.6, _LEAST_RATE_S, 5, scale=0.7),
    Step(1.0, _LEAST_RATE_S, 5),
    Step(1.5, _FAIR_RATE_S, 20),
    Step(2.0, _FULL_RATE_S, 40),
    Step(2.8, _FULL_RATE_S, 60),
    Step(4.0, _FULL_RATE_S, 80),
    Step(8.0, _FULL_RATE_S, 95),
    Step(50.0, _FULL_RATE_S, 100, exact=True),
)
START: Final = 4
"""First step, small enough for a link of 64 kbit/s."""


class PictureChoice:
    """Goes up and down the steps by measurements.

    Attributes:
        interval: Shortest time between two pictures [s].
    """

    def __init__(self, camera: str = "") -> None:
        """Begin.

        Args:
            camera: Name of the camera; empty: the main one.
        """
        self.interval = 0.0
        self._camera = camera
        self._files = [ImageCoding.WEBP, ImageCoding.JPEG]
        self._mean: dict[int, float] = {}
        self._bars: dict[int, tuple[float, float]] = {}
        self._asked = ImageRequest()
        self._enter(START, -math.inf)

    @property
    def shrunk(self) -> bool:
        """Whether pictures are smaller than their viewport."""
        return STEPS[self._at].scale < 1.0

    def request(
        self, size: tuple[int, int], wish: PictureWish, *, near: bool = False
    ) -> ImageRequest:
        """The request for the next picture.

        Args:
            size: Width and height that are shown [pixels].
            wish: The operator's request; a coding in it is used on any link.
            near: Whether there is no link between, which could be too thin.
        """
        width, height = wish.width or size[0], wish.height or size[1]
        asked = ImageRequest(
            kind=wish.kind,
            width_px=width,
            height_px=height,
            quality=wish.quality,
            coding=ImageCoding.RLE if wish.coding is None else wish.coding,
            camera=self._camera,
        )
        step = STEPS[self._at]
        if wish.coding is None and not step.exact and not near:
            scale = max(step.scale, min(1.0, LEAST_WIDTH_PX / width))
            asked = dataclasses.replace(
                asked,
                width_px=max(1, round(width * scale)),
                height_px=max(1, round(height * scale)),
                quality=step.quality,
                coding=self._files[0] if self._files else ImageCoding.RLE,
            )
        self._asked = asked
        return asked

    def answered(self, request: ImageRequest, service: float, now: float) -> bool:
        """Learn how long an answer to `request` kept robot and link busy.

        Args:
            request: The request.
            service: How long it took of their time [s].
            now: Monotonic time [s].

        Returns:
            Whether something else is asked for from now on.
        """
        if request != self._asked:
            return False  # asked before the last change
        self._count += 1
        mean = self._mean.setdefault(self._at, service)
        mean = self._mean[self._at] = mean + _NEW * (service - mean)
        if mean > self._limit(self._at):
            much = mean > _FAR_TOO_MUCH * self._limit(self._at)
            if self._at and (much or self._count >= _SETTLED):
                self._go_down(mean, now)
                return True
        elif self._may_rise(mean, now):
            self._enter(self._at + 1, now)
            return True
        return False

    def timed_out(self, now: float) -> None:
        """Note a missing answer: the request may be far too large."""
        self._mean.clear()
        self._enter(max(0, min(self._at, START) - 1), now)

    def refused(self, request: ImageRequest) -> None:
        """The robot cannot code `request`, or we cannot decode the answer."""
        if request.coding in self._files:
            self._files.remove(request.coding)
        elif not self._files and request.coding is ImageCoding.RLE:
            # That can be coded everywhere, so it was not for the coding.
            self._files = [ImageCoding.WEBP, ImageCoding.JPEG]

    def _service(self, at: int) -> float:
        """How long robot and link may be busy with one picture of a step [s]."""
        return max(STEPS[at].service, min(_USE * self.interval, _LEAST_RATE_S))

    def _limit(self, at: int) -> float:
        """The same, or longer if lower steps save almost nothing."""
        lower = min((mean for step, mean in self._mean.items() if step < at), default=0.0)
        return max(self._service(at), _NO_HELP * lower)

    def _go_down(self, mean: float, now: float) -> None:
        _, length = self._bars.get(self._at, (0.0, _BAR_S / 2.0))
        length = min(_LONGEST_BAR_S, 2.0 * length)
        self._bars[self._at] = now + length, length
        fitting = (
            at
            for at in range(self._at - 1, -1, -1)
            if mean * STEPS[at].size / STEPS[self._at].size <= self._service(at)
        )
        self._enter(next(fitting, 0), now)

    def _may_rise(self, mean: float, now: float) -> bool:
        above = self._at + 1
        if above == len(STEPS) or self._count < _SURE or now < self._entered + _DWELL_S:
            return False
        if now < self._bars.get(above, (-math.inf, 0.0))[0]:
            return False
        # As if all of the time went into bytes.
        longest = mean * STEPS[above].size / STEPS[self._at].size
        return longest <= _PROBE * self._service(above)

    def _enter(self, at: int, now: float) -> None:
        self._at, self._entered, self._count = at, now, 0
        self._mean.pop(at, None)
