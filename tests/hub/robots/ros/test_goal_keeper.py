"""The goals at a robot's own navigation: one after the other, and none survives its end."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.gcm.own_navigation import OwnGoal
from hub.robots.ros.goals.goal_keeper import ANSWER_S, CANCEL_AGAIN_S, SILENT_S, GoalKeeper
from hub.ros.goal_messages import EVERY_GOAL, CancelAnswer, GoalPlace, GoalStatus, KnownGoal

TAG = "72756e65abcdef01"
HERE = GoalPlace(frame="map", x=1.0, y=2.0, theta=0.0)
OTHER = KnownGoal(name="ff" * 16, status=GoalStatus.DRIVES)


class Site:
    """A keeper, its robot, and the time."""

    def __init__(self):
        self.now = 100.0
        self.sent, self.cancels = [], []
        self.asked, self.asks = [], True
        self.open = True
        self.keeper = GoalKeeper(self, TAG)
        self.keeper.reach(self.now, ready=True)

    def send(self, name, place):
        if self.open:
            self.sent.append((name, place))
        return self.open

    def cancel(self, name):
        if self.open:
            self.cancels.append(name)
        return self.open

    def explain(self, name):
        if self.asks:
            self.asked.append(name)
        return self.asks

    @property
    def name(self):
        return self.sent[-1][0]

    def go(self, number=1):
        self.keeper.go(number, HERE, self.now)

    def drive(self, number=1):
        self.go(number)
        self.keeper.taken(self.name, self.now)
        self.lists(GoalStatus.DRIVES)

    def lists(self, status, *more, name="", text=""):
        own = KnownGoal(name=name or self.name, status=status, text=text)
        self.keeper.listed((own, *more), self.now)

    def wait(self, seconds, tick=0.05):
        for _ in range(round(seconds / tick)):
            self.now += tick
            self.keeper.advance(self.now)

    @property
    def state(self):
        return self.keeper.state


@pytest.fixture
def site():
    return Site()


def test_a_goal_is_sent_once_and_ends_as_the_robot_says(site):
    for number, (status, state) in enumerate(
        {
            GoalStatus.REACHED: OwnGoal.REACHED,
            GoalStatus.ABORTED: OwnGoal.ABORTED,
            GoalStatus.CANCELLED: OwnGoal.CANCELLED,
            GoalStatus.REFUSED: OwnGoal.REFUSED,
        }.items(),
        start=1,
    ):
        site.go(number)
        site.go(number)
        assert len(site.sent) == number
        assert site.name.startswith(TAG)
        assert len(site.name) == 32
        assert site.state is OwnGoal.SENT
        assert site.keeper.drives
        site.lists(GoalStatus.DRIVES)
        assert site.state is OwnGoal.DRIVES
        site.lists(status, text="no way")
        assert site.state is state
        assert ("no way" in site.keeper.why) is (state is not OwnGoal.REACHED)
        assert not site.keeper.drives
        site.go(number)
        assert len(site.sent) == number
    assert not site.cancels


def test_a_goal_that_the_robot_does_not_take_is_refused(site):
    site.go()
    site.keeper.refused(site.name)
    assert site.state is OwnGoal.REFUSED
    assert "refuses" in site.keeper.why
    site.open = False
    site.go(2)
    assert site.state is OwnGoal.REFUSED
    assert not site.keeper.drives


def test_the_end_of_a_goal_is_cancelled_at_once_and_again_until_it_is_acknowledged(site):
    site.drive()
    site.keeper.end(site.now)
    assert site.cancels == [site.name]
    assert site.state is OwnGoal.CANCELLED
    assert not site.keeper.drives
    assert not site.keeper.settled(site.now)
    site.keeper.cancelled(site.name, CancelAnswer.BEGINS)
    site.lists(GoalStatus.CANCELS)
    assert not site.keeper.unanswered(site.now)
    site.wait(CANCEL_AGAIN_S + 0.1)
    assert site.cancels == [site.name] * 2
    assert site.keeper.unanswered(site.now)
    assert site.keeper.settled(site.now), "an operator can drive again"
    site.lists(GoalStatus.CANCELLED)
    assert not site.keeper.ending
    site.wait(3.0)
    assert len(site.cancels) == 2


@pytest.mark.parametrize("answer", [CancelAnswer.UNKNOWN, CancelAnswer.ENDED])
def test_a_robot_that_does_not_have_the_goal_any_more_ends_it(site, answer):
    site.drive()
    site.keeper.end(site.now)
    site.keeper.cancelled(site.name, answer)
    assert not site.keeper.ending


def test_a_cancel_that_cannot_leave_leaves_later(site):
    site.drive()
    site.open = False
    site.keeper.end(site.now)
    assert not site.cancels
    site.open = True
    site.wait(0.05)
    assert site.cancels == [site.name]


def test_the_next_goal_waits_for_the_end_of_the_one_before(site):
    site.drive()
    first = site.name
    site.go(2)
    assert site.cancels == [first]
    assert len(site.sent) == 1
    assert site.state is OwnGoal.SENT
    assert not site.keeper.drives
    site.lists(GoalStatus.CANCELLED)
    site.wait(0.05)
    assert len(site.sent) == 2
    assert site.keeper.drives


def test_a_goal_that_waits_is_not_sent_after_its_end(site):
    site.drive()
    site.go(2)
    site.keeper.end(site.now)
    site.lists(GoalStatus.CANCELLED)
    site.wait(2.0)
    assert len(site.sent) == 1
    assert site.state is OwnGoal.CANCELLED


def test_a_goal_taken_after_its_end_is_cancelled_again(site):
    """The answers to two services may overtake each other."""
    site.go()
    site.keeper.end(site.now)
    site.keeper.cancelled(site.name, CancelAnswer.UNKNOWN)
    site.cancels.clear()
    site.keeper.taken(site.name, site.now)
    site.wait(0.05)
    assert site.cancels == [site.name]


def test_a_list_from_before_the_goal_does_not_end_its_cancel(site):
    site.go()
    site.keeper.end(site.now)
    site.keeper.listed((), site.now + 0.1)
    assert site.keeper.ending
    site.wait(0.5)
    site.keeper.listed((), site.now)
    assert site.keeper.ending
    site.wait(0.45)
    site.now += 0.06
    site.keeper.listed((), site.now)
    assert not site.keeper.ending


def test_a_robot_that_does_not_answer_or_falls_silent_is_cancelled(site):
    site.go()
    site.wait(ANSWER_S - 0.1)
    assert site.keeper.drives
    site.wait(0.2)
    assert site.state is OwnGoal.LOST
    assert site.cancels == [site.name]
    site.keeper.cancelled(site.name, CancelAnswer.UNKNOWN)
    site.drive(2)
    for _ in range(10):
        site.wait(1.0)
        site.keeper.moved(site.name, 3.5, site.now)
    assert site.keeper.left == 3.5
    site.wait(SILENT_S - 0.2)
    assert site.keeper.drives
    assert site.keeper.heard_s(site.now) == pytest.approx(SILENT_S - 0.2)
    site.wait(0.3)
    assert site.state is OwnGoal.LOST
    assert "silent" in site.keeper.why
    assert site.cancels[-1] == site.name


def test_after_a_lost_line_the_goal_is_cancelled_and_never_sent_again(site):
    site.drive()
    site.keeper.reach(site.now, ready=False)
    assert site.state is OwnGoal.LOST
    assert not site.keeper.drives
    site.wait(5.0)
    assert not site.cancels
    assert site.keeper.unanswered(site.now)
    site.keeper.reach(site.now, ready=True)
    site.wait(0.05)
    assert site.cancels == [site.name]
    site.lists(GoalStatus.CANCELS)
    site.lists(GoalStatus.CANCELLED)
    site.wait(5.0)
    assert len(site.sent) == 1
    assert not site.keeper.ending


def test_a_goal_without_a_line_is_refused(site):
    site.keeper.reach(site.now, ready=False)
    site.go()
    assert site.state is OwnGoal.REFUSED
    site.keeper.reach(site.now, ready=True)
    site.wait(1.0)
    assert not site.sent


def test_a_navigation_that_began_again_does_not_have_the_goal(site):
    site.drive()
    site.keeper.listed((), site.now)
    assert site.state is OwnGoal.LOST
    site.wait(0.05)
    assert site.cancels == [site.name], "to be sure"


def test_a_goal_of_the_process_before_is_cancelled_and_that_of_another_node_is_not(site):
    left = KnownGoal(name=f"{TAG}{'0' * 16}", status=GoalStatus.DRIVES)
    site.keeper.listed((left, OTHER), site.now)
    site.wait(0.05)
    assert site.cancels == [left.name]
    assert site.keeper.others == (OTHER,)
    assert math.isnan(site.keeper.heard_s(site.now))


def test_a_stop_ends_all_goals_and_looks_that_they_end(site):
    site.drive()
    site.lists(GoalStatus.DRIVES, OTHER)
    site.keeper.stop(site.now)
    assert site.cancels == [site.name, EVERY_GOAL]
    site.lists(GoalStatus.CANCELLED, OTHER)
    site.wait(CANCEL_AGAIN_S + 0.1)
    assert site.cancels[2:] == [OTHER.name]
    site.lists(GoalStatus.CANCELLED)
    assert not site.keeper.ending


EVENTS = st.one_of(
    st.tuples(st.just("go"), st.integers(1, 5)),
    st.tuples(st.just("end"), st.none()),
    st.tuples(st.just("stop"), st.none()),
    st.tuples(st.just("reach"), st.booleans()),
    st.tuples(st.just("taken"), st.integers(0, 4)),
    st.tuples(st.just("refused"), st.integers(0, 4)),
    st.tuples(st.just("list"), st.lists(st.tuples(st.integers(0, 4), st.sampled_from(GoalStatus)))),
    st.tuples(st.just("answer"), st.tuples(st.integers(0, 4), st.sampled_from(CancelAnswer))),
    st.tuples(st.just("wait"), st.floats(0.0, 4.0)),
)


@given(st.lists(EVENTS, max_size=40))
def test_in_any_order_a_goal_that_nobody_wants_does_not_drive(events):
    site = Site()
    keeper = site.keeper

    def name(index):
        return site.sent[index % len(site.sent)][0] if site.sent else "00" * 16

    def listed(goals):
        known = [KnownGoal(name=name(index), status=status) for index, status in goals]
        keeper.listed(known, site.now)

    act = {
        "go": site.go,
        "end": lambda _: keeper.end(site.now),
        "stop": lambda _: keeper.stop(site.now),
        "reach": lambda ready: keeper.reach(site.now, ready=ready),
        "taken": lambda index: keeper.taken(name(index), site.now),
        "refused": lambda index: keeper.refused(name(index)),
        "list": listed,
        "answer": lambda each: keeper.cancelled(name(each[0]), each[1]),
        "wait": lambda seconds: site.wait(seconds, tick=0.5),
    }
    wanted = False
    for what, value in events:
        sent = len(site.sent)
        new = what == "go" and value != keeper.number
        wanted = (wanted or new) and what not in ("end", "stop")
        act[what](value)
        assert wanted or not keeper.drives, "a goal drives that nobody wants"
        assert wanted or len(site.sent) == sent, "a goal is sent that nobody wants"
    assert len({each for each, _ in site.sent}) == len(site.sent)


def test_the_reason_of_an_aborted_goal_is_asked_for_once_after_all_that_is_due(site):
    site.drive()
    site.lists(GoalStatus.ABORTED)
    assert site.state is OwnGoal.ABORTED
    site.asks = False  # no room now
    site.wait(0.1)
    site.asks = True
    site.wait(1.0)
    assert site.asked == [site.name]
    assert site.keeper.why == "the robot's own navigation gave up"
    site.keeper.explained(site.name, "there is no path")
    assert site.keeper.why == "the robot's own navigation gave up: there is no path"
    assert not site.cancels


@pytest.mark.parametrize("status", [GoalStatus.REACHED, GoalStatus.CANCELLED, GoalStatus.REFUSED])
def test_no_reason_is_asked_for_after_another_end(site, status):
    site.drive()
    site.lists(status)
    site.wait(0.1)
    assert not site.asked


def test_a_reason_that_the_robot_lists_is_not_asked_for(site):
    site.drive()
    site.lists(GoalStatus.ABORTED, text="no way")
    site.wait(0.1)
    assert not site.asked


def test_a_late_reason_changes_nothing_but_words_of_its_own_goal(site):
    site.drive()
    first = site.name
    site.lists(GoalStatus.ABORTED)
    site.wait(0.1)
    site.go(2)
    site.keeper.explained(first, "there is no path")
    assert (site.state, site.keeper.why) == (OwnGoal.SENT, "")
    site.keeper.taken(site.name, site.now)
    site.lists(GoalStatus.ABORTED)
    site.keeper.explained(first, "there is no path")
    site.keeper.explained(site.name, "")
    assert site.keeper.why == "the robot's own navigation gave up"


def test_after_a_lost_line_no_reason_is_asked_for(site):
    site.drive()
    site.lists(GoalStatus.ABORTED)
    site.keeper.reach(site.now, ready=False)
    site.keeper.reach(site.now, ready=True)
    site.wait(0.1)
    assert not site.asked
    assert site.state is OwnGoal.ABORTED
