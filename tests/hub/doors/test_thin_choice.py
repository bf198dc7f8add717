"""When states come at the low rate, and which numbers they have then."""

from __future__ import annotations

from functools import partial

from hub.doors.mirror.thin_choice import LATE_S, LeftOutNumbers, ThinChoice

FRESH, LATE = 0.1, LATE_S + 0.2


class Bench:
    """A line, and the choice for it, looked at twice a second."""

    def __init__(self, delay: float = 0.0) -> None:
        self.choice, self.now, self.delay = ThinChoice(), 100.0, delay

    def run(self, seconds: float, *ages: float) -> bool:
        end = self.now + seconds
        while self.now < end:
            self.now += 0.5
            for age in ages:
                self.choice.note(age)
            self.choice.look(self.now, self.delay)
        return self.choice.thin

    def until_full(self, *ages: float) -> float:
        """Time at the low rate with these ages [s]."""
        began = self.now
        while self.choice.thin and self.now < began + 1000.0:
            self.run(0.5, *ages)
        return self.now - began


def test_a_line_that_falls_behind_gets_the_low_rate_within_seconds() -> None:
    bench = Bench()
    assert not bench.run(60.0, FRESH)
    assert bench.run(2.0, LATE, 3 * LATE)


def test_old_measurements_silence_and_a_long_way_are_no_thin_line() -> None:
    assert not Bench().run(60.0, FRESH, 10.0)
    assert not Bench().run(60.0)
    assert not Bench(delay=LATE).run(60.0, LATE)


def test_the_full_rate_is_tried_again_less_often_each_time_that_it_fails() -> None:
    bench = Bench()
    trials = []
    for _ in range(6):
        assert bench.run(3.0, LATE)
        trials.append(round(bench.until_full(FRESH)))
    assert 10 <= trials[0] <= 12
    assert trials == sorted(trials)
    assert 155 <= trials[-1] <= 162
    bench.run(60.0, FRESH)
    assert bench.run(3.0, LATE)
    assert bench.until_full(FRESH) < 13.0


def test_the_low_rate_stays_while_states_are_late_there_too() -> None:
    bench = Bench()
    assert bench.run(300.0, LATE)


def test_messages_that_the_low_rate_leaves_out_are_not_lost_and_real_gaps_stay() -> None:
    numbers = LeftOutNumbers()
    full, thin = (partial(numbers.number, "m", 7, thin=each) for each in (False, True))
    assert [full(each) for each in (5, 6, 8)] == [5, 6, 8]
    assert [thin(each) for each in (13, 18, 23)] == [9, 10, 11]
    assert [full(each) for each in (24, 26)] == [12, 14]
    assert numbers.number("m", 8, 3, thin=True) == 3
    assert (numbers.knows("m", 8), numbers.knows("x", 8)) == (True, False)


def test_numbers_rise_whatever_a_publisher_counts() -> None:
    numbers = LeftOutNumbers()
    number = lambda sequence: numbers.number("m", 7, sequence, thin=True)  # noqa: E731
    for start in (1, 5000, 1, 1 << 63, 40, 9000, 3):
        found = [number(start + 5 * each) for each in range(50)]
        assert found == sorted(set(found))
        assert found[0] > 0
