"""A robot's state for pictures, and drawings kept as text to compare with."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.robot_state import LinkPhase, LinkState, Picture, Received, RobotState
from rune_tui.raster.canvas import Canvas
from rune_tui.visualizers.registry import VISUALIZERS
from rune_tui.visualizers.visualizer import Visualizer
from tests.console.states import robot_of, visualizer_spec
from tests.support.messages import camera_state, robot_state

NOW = 100.0
GOLDEN = Path(__file__).parents[2] / "golden" / "cells"
LETTERS = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
LETTERS += "".join(map(chr, range(0x100, 0x17F)))

Draw = Callable[..., Canvas]


def picture() -> Picture:
    """Eight by six pixels: red, green, blue and white quarters."""
    pixels = np.zeros((6, 8, 3), np.uint8)
    pixels[:3, :4, 0] = 200
    pixels[:3, 4:, 1] = 200
    pixels[3:, :4, 2] = 200
    pixels[3:, 4:] = 200
    return Picture(pixels=pixels, camera=camera_state())


def received(value: Any, age: float = 0.1, number: int = 1) -> Received[Any]:
    return Received(value=value, measured=NOW - age, number=number)


class Made:
    """Makes states; ages are in seconds before `NOW`."""

    now = NOW
    navigation = staticmethod(robot_state)
    camera = staticmethod(camera_state)
    picture = staticmethod(picture)
    received = staticmethod(received)

    @staticmethod
    def link(phase: LinkPhase = LinkPhase.CONNECTED, **changes: Any) -> LinkState:
        values: dict[str, Any] = {"since": NOW - 3.4, "endpoint": "tcp://10.0.0.5:1381"}
        return LinkState(phase=phase, **values | changes)

    def robot(self, **parts: Any) -> RobotState:
        """A linked robot of which everything is known, but for the parts given."""
        values: dict[str, Any] = {
            "link": self.link(),
            "picture": received(picture()),
            "navigation": received(robot_state()),
            "camera": received(camera_state()),
        }
        return robot_of(name="magellan", **values | parts)


def made_by(function: str, **options: Any) -> Visualizer:
    """The visualizer of this name with these options."""
    return VISUALIZERS[function].from_spec(visualizer_spec(function, **options))


@pytest.fixture
def made() -> Made:
    return Made()


@pytest.fixture
def draw() -> Draw:
    """Draws a robot's state by a visualizer's name on a canvas of the size in pixels."""

    def drawn(
        function: str,
        robot: RobotState,
        size: tuple[int, int],
        *,
        held: tuple[str, ...] = (),
        state: ConsoleState | None = None,
        **options: Any,
    ) -> Canvas:
        canvas = Canvas.blank(*size)
        state = state or ConsoleState(now=NOW, held=held)
        made_by(function, **options).draw(canvas, robot, state)
        return canvas

    return drawn


def words(canvas: Canvas) -> list[str]:
    """The characters of each row of cells, blanks for none."""
    return ["".join(chr(p or 32) for p in row).rstrip() for row in canvas.glyphs.tolist()]


@pytest.fixture
def golden() -> Callable[[str, Canvas], None]:
    """Compares a drawing with the one in the file; RUNE_WRITE_SNAPSHOTS=1 writes it anew."""

    def compare(name: str, canvas: Canvas) -> None:
        path = GOLDEN / f"{name}.txt"
        text = described(canvas)
        if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
            path.write_text(text, "utf-8")
        assert text == path.read_text("utf-8")

    return compare


def described(canvas: Canvas) -> str:
    """A drawing as text: its characters, then a letter a pixel, then what the letters mean."""
    meaning: dict[str, str] = {"00000000": "."}

    def letter(colour: list[int]) -> str:
        return meaning.setdefault(bytes(colour).hex(), LETTERS[len(meaning) - 1])

    pixels = ["".join(map(letter, row)) for row in canvas.pixels.tolist()]
    ink = [
        "".join(letter(c) if g else "." for c, g in zip(colours, glyphs, strict=True))
        for colours, glyphs in zip(canvas.ink.tolist(), canvas.glyphs.tolist(), strict=True)
    ]
    colours = [f"{sign} {colour}" for colour, sign in meaning.items()]
    characters = [f"|{row:<{canvas.width}}|" for row in words(canvas)]
    parts = (("characters", characters), ("ink", ink), ("pixels", pixels), ("rrggbbaa", colours))
    return "".join("\n".join([f"[{title}]", *lines, ""]) for title, lines in parts)
