"""What who sends a gamepad is told of the consoles there are."""

from __future__ import annotations

import numpy as np

from hub.gcm.pad import PadConsole
from rune_tui.controls.remote_pad.pad_audience import FORGOTTEN_S, MOST_CONSOLES, Audience
from tests.support.cases import for_each

ME, OTHER = 7, 8


def console(operator: str, *taken: int) -> PadConsole:
    return PadConsole(operator=operator, taken=np.array(taken, np.uint32))


@for_each(
    ("operator", "there", "words"),
    [
        ("", [], "waits for a console"),
        ("alice", [], "waits for a console of alice"),
        ("alice", [console("bob", ME)], "waits for a console of alice (there: bob)"),
        (
            "alice",
            [console("carol"), console("bob"), console("bob")],
            "waits for a console of alice (there: bob, carol)",
        ),
        ("alice", [console("alice", ME), console("bob")], "used by the console of alice"),
        (
            "",
            [console("bob", ME), console("alice", OTHER, ME)],
            "used by the console of alice, bob",
        ),
        (
            "",
            [console("alice", OTHER)],
            "not used by the console of alice, which has no free joystick for it",
        ),
        ("", [console("\x1b[2Jal\nice", ME)], "used by the console of [2Jalice"),
    ],
)
def test_it_is_said_who_uses_it_and_for_whom_it_waits(
    operator: str, there: list[PadConsole], words: str
) -> None:
    audience = Audience(operator)
    for number, told in enumerate(there):
        audience.hear(number, told, 0.0)
    assert audience.words(ME, 0.0) == words


def test_a_console_that_is_not_heard_any_more_is_not_there() -> None:
    audience = Audience()
    audience.hear(1, console("alice", ME), 0.0)
    assert audience.words(ME, FORGOTTEN_S) == "used by the console of alice"
    assert audience.words(ME, FORGOTTEN_S + 0.001) == "waits for a console"


def test_no_more_consoles_are_kept_than_can_be_shown_and_those_that_are_stay() -> None:
    audience = Audience("nobody")
    for number in range(2 * MOST_CONSOLES):
        audience.hear(number, console(f"{number:02}"), 0.0)
    audience.hear(0, console("first"), 0.0)
    words = audience.words(ME, 0.0)
    assert words.count(",") == MOST_CONSOLES - 1
    assert "first" in words
