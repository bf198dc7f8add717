"""Asks a robot for pictures and maps, which are no broadcasts, at a slow rate."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from typing import Any

from hub.errors import HandlerFailedError, NoHandlerError, QueryError
from hub.gcm.mapping import MAP, MAP_REQUEST, MapRequest
from hub.gcm.vision import IMAGE, IMAGE_REQUEST, NOT_CODED, ImageCoding, ImageRequest
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.recording.live.settings import PictureSettings

_logger = logging.getLogger(__name__)

Keep = Callable[[MessageDefinition[Any], Any, MessageInfo], None]
"""Gets an answer."""

_ANSWER_S = 2.0
_REST_S = 1.0
"""Time until the next question after one without an answer [s]."""


class RepeatedQuestion:
    """Asks one question again and again; never two at a time."""

    def __init__(
        self,
        client: Client,
        request: MessageDefinition[Any],
        response: MessageDefinition[Any],
        ask: Callable[[], Any],
        period: float,
        keep: Keep,
        refused: Callable[[], None] = lambda: None,
    ) -> None:
        """Begin.

        Args:
            client: Asks.
            request: The question's message.
            response: The answer's.
            ask: Makes the question.
            period: Time between two questions [s].
            keep: Gets the answers.
            refused: Called when the robot cannot code pictures as asked.
        """
        self._refused = refused
        self._client, self._request, self._response = client, request, response
        self._make, self._period, self._keep = ask, period, keep
        self._due = 0.0
        self._ended = False
        client.define(request, response)
        self._timer = client.alarm(self._ask)
        self._timer.due = time.monotonic()
        self._fault = ""

    def end(self) -> None:
        """Ask no more; an answer under way is dropped."""
        self._ended = True
        self._timer.cancel()

    def _ask(self) -> None:
        self._due = time.monotonic() + self._period
        if not self._client.connected:
            self._wait(_REST_S)
            return
        self._client.query_notify(
            self._request,
            self._make(),
            self._response,
            timeout=_ANSWER_S,
            answered=self._answered,
            failed=self._failed,
        )

    def _answered(self, value: Any, info: MessageInfo) -> None:  # noqa: ANN401 - any message
        if self._ended:
            return
        self._fault = ""
        self._wait(0.0)
        self._keep(self._response, value, info)

    def _failed(self, error: QueryError) -> None:
        if self._ended:
            return
        if not isinstance(error, NoHandlerError) and not self._fault:
            self._fault = str(error)
            _logger.info("no answer to %s: %s", self._request.name, error)
        if isinstance(error, HandlerFailedError) and NOT_CODED in str(error):
            self._refused()
        self._due = 0.0
        self._wait(_REST_S)

    def _wait(self, least: float) -> None:
        now = time.monotonic()
        self._timer.due = max(self._due, now + least)


class PictureQuestions:
    """Asks each camera for its pictures."""

    def __init__(
        self, client: Client, cameras: Sequence[str], settings: PictureSettings, keep: Keep
    ) -> None:
        """Begin.

        Args:
            client: Asks.
            cameras: Names of the cameras; "" is the main one.
            settings: Rate, size and coding.
            keep: Gets the pictures.
        """
        if settings.rate > 0.0:
            for camera in cameras:
                self._begin(client, camera, settings, keep)

    def _begin(self, client: Client, camera: str, settings: PictureSettings, keep: Keep) -> None:
        width, height = settings.size
        codings = [settings.format, ImageCoding.RLE]

        def ask() -> ImageRequest:
            return ImageRequest(camera=camera, width_px=width, height_px=height, coding=codings[0])

        # A robot without Pillow codes no WebP: then its pictures come in GCM's own coding.
        RepeatedQuestion(
            client, IMAGE_REQUEST, IMAGE, ask, 1.0 / settings.rate, keep, codings.reverse
        )


def ask_for_maps(client: Client, period: float, keep: Keep) -> None:
    """Ask for the whole map each `period` [s]; 0: never."""
    if period > 0.0:
        RepeatedQuestion(client, MAP_REQUEST, MAP, MapRequest, period, keep)
