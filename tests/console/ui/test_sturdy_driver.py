"""What the console hears of a terminal's mouse."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from textual import events
from textual.app import App
from textual.message import Message

from rune_tui.controls.typing_speed import TypingSpeed
from rune_tui.terminal.input_stream import InputStream, KeyMove
from rune_tui.ui.driver_reports import KeyMoved, KeysDropped
from rune_tui.ui.sturdy_driver import SturdyDriver, SturdyParser, understood
from tests.support.cases import for_each

MOVES = ("press", "repeat", "release")


class Waiting(App[None]):
    """A console with so many messages to go through."""

    waiting = 0

    @property
    def message_queue_size(self) -> int:
        return self.waiting

    def acts_at_once(self, key: events.Key) -> bool:
        return key.key in {"w", "d", "a", "space"}


class Told(SturdyDriver):
    """Notes what it tells the console."""

    def __init__(self, app: App[Any]) -> None:
        super().__init__(app)
        self.told: list[Message] = []
        self._down = {}
        self._speed = TypingSpeed()

    def send_message(self, message: Message) -> None:
        self.told.append(message)


def heard(*pieces: tuple[str, int]) -> list[str]:
    """What the console is told of pieces of input, each read while so many messages wait."""

    async def play() -> list[Message]:
        app = Waiting()
        driver, parser, stream = Told(app), SturdyParser(), InputStream(understood)
        for text, app.waiting in pieces:
            driver.take(parser, stream, text)
        return driver.told

    return [
        f"{type(event).__name__} {event.x:g},{event.y:g}"
        if isinstance(event, events.MouseEvent)
        else _moved(event)
        if isinstance(event, KeyMoved)
        else f"dropped {event.text}".rstrip()
        if isinstance(event, KeysDropped)
        else type(event).__name__
        for event in asyncio.run(play())
    ]


def _moved(event: KeyMoved) -> str:
    return f"{event.key} {event.move.name.lower()}"


TELLS = "\x1b[?27u"


@for_each(
    ("text", "moves"),
    [
        ("\x1b[119;1:1;119u\x1b[119;1:2;119u\x1b[119;1:3u", ["w press", "w repeat", "w release"]),
        ("\x1b[A\x1b[1;1:2A\x1b[1;1:3A", ["up press", "up repeat", "up release"]),
        ("\x1b[57441;2:1u\x1b[57441;1:3u", ["left_shift press", "left_shift release"]),
        ("\x1b[15~\x1b[15;1:3~", ["f5 press", "f5 release"]),
        ("\x1b[57417;1:1u\x1b[57417;1:3u", ["left press", "left release"]),  # of the keypad
        ("\x1b[99;5u\x1b[99;5:3u", ["ctrl+c press", "ctrl+c release"]),
    ],
)
def test_a_terminal_that_tells_releases_has_them_told(text: str, moves: list[str]) -> None:
    assert heard((TELLS + text, 0)) == ["ReleasesReported", *moves]


def test_a_key_goes_up_by_the_name_it_had_when_it_went_down() -> None:
    shift_goes_first = "\x1b[119;2:1;87u\x1b[119;1:2;119u\x1b[119;1:3u"
    assert heard((TELLS + shift_goes_first, 0))[1:] == [f"W {move}" for move in MOVES]


def test_a_key_that_was_never_seen_down_does_not_go_up() -> None:
    assert heard((f"{TELLS}\x1b[119;1:3u", 0)) == ["ReleasesReported"]


def test_a_key_whose_release_was_lost_goes_up_before_it_goes_down_by_another_name() -> None:
    told = heard((f"{TELLS}\x1b[119;;119u\x1b[119;2;87u", 0))[1:]
    assert told == ["w press", "w release", "W press"]


def test_keys_whose_releases_were_lost_take_none_from_those_that_follow() -> None:
    greek = "".join(f"\x1b[{letter}u" for letter in range(0x391, 0x391 + 100) if letter != 0x3A2)
    told = heard((f"{TELLS}{greek}\x1b[119;;119u\x1b[119;1:3u", 0))[1:]
    down = sum("press" in move for move in told) - sum("release" in move for move in told)
    assert told[0] == "\u0391 press"
    assert "\u0391 release" in told
    assert (told[-2:], down) == (["w press", "w release"], 63)


def test_keys_of_a_terminal_that_tells_releases_of_some_come_as_from_one_that_tells_of_none() -> (
    None
):
    told = heard(("\x1b[?3uw\x1b[A\x1b[1;1:2A\x1b[1;1:3A", 0))
    assert told == ["ReleasesReported", "Key", "Key", "Key"]


def test_releases_press_nothing_where_nobody_asked_for_them() -> None:
    assert heard(("\x1b[119;1:3u\x1b[1;1:3A\x1b[B ", 0)) == ["Key", "Key"]


def test_answers_to_frames_are_told_and_other_answers_press_no_keys() -> None:
    told = heard(("w\x1b[2;3R", 0), ("\x1b[?62;22;52c\x1b[?1u", 0), ("\x1b[6;20;10t", 0))
    assert told == ["Key", "FrameAnswered", "ReleasesReported"]
    assert heard(("\x1b[1;2R", 0)) == ["Key"]


def test_numbers_that_no_terminal_means_take_no_key_with_them() -> None:
    assert heard((" \x1b[999999999999;99999999Rw", 0), ("\x1b[1114112099u ", 0)) == ["Key"] * 3


@pytest.mark.parametrize("place", ["-3;-2", "-1;7", "0;0"])
def test_a_button_that_goes_up_beyond_the_upper_left_corner_is_heard(place: str) -> None:
    down, up = heard(("\x1b[<0;5;5M", 0), (f"\x1b[<0;{place}m", 0))
    assert down == "MouseDown 4,4"
    assert up in {"MouseUp 0,0", "MouseUp 0,6"}


def test_a_console_that_is_behind_hears_of_every_button_and_key_but_of_few_moves() -> None:
    moves = "".join(f"\x1b[<35;{column};3M" for column in range(1, 80))
    wheel = "\x1b[<64;9;9M" * 50
    told = heard((f"{moves}{wheel}\x1b[<0;5;5M{moves}\x1b[<0;6;6m w", 9))
    assert [event.split()[0] for event in told] == ["MouseDown", "MouseUp", "Key", "Key"]


def test_where_the_mouse_went_is_told_when_the_console_has_caught_up() -> None:
    moves = "".join(f"\x1b[<35;{column};3M" for column in range(1, 80))
    assert heard((moves, 9), ("", 9)) == []
    assert heard((moves, 9), ("", 0)) == ["MouseMove 78,2"]
    assert heard((moves, 9), ("", 0), ("", 0)) == ["MouseMove 78,2"]


def test_of_moves_that_come_together_the_last_is_told_and_buttons_keep_their_place() -> None:
    moves = "".join(f"\x1b[<35;{column};3M" for column in range(1, 80))
    told = heard((f"{moves}\x1b[<0;5;5M\x1b[<32;6;5M\x1b[<32;7;5M\x1b[<0;7;5m", 0))
    assert told == ["MouseMove 78,2", "MouseDown 4,4", "MouseMove 6,4", "MouseUp 6,4"]


def test_text_without_brackets_is_dropped_whole_also_in_pieces() -> None:
    address = "https://example.org/w"
    assert heard((address, 0)) == [f"dropped {address}"]
    assert heard(("wasd\r\x1b[A", 0), (" e", 0)) == ["dropped wasd", "dropped  e"]
    pieces = heard(("q", 0), ("e", 0), ("\x10", 0))
    assert pieces == ["dropped qe", "dropped"], "none of them was passed on"


def test_keys_that_act_at_once_wait_for_nothing_and_two_fingers_drive() -> None:
    assert heard(("w", 0)) == ["Key"]
    assert heard(("wwwww d", 0))[:1] == ["dropped wwwww d"]
    assert heard(("wd", 0)) == ["Key", "Key"]
    assert heard(("www", 0), ("www ", 0)) == ["Key"] * 7
    assert heard(("t", 0)) == []


def test_input_that_cannot_be_read_is_told_as_dropped() -> None:
    assert heard(("\x1b[1;5\x02w", 0)) == ["dropped"]
    assert heard(("\x1b[200~w q\x1b[201~", 0)) == ["Paste"]


class Noting(App[None]):
    """Notes what it handles; a dropped key takes two turns of the loop."""

    def __init__(self) -> None:
        super().__init__()
        self.noted: list[str] = []

    def on_key_moved(self, event: KeyMoved) -> None:
        self.noted.append(event.key)

    async def on_keys_dropped(self) -> None:
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        self.noted.append("dropped")


def test_a_key_is_handled_at_the_next_turn_of_the_loop_and_never_before_earlier_reports():
    async def play() -> None:
        app = Noting()
        async with app.run_test() as pilot:
            driver = SturdyDriver(app)
            await pilot.pause()
            driver.process_message(KeyMoved("w", "w", KeyMove.PRESS))
            await asyncio.sleep(0)
            assert app.noted == ["w"]
            driver.process_message(KeysDropped())
            driver.process_message(KeyMoved("a", "a", KeyMove.PRESS))
            await asyncio.sleep(0)  # the first is being handled
            driver.process_message(KeyMoved("d", "d", KeyMove.PRESS))
            await pilot.pause()
            assert app.noted == ["w", "dropped", "a", "d"]

    asyncio.run(play())
