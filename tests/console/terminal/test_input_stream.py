"""Answers of a terminal among keys and the mouse."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_tui.terminal.input_stream import (
    HOLD_S,
    BrokenSequence,
    CursorReport,
    InputPart,
    InputStream,
    KeyboardReport,
    KeyMove,
    KeyReport,
    Paste,
)
from tests.support.cases import for_each

KEYS = {"\x1b[A", "\x1b[1;2R", "\x1b[15~", "\x1b[97;5u", "\x1b[<0;5;5M"}
PIECES = st.sampled_from(
    ["w", "abc", "\x1b[A", "\x1b[<0;5;5M", "\x1b[2;3R", "\x1b[?62;4c", "\x1bP1$r0m\x1b\\", "é"]
)


def split(*pieces: str) -> list[InputPart]:
    stream = InputStream(KEYS.__contains__)
    return [part for piece in pieces for part in stream.feed(piece, 0.0)]


def test_reports_of_the_cursor_are_told_from_keys() -> None:
    assert split("w\x1b[2;7Rs") == ["w", CursorReport(row=2, column=7), "s"]


def test_a_report_of_the_first_row_is_a_key_with_a_modifier() -> None:
    assert split("\x1b[1;2R") == ["\x1b[1;2R"]


@for_each(
    "answer",
    [
        "\x1b[?62;22;52c",
        "\x1b[6;20;10t",
        "\x1bP1$r48:2:1:2:3m\x1b\\",
        "\x1bP1+r524742=38\x1b\\",
        "\x1b]11;rgb:0000/0000/0000\x07",
        "\x1b[?9999;0$y",
    ],
)
def test_late_answers_to_other_questions_press_no_keys(answer: str) -> None:
    assert split(f"w{answer}s") == ["ws"]
    for at in range(1, len(answer)):
        assert split(f"w{answer[:at]}", f"{answer[at:]}s") == ["w", "s"]


TELLS = "\x1b[?27u"


def moved(text: str) -> list[tuple[str, KeyMove, str]]:
    """What a terminal that tells releases says of keys: code, move, press."""
    stream = InputStream(lambda sequence: len(sequence) < 20)
    return [
        (part.code, part.move, part.press)
        for part in stream.feed(f"{TELLS}{text}", 0.0)
        if isinstance(part, KeyReport)
    ]


@for_each(
    ("sequence", "code", "move", "press"),
    [
        ("\x1b[119;;119u", "119u", KeyMove.PRESS, "\x1b[119;1;119u"),
        ("\x1b[119;1:1;119u", "119u", KeyMove.PRESS, "\x1b[119;1;119u"),
        ("\x1b[119;1:2;119u", "119u", KeyMove.REPEAT, "\x1b[119;1;119u"),
        ("\x1b[119;1:3u", "119u", KeyMove.RELEASE, "\x1b[119u"),
        ("\x1b[119:87;2:1;87u", "119u", KeyMove.PRESS, "\x1b[119;2;87u"),
        ("\x1b[99;5u", "99u", KeyMove.PRESS, "\x1b[99;5u"),
        ("\x1b[13u", "13u", KeyMove.PRESS, "\x1b[13u"),
        ("\x1b[A", "1A", KeyMove.PRESS, "\x1b[A"),
        ("\x1b[1;1:3A", "1A", KeyMove.RELEASE, "\x1b[1A"),
        ("\x1b[1;2:3A", "1A", KeyMove.RELEASE, "\x1b[1;2A"),
        ("\x1b[15;5:2~", "15~", KeyMove.REPEAT, "\x1b[15;5~"),
        ("\x1b[57441;2:1u", "57441u", KeyMove.PRESS, "\x1b[57441;2u"),
    ],
)
def test_a_key_that_moves_is_told_with_what_its_press_would_be(
    sequence: str, code: str, move: KeyMove, press: str
) -> None:
    assert moved(sequence) == [(code, move, press)]


@pytest.mark.parametrize(
    ("code", "name"), [(57399, "kp_0"), (57413, "kp_add"), (57426, "kp_delete")]
)
def test_keys_of_the_keypad_are_told_by_their_own_names(code: int, name: str) -> None:
    stream = InputStream(lambda _: True)
    parts = list(stream.feed(f"{TELLS}\x1b[{code};1:1u\x1b[{code};1:3u\x1b[{ord('8')}u", 0.0))
    assert [part.keypad for part in parts if isinstance(part, KeyReport)] == [name, name, ""]


@for_each(
    ("sequence", "press", "base"),
    [
        ("\x1b[1094::119;;1094u", "\x1b[1094;1;1094u", "w"),
        ("\x1b[1094:1062:119;2;1062u", "\x1b[1094;2;1062u", "w"),
        ("\x1b[1089::99;5u", "\x1b[99;5u", "c"),
        ("\x1b[38::49;;38u", "\x1b[38;1;38u", "1"),
        ("\x1b[119::1094;;119u", "\x1b[119;1;119u", ""),
        ("\x1b[119::;;119u", "\x1b[119;1;119u", ""),
        ("\x1b[119:87:119:1:2;;119u", "\x1b[119;1;119u", "w"),
    ],
)
def test_a_key_of_another_keyboard_is_told_with_what_it_types_on_a_us_keyboard(
    sequence: str, press: str, base: str
) -> None:
    stream = InputStream(lambda _: True)
    _, part = stream.feed(f"{TELLS}{sequence}", 0.0)
    assert isinstance(part, KeyReport)
    assert (part.press, part.base) == (press, base)


def test_keys_are_taken_apart_only_for_a_terminal_that_tells_releases() -> None:
    assert split("\x1b[?1u", "\x1b[97;5u") == [KeyboardReport(reports_releases=False), "\x1b[97;5u"]
    stream = InputStream(KEYS.__contains__)
    assert list(stream.feed(f"{TELLS}\x1b[97;5u\x1b[?0u\x1b[97;5u", 0.0)) == [
        KeyboardReport(reports_releases=True),
        KeyReport(code="97u", move=KeyMove.PRESS, press="\x1b[97;5u"),
        KeyboardReport(reports_releases=False),
        "\x1b[97;5u",
    ]


@for_each("flags", [1, 2, 3, 7, 9, 17, 21])
def test_a_terminal_that_tells_releases_of_some_keys_is_as_one_that_tells_of_none(
    flags: int,
) -> None:
    stream = InputStream(lambda _: True)
    arrow = "w\x1b[A\x1b[1;1:1A\x1b[1;1:2A\x1b[1;5:2A\x1b[1;1:3Aw"
    assert list(stream.feed(f"\x1b[?{flags}u{arrow}", 0.0)) == [
        KeyboardReport(reports_releases=False),
        "w\x1b[A\x1b[1A\x1b[1A\x1b[1;5Aw",
    ]


@for_each("flags", [10, 11, 15, 27, 31])
def test_a_terminal_that_tells_releases_of_all_keys_is_believed(flags: int) -> None:
    (report,) = InputStream(lambda _: True).feed(f"\x1b[?{flags}u", 0.0)
    assert report == KeyboardReport(reports_releases=True)


def test_text_of_an_input_method_is_no_key_that_goes_up() -> None:
    assert moved("\x1b[0;;119u\x1b[0;;119:97u\x1b[00u") == []
    stream = InputStream(lambda _: True)
    assert list(stream.feed(f"{TELLS}\x1b[0;;119u", 0.0))[1:] == ["\x1b[0;;119u"]


def test_no_release_is_lost_that_comes_in_two_pieces() -> None:
    stream = InputStream(lambda _: True)
    assert list(stream.feed(f"{TELLS}\x1b[119;1", 0.0)) == [KeyboardReport(reports_releases=True)]
    assert list(stream.feed("", 3 * HOLD_S)) == []
    up = KeyReport(code="119u", move=KeyMove.RELEASE, press="\x1b[119u")
    assert list(stream.feed(":3u", 6 * HOLD_S)) == [up]


def test_pasted_text_and_the_mouse_are_no_keys_that_move() -> None:
    text = "\x1b[200~w\x1b[201~\x1b[<0;5;5M\x1b[I\x1b[O\x1b[2;3R"
    assert moved(text) == []


@given(st.lists(st.sampled_from("0123456789;:u~ABCDEFHPQSR[\x1b?<Mm w"), max_size=40))
def test_no_bytes_break_it(letters: list[str]) -> None:
    stream = InputStream(lambda _: True)
    for part in stream.feed(TELLS + "".join(letters), 0.0):
        assert not isinstance(part, KeyReport) or len(part.press) < 60


def test_what_the_driver_understands_comes_through_whole() -> None:
    assert split("\x1b[", "A") == ["\x1b[A"]
    assert split("\x1b", "[1", "5~x") == ["\x1b[15~x"]


def test_a_lone_escape_is_held_until_nothing_follows() -> None:
    stream = InputStream(KEYS.__contains__)
    assert list(stream.feed("w\x1b", 0.0)) == ["w"]
    assert stream.holding
    assert list(stream.feed("", HOLD_S / 2)) == []
    assert list(stream.feed("", HOLD_S)) == ["\x1b"]
    assert not stream.holding


def test_a_letter_with_alt_is_a_key_when_nothing_follows() -> None:
    for letter in "P[]w":
        stream = InputStream(KEYS.__contains__)
        fed = [*stream.feed(f"\x1b{letter}", 0.0), *stream.feed("", HOLD_S)]
        assert fed == [f"\x1b{letter}"]


@for_each(
    "pieces",
    [
        ("\x1b[1;5", "\x1b[Aq"),
        ("\x1b[1;5\x02w\x1b[A",),
        ("\x1b[1;5é",),
        ("\x1bP1$r0w\x1b[A",),
        ("\ufffdw",),
    ],
)
def test_what_remains_of_a_mutilated_sequence_presses_no_key(pieces: tuple[str, ...]) -> None:
    parts = split("t", *pieces)
    assert parts[:2] == ["t", BrokenSequence()]
    assert not {"1", "5", ";", "P", "$", "w"} & set(joined(parts[2:]))


@for_each("begun", ["\x1b[1;5", "\x1bP1$r", "\x1b]11;rgb", "\x1b[<0;5"])
def test_a_sequence_whose_end_never_comes_presses_no_key(begun: str) -> None:
    stream = InputStream(KEYS.__contains__)
    assert list(stream.feed(begun, 0.0)) == []
    assert list(stream.feed("", HOLD_S)) == [BrokenSequence()]
    assert list(stream.feed("w", HOLD_S)) == ["w"]


def test_function_keys_of_the_linux_console_are_no_letters() -> None:
    stream = InputStream({"\x1b[[A", "\x1b[[E"}.__contains__)
    assert list(stream.feed("\x1b[[A", 0.0)) == ["\x1b[[A"]
    assert [*stream.feed("\x1b[", 0.0), *stream.feed("[", 0.01), *stream.feed("E", 0.02)] == [
        "\x1b[[E"
    ]


BEGINS, ENDS = "\x1b[200~", "\x1b[201~"


def test_a_paste_is_one_text_however_it_is_cut() -> None:
    text = f"w{BEGINS}qe\x1b[A t{ENDS}s"
    for at in range(len(text)):
        parts = split(text[:at], text[at:])
        assert [part for part in parts if isinstance(part, Paste)] == [
            Paste(text="qe\x1b[A t", whole=True)
        ]
        assert joined([part for part in parts if isinstance(part, str)]) == "ws"
    assert split(ENDS, "w") == ["w"]


def test_a_paste_whose_end_is_lost_takes_the_keys_for_two_seconds_only() -> None:
    stream = InputStream(KEYS.__contains__)
    assert list(stream.feed(f"{BEGINS}ab", 0.0)) == []
    assert list(stream.feed(" ", 1.9)) == []
    assert stream.holding
    assert list(stream.feed(" ", 2.0)) == [Paste(text="ab  ", whole=False)]
    assert list(stream.feed(" ", 2.1)) == [" "]
    (long,) = stream.feed(BEGINS + 100_000 * "a", 3.0)
    assert isinstance(long, Paste)
    assert not long.whole


@given(st.lists(PIECES, max_size=12), st.data())
def test_however_it_is_cut_the_same_comes_out(pieces: list[str], data: st.DataObject) -> None:
    text = "".join(pieces)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(text)), max_size=5)))
    parts = [text[a:b] for a, b in zip([0, *cuts], [*cuts, len(text)], strict=True)]
    assert joined(split(*parts)) == joined(split(text))


@given(st.lists(st.text(alphabet="\x1b[]PX_^?;0123456789Rcumt$y\\\x07 wM<", max_size=40)))
def test_nothing_that_comes_is_too_odd(pieces: list[str]) -> None:
    stream = InputStream(KEYS.__contains__)
    parts = [part for piece in pieces for part in stream.feed(piece, 0.0)]
    parts += stream.feed("", HOLD_S)
    assert len(joined(parts)) <= len("".join(pieces))


def joined(parts: list[InputPart]) -> str:
    """Everything in one text, a cursor report as its place."""
    return "".join(
        part if isinstance(part, str) else f"{part.row},{part.column}"
        for part in parts
        if isinstance(part, str | CursorReport)
    )
