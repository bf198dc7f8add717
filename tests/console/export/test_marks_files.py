"""What operators take home: marks as a table, as GeoJSON, and as a page with the map."""

from __future__ import annotations

import base64
import csv
import io
import json
import math
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hub.gcm.mapping import InterestPoint, PointKind
from hub.gcm.occupancy_map import OccupancyMap
from hub.missions.point_file import decode_points
from hub.plain_text import plain
from hub.table_text import text_of_cell
from rune_tui.export.points import COLUMNS, csv_table, geojson, moment
from rune_tui.export.report import html_page
from rune_tui.raster.thumbnail import thumbnail
from tests.support.cases import for_each

JPEG = thumbnail(np.full((40, 40, 3), 200, np.uint8), (0.5, 0.5))
UNSURE = {"kind": PointKind.LANDMARK, "uncertainty": math.nan, "distance": math.nan}
NASTY = '<script>alert(1)</script> & "quotes", =cmd()\nline'


def point(number: int = 1, **changes: object) -> InterestPoint:
    values: dict[str, object] = {
        "kind": PointKind.VICTIM,
        "x": 1.5,
        "y": -2.25,
        "uncertainty": 0.125,
        "distance": 2.5,
        "stamp": 1_111_111_111.0,
        "by": "jane",
        "note": "warm",
        "thumbnail": JPEG,
    }
    return InterestPoint(number=number, **values | changes)  # type: ignore[arg-type]


def grid() -> OccupancyMap:
    cells = np.full((20, 30), -1, np.int8)
    cells[5:10, 5:20] = 0
    cells[5, 5:20] = 100
    return OccupancyMap(cells=cells, resolution=0.1, origin_x=-1.0, origin_y=-2.0)


def rows(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text, newline="")))


def test_the_table_has_a_line_for_each_mark():
    head, first, second = rows(csv_table([point(), point(2, **UNSURE)]))
    assert tuple(head) == COLUMNS
    assert first[:6] == ["1", "victim", "1.500", "-2.250", "0.125", "2.500"]
    assert first[6:] == ["2005-03-18T01:58:31Z", "jane", "warm"]
    assert second[:2] == ["2", "landmark"]
    assert dict(zip(head, second, strict=True))["uncertainty_m"] == ""
    assert dict(zip(head, second, strict=True))["distance_m"] == ""


@given(note=st.text(max_size=40), by=st.text(max_size=20))
def test_the_table_keeps_all_words_and_no_spreadsheet_computes_them(note: str, by: str):
    line = rows(csv_table([point(note=note, by=by)]))[1]
    for written, said in zip(line[7:], (by, note), strict=True):
        assert text_of_cell(written) == plain(said, lines=True)
        assert not written.startswith(("=", "+", "-", "@", "\t", "\r"))


def test_a_hub_reads_the_geojson_back():
    points = (point(3, note=NASTY), point(7, **UNSURE, thumbnail=JPEG[:0]))
    found = decode_points(geojson(points, "magellan").encode())
    for mark, read in zip(points, found, strict=True):
        assert (mark.number, mark.kind, mark.x, mark.y) == (read.number, read.kind, read.x, read.y)
        assert (mark.stamp, mark.by, mark.note) == (read.stamp, read.by, read.note)
        for said, kept in ((mark.uncertainty, read.uncertainty), (mark.distance, read.distance)):
            assert said == kept or (math.isnan(said) and math.isnan(kept))
        assert mark.thumbnail.tobytes() == read.thumbnail.tobytes()


def test_what_is_nowhere_is_in_no_drawing():
    lost = point(x=math.nan)
    assert json.loads(geojson([lost, point(2)], "m"))["features"][0]["properties"]["number"] == 2
    assert "<circle" not in html_page("m", [lost], None, "now")


@for_each("stamp", [math.nan, math.inf, 1e300, -1e300])
def test_a_time_that_is_none_is_left_empty(stamp: float):
    assert moment(stamp) == ""


class Page(HTMLParser):
    """Tags of a page that loads nothing, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.words = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name in {"src", "href"}:
                assert (value or "").startswith("data:image/")

    def handle_data(self, data: str) -> None:
        self.words += data


def test_words_of_a_mark_stay_words_on_the_page():
    page = Page(html_page(NASTY, [point(note=NASTY, by=NASTY)], grid(), "today"))
    assert "script" not in page.tags
    assert page.words.count(NASTY) == 4  # title, heading, by, note


def test_the_page_says_how_sure_a_mark_is_and_nothing_where_that_is_not_known():
    page = html_page("magellan", [point(), point(2, **UNSURE)], None, "today")
    first, second = re.findall(r"<tr><td.*?</tr>", page, re.DOTALL)
    assert '<td class="number">0.12</td><td class="number">2.5</td>' in first
    assert '<td class="number"></td><td class="number"></td>' in second
    assert "nan" not in second


def test_the_page_shows_the_map_the_marks_where_they_are_and_their_pictures():
    page = html_page("magellan", [point(), point(2, kind=PointKind.LANDMARK)], grid(), "today")
    assert "Victims: 1, landmarks: 1" in page
    (drawing,) = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    root = ElementTree.fromstring(drawing)
    names = [element.tag.rpartition("}")[2] for element in root]
    assert names == ["image", "circle", "text", "rect", "text"]
    image, circle = root[0], root[1]
    # y of a drawing grows downwards: the map's upper edge is at -(-2 + 20 * 0.1) = 0.
    assert [float(image.get(key, "")) for key in ("x", "y", "width", "height")] == [-1, 0, 3, 2]
    assert (float(circle.get("cx", "")), float(circle.get("cy", ""))) == (1.5, 2.25)
    raw = base64.b64decode(image.get("href", "").partition(",")[2])
    shown = np.asarray(Image.open(io.BytesIO(raw)))
    assert shown.shape == (20, 30)
    assert shown[14, 10] == 0  # the wall in row 5 from below
    assert shown[13, 10] == 255
    assert page.count("data:image/jpeg;base64,") == 2


@pytest.mark.parametrize(
    "known",
    [
        None,
        OccupancyMap(cells=np.empty((0, 0), np.int8), resolution=0.1, origin_x=0.0, origin_y=0.0),
    ],
)
def test_a_page_can_be_made_without_a_map_and_without_marks(known: OccupancyMap | None):
    assert "Victims: 0" in html_page("magellan", [], known, "today")
