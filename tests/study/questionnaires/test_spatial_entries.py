"""Directions and places are answered as they are shown, with keys and with the mouse."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.pose import Pose
from rune_study.errors import AnswersError
from rune_study.questionnaires.answers import Answers, read_answers
from rune_study.questionnaires.asking import QuestionnaireScreen
from rune_study.questionnaires.entries import entry_of
from rune_study.questionnaires.ground import Ground, picture_of
from rune_study.questionnaires.items import Answer, Bearing, Choice, NumberItem, PlaceItem
from rune_study.questionnaires.questionnaire import Questionnaire
from rune_study.questionnaires.spatial_entries import BearingEntry, PlaceEntry

WHERE = PlaceItem(id="where", text="Where is the robot?", truth="position")
ASKED = Questionnaire(
    name="q",
    title="Now",
    items=(WHERE, NumberItem(id="charge", text="How much?", most=100, truth="battery")),
)


def room(frame: Pose | None = None) -> Ground:
    """A room of 8 x 4 m with walls around and a wall across at x = 2, seen from a frame."""
    walls = np.zeros((40, 80), bool)
    walls[[0, -1]] = walls[:, [0, -1]] = walls[:, 20] = True
    return Ground(walls=walls, resolution=0.1, frame=frame or Pose())


@pytest.mark.parametrize("size", [(70, 15), (20, 5), (7, 3), (200, 60)])
def test_a_thin_wall_is_shown_at_any_size(size: tuple[int, int]) -> None:
    picture = picture_of(room(), *size)
    assert len(picture.lines) <= size[1]
    assert len(picture.lines[0]) <= size[0]
    column, _ = picture.character((2.05, 2.0))
    assert all(line[column] in "█▀▄" for line in picture.lines)
    assert any(" " in line for line in picture.lines) or size == (7, 3)


def test_the_ground_turns_with_the_frame() -> None:
    """A robot that started with its face to the north has the arena's north at the right."""
    picture = picture_of(room(Pose(x=1.0, y=1.0, theta=math.pi / 2)), 70, 40)
    _, line = picture.character((0.0, -1.05))
    assert set(picture.lines[line]) <= set("█▀▄")


@given(st.integers(0, 69), st.integers(0, 14))
def test_a_click_is_shown_where_it_was(column: int, line: int) -> None:
    picture = picture_of(room(), 70, 15)
    place = picture.place(column, line)
    inside = line < len(picture.lines) and column < len(picture.lines[0])
    assert (place is not None) == inside
    if place is not None:
        assert picture.character(place) == (column, line)


def test_arrows_begin_in_the_middle_and_stay_on_the_ground() -> None:
    entry = PlaceEntry(room())
    assert entry.press("enter", None) is None
    entry.press("up", None)
    assert entry.press("enter", None) == (4.0, 2.0)
    for _ in range(50):
        entry.press("shift+left", None)
        entry.press("down", None)
    assert entry.press("enter", None) == (0.0, 0.0)


def test_a_direction_on_the_map_is_shown_by_the_compass() -> None:
    entry = BearingEntry(Bearing(id="a", text="?", truth="heading"))
    assert "90" not in "".join(entry.lines())
    entry.press("right", None)
    assert "↑   0° by the compass" in "\n".join(entry.lines())
    entry.press("right", None)
    entry.press("down", None)
    assert entry.press("enter", None) == 74.0
    assert "16° by the compass" in "\n".join(entry.lines())


def test_a_place_without_ground_is_refused() -> None:
    with pytest.raises(AnswersError, match="where asks for a place, and there is no ground"):
        entry_of(WHERE)


def asked(
    path: Path, *steps: str | tuple[int, int], size: tuple[int, int] = (80, 24)
) -> tuple[str, dict[str, Answer | None]]:
    """What the screen shows after keys and clicks, and the answers."""

    async def run(answers: Answers) -> str:
        app = QuestionnaireScreen(ASKED, answers, "f1", "p", {("arena", 1): room()})
        async with app.run_test(size=size) as pilot:
            for step in steps:
                if isinstance(step, str):
                    await pilot.press(step)
                else:
                    await pilot.click(offset=step)
            await pilot.pause()
            return str(app.query_one("#item").render())

    with Answers(path) as answers:
        shown = asyncio.run(run(answers))
    return shown, {each.item: each.value for each in read_answers(path)}


def test_a_click_on_the_ground_answers(tmp_path: Path) -> None:
    shown, _ = asked(tmp_path / "a.log")
    lines = shown.splitlines()
    top = next(at for at, line in enumerate(lines) if "█" in line)
    first = (24 - len(lines)) // 2
    spot = (5 + 40, first + top + 3)
    shown, given = asked(tmp_path / "b.log", spot)
    assert "╋" in shown.splitlines()[top + 3]
    assert shown.splitlines()[top + 3].index("╋") == 40
    assert given == {}
    _, given = asked(tmp_path / "c.log", spot, "enter")
    place = given["where"]
    assert isinstance(place, tuple)
    assert place == pytest.approx(picture_of(room(), 70, 24 - 4 - 1 - 2).place(40, 3), abs=1e-3)


@pytest.mark.parametrize("spot", [(0, 0), (79, 23), (0, 12), (79, 12), (40, 0), (40, 23)])
def test_clicks_beside_the_ground_have_no_effect(tmp_path: Path, spot: tuple[int, int]) -> None:
    shown, given = asked(tmp_path / "a.log", spot, "enter")
    assert given == {}
    assert "╋" not in shown


def test_who_does_not_know_says_so_and_it_is_kept(tmp_path: Path) -> None:
    shown, given = asked(tmp_path / "a.log", "escape")
    assert given == {"where": None}
    assert "2 of 2" in shown
    shown, given = asked(tmp_path / "a.log", "5", "enter")
    assert given == {"where": None, "charge": 5.0}


def test_a_terminal_that_is_too_small_takes_no_answer(tmp_path: Path) -> None:
    for size in ((20, 5), (60, 30), (80, 6)):
        shown, given = asked(tmp_path / "a.log", "up", "enter", "escape", size=size)
        assert "make this" in shown
        assert given == {}


def test_a_resized_terminal_keeps_the_place(tmp_path: Path) -> None:
    async def run(answers: Answers) -> None:
        app = QuestionnaireScreen(ASKED, answers, "f1", "p", {("arena", 1): room()})
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.press("up", "right")
            for size in ((20, 5), (120, 40), (80, 24)):
                await pilot.resize_terminal(*size)
                await pilot.pause()
            await pilot.press("enter")

    with Answers(tmp_path / "a.log") as answers:
        asyncio.run(run(answers))
    (given,) = read_answers(tmp_path / "a.log")
    scale = picture_of(room(), 70, 17).scale
    assert given.value == pytest.approx((4.0 + scale, 2.0), abs=1e-3)


def test_a_choice_names_what_each_option_means() -> None:
    fit = Choice(id="a", text="?", options=("it goes", "not"), means=("yes", "no"))
    assert fit.right_answer("yes") == "it goes"
    assert Choice(id="a", text="?", options=("yes", "no"), truth="next_collision").fault() is None
    wrong = Choice(id="a", text="?", options=("yes", "maybe"), truth="next_collision").fault()
    assert wrong is not None
    assert "each of yes, no has to make one option right" in wrong[1]
