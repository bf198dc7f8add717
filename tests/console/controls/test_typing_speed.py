"""Text that is pasted without brackets, told from typed keys by its speed."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.controls.typing_speed import QUIET_S, TOGETHER_S, PastedKeys, Stroke, TypingSpeed
from tests.support.cases import for_each

DRIVING = "wasd "


def stroke(key: str) -> Stroke[str]:
    return Stroke(key=key, text=len(key) == 1, at_once=key in DRIVING, event=key)


class Line:
    """A line on which keys come at some time, looked at whenever nothing waits on it."""

    def __init__(self) -> None:
        self.speed: TypingSpeed[str] = TypingSpeed()
        self.passed: list[str] = []
        self.dropped: list[str] = []

    def read(self, keys: str | list[str], at: float) -> None:
        """One read brings these keys."""
        for each in self.speed.take([stroke(key) for key in keys], at):
            if isinstance(each, PastedKeys):
                self.dropped += [dropped.key for dropped in each.strokes]
            else:
                self.passed.append(each.key)

    def idle(self, at: float) -> None:
        """Nothing waits on the line."""
        self.passed += [each.key for each in self.speed.idle(at)]


@for_each("apart", [0.0, 0.001, 0.0099])
def test_text_that_comes_faster_than_fingers_is_dropped_from_its_first_key_on(apart: float):
    line = Line()
    for number, key in enumerate("quit now, e"):
        line.read(key, number * apart)
        line.idle(number * apart)
    line.idle(9.0)
    assert "".join(line.dropped) == "quit now, e"
    assert line.passed == []


def test_keys_count_again_when_none_came_for_a_while_after_a_paste():
    line = Line()
    line.read("explore", 0.0)
    line.read("t", QUIET_S - 0.01)
    line.read(["ctrl+p"], 2 * QUIET_S - 0.02)
    line.idle(2.0)
    assert line.passed == []
    line.read("t", 3 * QUIET_S)
    line.idle(3 * QUIET_S + TOGETHER_S + 0.001)
    assert line.passed == ["t"]
    line.read("explore", 2.0)
    assert "".join(line.dropped[-7:]) == "explore", "the same text again"


def test_typed_keys_pass_in_their_order_and_those_that_act_at_once_at_once():
    line = Line()
    for number, key in enumerate("typed text"):
        line.read(key, number * 0.03)
        line.idle(number * 0.03 + TOGETHER_S + 0.001)
    assert "".join(line.passed) == "typed text"
    line = Line()
    line.read("wd", 0.0)
    line.read(["up", "f8"], 0.001)
    assert line.passed == ["w", "d", "up", "f8"]
    line.read("a", 0.002)
    assert line.dropped == ["a"], "no hand presses three at once"


def test_a_held_key_is_no_part_of_a_paste():
    line = Line()
    for number in range(100):
        line.read("w", number * 0.033)
        line.idle(number * 0.033 + TOGETHER_S + 0.001)
    line.read("wwwt", 3.3)
    line.idle(3.3 + TOGETHER_S + 0.001)
    line.read("ttttt", 3.8)
    assert "".join(line.passed) == 103 * "w" + 6 * "t"


def test_a_read_that_came_late_counts_as_together_with_the_one_before():
    line = Line()
    line.read("q", 0.0)
    line.read("e", 0.5)
    assert line.dropped == ["q", "e"]


@given(
    st.lists(
        st.tuples(
            st.lists(st.sampled_from([*"wasd qet\r", "up", "ctrl+p"]), max_size=4),
            st.sampled_from([0.0, 0.005, 0.011, 0.05, 0.4]),
            st.booleans(),
        ),
        max_size=30,
    )
)
def test_every_key_is_passed_on_or_dropped_once_and_in_its_order(
    reads: list[tuple[list[str], float, bool]],
):
    line, now, typed = Line(), 0.0, []
    for keys, pause, idle in reads:
        line.read(keys, now)
        typed += keys
        now += pause
        if idle:
            line.idle(now)
    line.idle(now + 1.0)
    assert sorted(line.passed + line.dropped) == sorted(typed)
    assert line.speed.waits is False
