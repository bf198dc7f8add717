"""The experimenter's screen, its orders, and what blinds him."""

from __future__ import annotations

import stat
import tomllib
from pathlib import Path

from rune_study.plan.blinding import key_path, write_key
from rune_study.plan.steps import codes, plan
from rune_study.session.journal import Journal
from rune_study.session.orders import ORDERS, OrderBook, give_order
from rune_study.session.status import status_lines
from rune_study.session.watching import WatchScreen
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
    assert f"> t1 {step.code}" in shown
    assert "note calm" in shown
    assert "hri-a" not in shown
    assert [(each.do, each.text) for each in book.fresh()] == [
        ("begin", ""),
        ("note", "ok"),
        ("mark", ""),
    ]


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
    assert lines[3].endswith("--participant 2")
