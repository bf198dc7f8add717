"""Interest points: marked, replaced, removed, within bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hub.errors import MissionError
from hub.gcm.mapping import INTEREST_POINTS, InterestPoint, InterestPoints, PointKind
from hub.missions.points import (
    MAX_BY,
    MAX_NOTE,
    MAX_NUMBER,
    MAX_POINTS,
    MAX_THUMBNAIL_BYTES,
    NO_THUMBNAIL,
    PointBook,
)
from tests.support.cases import for_each

NOW = 1e9


def point(number: int = 0, x: float = 1.0, **fields: object) -> InterestPoint:
    thumbnail = fields.pop("thumbnail", NO_THUMBNAIL)
    assert isinstance(thumbnail, np.ndarray)
    return InterestPoint(
        number=number, kind=PointKind.VICTIM, x=x, y=2.0,
        thumbnail=thumbnail, **fields,  # type: ignore[arg-type]
    )  # fmt: skip


def test_a_point_gets_a_number_a_time_and_who_marked_it() -> None:
    book = PointBook()
    assert book.mark(point(), "console", NOW) == ""
    (kept,) = book.points
    assert (kept.number, kept.stamp, kept.by) == (1, NOW, "console")


def test_what_the_point_says_itself_is_kept() -> None:
    book = PointBook()
    picture = np.arange(50, dtype=np.uint8)
    said = point(uncertainty=0.2, distance=2.5, stamp=5.0, by="Ada", note="waves",
                 thumbnail=picture)  # fmt: skip
    book.mark(said, "console", NOW)
    (kept,) = book.points
    assert (kept.uncertainty, kept.distance) == (0.2, 2.5)
    assert (kept.number, kept.stamp, kept.by, kept.note) == (1, 5.0, "Ada", "waves")
    assert np.array_equal(kept.thumbnail, picture)


def test_a_known_number_replaces_its_point_and_others_stay() -> None:
    book = PointBook()
    for x in (1.0, 2.0):
        book.mark(point(x=x), "", NOW)
    assert book.mark(point(1, x=9.0, version=1), "", NOW) == ""
    known = [(kept.number, kept.x, kept.version) for kept in book.points]
    assert known == [(1, 9.0, 2), (2, 2.0, 1)]


def test_two_who_change_a_point_do_not_overwrite_each_other() -> None:
    book = PointBook()
    book.mark(point(note="found"), "", NOW)
    assert book.mark(point(1, note="Ada's", version=1), "", NOW) == ""
    assert "changed meanwhile" in book.mark(point(1, note="Bob's", version=1), "", NOW)
    with pytest.raises(MissionError, match="changed meanwhile"):
        book.check_removal(1, 1)
    assert [kept.note for kept in book.points] == ["Ada's"]
    assert "no point 2" in book.mark(point(2, version=1), "", NOW)


def test_numbers_of_removed_points_are_not_given_again() -> None:
    book = PointBook()
    book.mark(point(), "", NOW)
    book.check_removal(1, 0)
    book.drop(1)
    with pytest.raises(MissionError, match="there is no point 1"):
        book.check_removal(1, 0)
    book.mark(point(), "", NOW)
    assert [kept.number for kept in book.points] == [2]


@pytest.mark.parametrize("x", [math.nan, math.inf, -1e6])
def test_a_point_that_is_nowhere_is_refused(x: float) -> None:
    book = PointBook()
    assert "nowhere" in book.mark(point(x=x), "", NOW)
    assert not book.points


def test_a_mark_is_never_lost_for_being_too_wordy() -> None:
    book = PointBook()
    large = np.zeros(MAX_THUMBNAIL_BYTES + 1, np.uint8)
    said = point(note="n" * 9999, by="b" * 999, thumbnail=large, stamp=math.nan)
    assert book.mark(said, "", NOW) == ""
    (kept,) = book.points
    assert (len(kept.note), len(kept.by), kept.thumbnail.size, kept.stamp) == (
        MAX_NOTE,
        MAX_BY,
        0,
        NOW,
    )


@for_each("metres", [math.inf, -math.inf, -0.1, 0.0, 1e6])
def test_an_uncertainty_or_distance_that_cannot_be_is_not_known(metres: float) -> None:
    book = PointBook()
    assert book.mark(point(uncertainty=metres, distance=2.5), "", NOW) == ""
    assert book.mark(point(uncertainty=0.2, distance=metres), "", NOW) == ""
    first, second = book.points
    assert math.isnan(first.uncertainty)
    assert first.distance == 2.5
    assert second.uncertainty == 0.2
    assert math.isnan(second.distance)


def test_there_is_room_for_so_many_points_and_all_of_them_can_be_sent() -> None:
    book = PointBook()
    picture = np.zeros(MAX_THUMBNAIL_BYTES, np.uint8)
    full = point(note="ü" * MAX_NOTE, by="ü" * MAX_BY, thumbnail=picture)
    for _ in range(MAX_POINTS):
        assert book.mark(full, "", NOW) == ""
    assert "already" in book.mark(full, "", NOW)
    assert book.mark(point(3, x=5.0, version=1), "", NOW) == ""
    assert len(book.points) == MAX_POINTS
    assert len(INTEREST_POINTS.encode(InterestPoints(points=book.points))) < 1_000_000


def test_when_the_numbers_end_known_ones_can_still_be_replaced() -> None:
    book = PointBook()
    book.put(point(MAX_NUMBER, version=1))
    assert "no numbers" in book.mark(point(), "", NOW)
    assert book.mark(point(MAX_NUMBER, x=3.0, version=1), "", NOW) == ""


def test_points_of_an_earlier_sheet_stay_known_and_their_numbers_are_not_given_again() -> None:
    book = PointBook()
    book.mark(point(), "", NOW)
    book.begin_sheet(1)
    assert not book.points
    assert book.mark(point(), "", NOW) == ""
    assert [kept.number for kept in book.points] == [2]
    assert book.earlier[1][0] == 1
    assert "on sheet 1" in book.mark(point(1, version=1), "", NOW)
