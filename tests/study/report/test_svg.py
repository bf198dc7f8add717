"""Pictures are well-formed, and have their data where the axes say."""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rune_study.report.svg import Axis, Chart

SVG = "{http://www.w3.org/2000/svg}"


def parsed(chart: Chart, title: str = "Data") -> ElementTree.Element:
    return ElementTree.fromstring(chart.svg(title))


def test_long_names_of_an_axis_are_not_cut() -> None:
    name = "robobot-2003-expanded - robobot-2004"
    chart = Chart(Axis("s", 0.0, 1.0), Axis.of_names("", [name]))
    label = next(each for each in parsed(chart).iter(f"{SVG}text") if each.text == name)
    assert float(label.get("x", "0")) > 5.5 * len(name)


@given(values=st.lists(st.floats(-1e6, 1e6), min_size=1))
def test_ticks_are_round_few_and_inside(values: list[float]) -> None:
    axis = Axis.around("time [s]", values)
    ticks = axis.ticks()
    assert axis.least <= min(values) <= max(values) <= axis.most
    assert 1 <= len(ticks) <= 8
    slack = (axis.most - axis.least) * 1e-6
    assert all(axis.least - slack <= value <= axis.most + slack for value, _ in ticks)


def test_values_that_are_no_numbers_leave_no_shape() -> None:
    chart = Chart(Axis("x", 0, 10), Axis("y", 0, 10))
    chart.dot(math.nan, 1, "#000")
    chart.line([(0, 0), (1, 1), (math.nan, 2), (3, 3)], "#000")
    chart.interval_up(1, math.nan, 3, "#000")
    tree = parsed(chart)
    assert tree.findall(f"{SVG}circle") == []
    (line,) = tree.findall(f"{SVG}polyline")
    assert len(line.attrib["points"].split()) == 2


def test_an_open_interval_ends_at_the_edge() -> None:
    chart = Chart(Axis("x", 0, 10), Axis("y", 0, 1), width=480)
    chart.interval_across(5, math.inf, 0.5, "#000")
    (line,) = parsed(chart).findall(f"{SVG}polyline")
    assert line.attrib["points"].split()[1].startswith("468.0,")


def test_points_are_in_proportion() -> None:
    chart = Chart(Axis("x", 0, 10), Axis("y", 0, 10))
    for value in (2, 4, 6):
        chart.dot(value, value, "#000")
    first, middle, last = parsed(chart).findall(f"{SVG}circle")
    for name, sign in (("cx", 1), ("cy", -1)):
        steps = [
            float(b.attrib[name]) - float(a.attrib[name])
            for a, b in ((first, middle), (middle, last))
        ]
        assert steps[0] == pytest.approx(steps[1], abs=0.2)
        assert sign * steps[0] > 0


def test_words_of_others_stay_words() -> None:
    chart = Chart(Axis("<x> & [s]", 0, 1), Axis.of_names("condition", ["<script>", "B"]))
    chart.dot(0.5, 0, "#000", title="p07 & <b>")
    text = chart.svg("a < b")
    assert ElementTree.fromstring(text) is not None
    assert not re.search("<script>|<b>", text)
