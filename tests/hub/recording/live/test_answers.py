"""Which failed answers change the coding in which a recording asks for pictures."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from hub.errors import HandlerFailedError, QueryError
from hub.gcm.vision import NOT_CODED, ImageCoding
from hub.recording.live.answers import PictureQuestions
from hub.recording.live.settings import PictureSettings


class Asked:
    """The client of a recorder: the test fails each question as it likes.

    Attributes:
        codings: The coding of each question.
    """

    connected = True

    def __init__(self) -> None:
        self.codings: list[ImageCoding] = []
        self._ask: Callable[[], None] = lambda: None
        self._failed: Callable[[QueryError], None] = lambda _: None

    def define(self, *_: object) -> None: ...

    def alarm(self, ask: Callable[[], None]) -> SimpleNamespace:
        self._ask = ask
        return SimpleNamespace(due=0.0, cancel=lambda: None)

    def query_notify(self, _request: object, value: Any, _answer: object, **more: Any) -> None:
        self.codings.append(value.coding)
        self._failed = more["failed"]

    def fail(self, why: str) -> None:
        """Ask, and fail."""
        self._ask()
        self._failed(HandlerFailedError(why))


@pytest.mark.parametrize(
    ("why", "second"),
    [
        ("no picture has come yet", ImageCoding.WEBP),
        (f"{NOT_CODED} as WEBP here: Pillow is missing", ImageCoding.RLE),
    ],
)
def test_only_a_robot_that_cannot_code_pictures_is_asked_for_others(
    why: str, second: ImageCoding
) -> None:
    client = Asked()
    settings = PictureSettings(format=ImageCoding.WEBP)
    PictureQuestions(client, [""], settings, lambda *_: None)  # type: ignore[arg-type]
    client.fail(why)
    client.fail(why)
    assert client.codings == [ImageCoding.WEBP, second]
