"""The report of a recording stands alone and names what happened."""

from __future__ import annotations

import base64
import io
import re
from contextlib import closing
from functools import partial
from pathlib import Path

from PIL import Image

from hub.plain_text import is_plain
from rune_tui.replay.console_log import ConsoleLog
from rune_tui.replay.mission_page import mission_page
from rune_tui.replay.player import Player
from rune_tui.replay.source import EventKind, ReplayEvent
from tests.console.replay.logged_session import logged_session


def test_a_report_has_the_robots_way_and_pictures_of_begin_and_end(tmp_path: Path) -> None:
    session = logged_session(tmp_path, 5)
    shares: list[float] = []
    with closing(Player(partial(ConsoleLog, session))) as player:
        page = mission_page(player, shares.append)
        robots = list(player.frame.state.robots) if player.frame is not None else []
    assert shares[-1] == 1.0
    for name in robots:
        assert f"<h3>{name}</h3>" in page
    assert re.search(r"about \d+\.\d m driven", page)
    assert "0:00:00: The begin" in page
    assert "The end" in page
    codes = re.findall(r'<img alt="" src="data:image/png;base64,([^"]+)">', page)
    assert len(codes) >= 2
    sizes = {Image.open(io.BytesIO(base64.b64decode(code))).size for code in codes}
    assert len(sizes) == 1
    assert "http://" not in page.replace("http://www.w3.org/2000/svg", "")
    assert "<script" not in page


def test_a_report_says_what_was_wrong_and_for_how_long(tmp_path: Path) -> None:
    session = logged_session(tmp_path, 12, silent=4.0)
    note = ReplayEvent(stamp=0, kind=EventKind.NOTE, text="<look>")
    with closing(Player(partial(ConsoleLog, session))) as player:
        page = mission_page(player, lambda _: None, [note])
    wrong = page.partition("What went wrong")[2].partition("<h2>")[0]
    (row,) = re.findall(r"<tr><td>(0:00:0[4-7])</td><td>0:00:1[01]</td><td>(\d) s</td>", wrong)
    assert 4 <= int(row[1]) <= 8
    assert "<td>alarm</td>" in wrong
    assert "&lt;look&gt;" in page


def test_a_report_leaves_out_what_lacked_in_the_first_second_only(tmp_path: Path) -> None:
    for connects in (0.5, 3.0):
        folder = tmp_path / str(connects)
        folder.mkdir()
        session = logged_session(folder, 6, connects=connects)
        with closing(Player(partial(ConsoleLog, session))) as player:
            page = mission_page(player, lambda _: None)
        wrong = page.partition("What went wrong")[2].partition("<h2>")[0]
        assert ("connecting" in wrong) == (connects > 1.0)


def test_a_report_spells_control_characters_out(tmp_path: Path) -> None:
    session = logged_session(tmp_path, 2)
    odd = session.rename(tmp_path / "a\x1b]0;b\x07\u202ec.mcap")
    note = ReplayEvent(stamp=0, kind=EventKind.NOTE, text="\x1b[31m\u202e<look>", robot="r\x9b1m")
    with closing(Player(partial(ConsoleLog, odd))) as player:
        page = mission_page(player, lambda _: None, [note])
    assert is_plain(page, lines=True)
    assert r"What happened: a\x1b]0;b\x07\u202ec.mcap" in page
    assert r"<td>r\x9b1m</td><td>\x1b[31m\u202e&lt;look&gt;</td>" in page
