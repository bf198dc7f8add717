"""Tokens of a fleet on their way to a loop: many, of few keys and of many."""

from __future__ import annotations

import random

from hub.zenoh.token_changes import MOST_KEYS, TokenChanges


class Turns:
    """A loop that makes its calls when it is let."""

    def __init__(self) -> None:
        self.calls: list[object] = []

    def run(self) -> int:
        turns = 0
        while self.calls:
            self.calls.pop(0)()
            turns += 1
        return turns


def test_a_flood_of_tokens_loses_none_that_goes_and_is_served_in_turns() -> None:
    loop = Turns()
    seen: dict[str, bool] = {}
    changes = TokenChanges(loop.calls.append, seen.__setitem__)
    changes.note("f/honest", True)  # noqa: FBT003
    loop.run()
    for number in range(MOST_KEYS + 500):
        changes.note(f"f/{number}", True)  # noqa: FBT003
    changes.note("f/honest", False)  # noqa: FBT003
    assert len(loop.calls) == 1
    assert loop.run() > MOST_KEYS // 1000  # others get turns between
    assert (len(seen), changes.dropped) == (MOST_KEYS + 1, 500)
    assert seen["f/honest"] is False


def test_a_token_that_went_and_came_back_is_seen_to_go() -> None:
    loop, seen = Turns(), []
    changes = TokenChanges(loop.calls.append, lambda key, there: seen.append((key, there)))
    for there in (True, False, True, False, True):
        changes.note("f/robot", there)
    loop.run()
    assert seen == [("f/robot", False), ("f/robot", True)]


def test_a_fault_of_one_call_stops_no_other() -> None:
    loop, seen = Turns(), []

    def changed(key: str, there: bool) -> None:  # noqa: FBT001
        seen.append((key, there))
        raise ValueError(key)

    changes, dice = TokenChanges(loop.calls.append, changed), random.Random(2)
    last: dict[str, bool] = {}
    for _ in range(1000):
        key = f"f/{dice.randrange(50)}"
        last[key] = not last.get(key, False)
        changes.note(key, last[key])
    loop.run()
    assert dict(seen) == last
