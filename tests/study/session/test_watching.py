"""The experimenter's screen, its orders, and what blinds him."""

from __future__ import annotations

import stat
import tomllib
from pathlib import Path

from rune_study.plan.blinding import key_path, write_key
from rune_study.plan.steps import codes, plan
from rune_study.session.journal import Journal, Record
from rune_study.session.live import LIVE, read_signs
from rune_study.session.orders import ORDERS, OrderBook, give_order
from rune_study.session.overview import State, overview
from rune_study.session.status import status_lines
from rune_study.session.watching import WatchScreen, keys_line
from tests.study.studies import FOUR, study_of
from tests.support.cases import for_each


def test_orders_reach_a_session_once_and_in_order(tmp_path: Path) -> None:
    give_order(tmp_path, "begin")
    book = OrderBook(tmp_path)
    assert book.fresh() == []
    give_order(tmp_path, "mark")
    give_order(tmp_path, "note", "he looked away")
    assert [(each.do, each.text) for each in book.fresh()] == [
        ("mark", ""),
        ("note", "he looked away"),
    ]
    assert book.fresh() == []


def test_other_lines_are_no_orders(tmp_path: Path) -> None:
    give_order(tmp_path, "begin")
    book = OrderBook(tmp_path)
    with (tmp_path / ORDERS).open("ab") as file:
        file.write(b"begin\n\x00\xff\n")
    assert book.fresh() == []
    give_order(tmp_path, "dance")
    assert book.fresh() == []


@for_each("size", [(80, 24), (120, 40)])
def test_the_screen_shows_steps_and_gives_orders(tmp_path_factory, size: tuple[int, int]) -> None:
    import asyncio

    folder = tmp_path_factory.mktemp("study")
    study = study_of(folder, FOUR)
    step = plan(study, 2)[0]
    with Journal.of(study, 2) as journal:
        journal.put("begin", n=0, attempt=1, step=step.name, trial=1, code=step.code)
        journal.put("note", n=0, text="calm")
    book = OrderBook(folder / "sub-02")

    async def watch() -> str:
        app = WatchScreen(study, 2)
        async with app.run_test(size=size) as pilot:
            await pilot.press("b", "a", "n", *"ok", "enter", "m")
            shown = "\n".join(str(app.query_one(name).render()) for name in ("#list", "#journal"))
            await pilot.press("q")
        return shown

    shown = asyncio.run(watch())
    assert f"NOW  t1 {step.code}" in shown
    assert "note calm" in shown
    assert "hri-a" not in shown
    assert [(each.do, each.text) for each in book.fresh()] == [
        ("begin", ""),
        ("note", "ok"),
        ("mark", ""),
    ]


def history(*records: tuple[float, str, dict[str, object]]) -> list[Record]:
    """Records of a journal, at these seconds."""
    head = Record(what="session", at=0.0, moment=0.0, data={"replaces": 0, "study": ""})
    return [head, *(Record(what=what, at=at, moment=at, data=data) for at, what, data in records)]


TRIAL_1 = (10.0, "begin", {"n": 0, "attempt": 1})
RUNNING = (20.0, "trial-begin", {"n": 0})


@for_each(
    ("records", "state", "elapsed"),
    [
        ([], State.BETWEEN, 0.0),
        ([TRIAL_1], State.WAITS, 0.0),
        ([TRIAL_1, RUNNING], State.RUNS, 80.0),
        ([TRIAL_1, RUNNING, (50.0, "frozen", {"n": 0})], State.FROZEN, 30.0),
        (
            [TRIAL_1, RUNNING, (50.0, "frozen", {"n": 0}), (70.0, "unfrozen", {"n": 0})],
            State.RUNS,
            60.0,
        ),
        ([TRIAL_1, RUNNING, (30.0, "order", {"do": "pause"})], State.PAUSED, 10.0),
        (
            [TRIAL_1, RUNNING, (30.0, "order", {"do": "pause"}), (90.0, "order", {"do": "begin"})],
            State.RUNS,
            20.0,
        ),
        ([TRIAL_1, RUNNING, (90.0, "trial-end", {"n": 0})], State.BETWEEN, 0.0),
        ([TRIAL_1, (95.0, "declined", {"n": 0})], State.DECLINED, 0.0),
        ([TRIAL_1, RUNNING, (90.0, "done", {"n": 0})], State.BETWEEN, 0.0),
    ],
)
def test_the_state_of_a_session_follows_from_its_journal(
    tmp_path_factory, records, state, elapsed
) -> None:
    study = study_of(tmp_path_factory.mktemp("study"), FOUR)
    found = overview(study, 2, history(*records), [], now=100.0, seen=100.0)
    assert found.state is state
    assert found.elapsed == elapsed


def test_what_is_left_of_a_session_shrinks_with_each_step(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    whole = overview(study, 2, history(), [], now=0.0, seen=0.0)
    done = [(1.0, "done", {"n": step.number}) for step in whole.steps]
    one = overview(study, 2, history(*done[:1]), [], now=0.0, seen=0.0)
    every = overview(study, 2, history(*done), [], now=0.0, seen=0.0)
    assert (whole.minutes, one.minutes, every.minutes) == (44.0, 33.0, 0.0)
    assert (every.state, overview(study, 2, [], [], now=0.0, seen=0.0).state) == (
        State.COMPLETE,
        State.ABSENT,
    )


def test_silence_and_failures_are_alarms(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    runs = history(TRIAL_1, RUNNING)
    silent = [{"silent": 0.1}, {"silent": 2.5}]
    given = {"now": 100.0, "seen": 99.5}
    assert overview(study, 2, runs, silent, **given).alarms == ("robot 2 says nothing for 2.5 s",)
    lost = overview(study, 2, runs, silent, now=100.0, seen=80.0)
    assert lost.alarms == ("the session gave no sign of life for 20 s",)
    failed = history(TRIAL_1, (90.0, "lost", {"n": 0, "why": "the console did not start"}))
    assert overview(study, 2, failed, [], **given).alarms == (
        "t1 does not count and begins again: the console did not start",
    )
    assert overview(study, 2, failed, [], now=1000.0, seen=0.0).alarms == ()


def test_the_keys_fit_the_smallest_terminal() -> None:
    assert all(len(keys_line(state)) <= 78 for state in State)
    assert "BEGIN" in keys_line(State.WAITS)


def test_a_damaged_file_of_signs_is_none(tmp_path: Path) -> None:
    assert read_signs(tmp_path) == (0.0, [])
    for content in (b"", b"[]", b'{"at": 1}', b'{"at": 1, "robots": [3]}', b"[" * 9000, b"\xff"):
        (tmp_path / LIVE).write_bytes(content)
        assert read_signs(tmp_path) == (0.0, [])
    (tmp_path / LIVE).write_bytes(b'{"at": 5, "robots": [{"silent": 1, "speed": NaN}]}')
    assert read_signs(tmp_path) == (5.0, [{"silent": 1.0}])


def test_the_key_of_a_blind_study_is_its_owners(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    write_key(study)
    path = key_path(tmp_path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    key = tomllib.loads(path.read_text())
    assert key == {code: dict(each) for code, each in zip(codes(study), study.levels, strict=True)}


def test_an_open_study_has_no_key(tmp_path: Path) -> None:
    write_key(study_of(tmp_path, '[factors]\nlayout = ["hri-a", "hri-b"]\n'))
    assert not key_path(tmp_path).exists()


def test_status_names_who_is_where_and_who_is_next(tmp_path: Path) -> None:
    study = study_of(tmp_path, FOUR)
    with Journal.of(study, 1) as journal:
        for step in plan(study, 1):
            journal.put("begin", n=step.number, attempt=1, step=step.name)
            journal.put("done", n=step.number, attempt=1, result={})
    with Journal.of(study, 3, replaces=1) as journal:
        journal.put("begin", n=0, attempt=1, step="t1")
        journal.put("begin", n=0, attempt=2, step="t1")
    lines = list(status_lines(study))
    assert "complete" in lines[0]
    assert "replaces 1, at t1, 1 begun again" in lines[1]
    assert lines[2] == "1 of 16 participants are complete"
    assert lines[3] == f"go on: rune study run {tmp_path} --participant 3"
    assert lines[4].startswith("next: ")
    assert lines[4].endswith("--participant 2")
