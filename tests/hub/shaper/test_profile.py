"""Profiles of links: those that come with the hub, own ones, and their mistakes."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub import toml_reader as toml
from hub.errors import LinkProfileError
from hub.shaper.profile import check_profile, load_profile, shipped_profiles
from tests.support.cases import for_each

OF_THE_LITERATURE = [  # name, round trip, its jitter [s], loss, mean burst, rate [bit/s]
    ("lan", 0.001, 0.0, 0.0, 1.0, 100e6),
    ("wifi-good", 0.020, 0.005, 0.001, 1.0, 5e6),
    ("wifi-edge", 0.060, 0.020, 0.02, 3.0, 1e6),
    ("threshold", 0.250, 0.030, 0.01, 2.0, 1e6),
    ("rubble", 0.500, 0.100, 0.05, 4.0, 256e3),
    ("dropouts", 0.060, 0.0, 0.0, 1.0, 1e6),
    ("drc", 0.100, 0.0, 0.0, 1.0, 9600.0),
]


@for_each(("name", "round_trip", "jitter", "loss", "burst", "rate"), OF_THE_LITERATURE)
def test_shipped_profiles_have_the_numbers_of_the_literature(
    name: str, round_trip: float, jitter: float, loss: float, burst: float, rate: float
) -> None:
    made = load_profile(name)
    assert (made.name, made.round_trip) == (name, pytest.approx(round_trip))
    assert made.jitter == pytest.approx(jitter, abs=1e-4)
    for way in (made.up, made.down):
        assert (way.loss, way.burst, way.rate) == pytest.approx((loss, burst, rate))


def test_every_shipped_profile_can_be_read() -> None:
    made = [load_profile(name) for name in shipped_profiles()]
    assert all(each.purpose and len(each.digest) == 64 for each in made)
    rates = {each.name: each.picture_rate for each in made if each.picture_rate}
    assert rates == {"fps-2": 2.0, "fps-5": 5.0, "fps-10": 10.0, "fps-15": 15.0}
    assert load_profile("dropouts").blackouts is not None
    bursts = load_profile("drc").bursts
    assert bursts is not None
    assert bursts.rate == 300e6


def test_directions_differ_where_the_file_says_so(tmp_path: Path) -> None:
    path = tmp_path / "far.toml"
    path.write_text("delay_ms = 20\nrate_kbit = 100\n[up]\ndelay_ms = 200\n")
    made = load_profile(str(path))
    assert (made.up.delay, made.down.delay) == (0.2, 0.02)
    assert (made.up.rate, made.down.rate) == (100e3, 100e3)
    assert made.name == "far"


def test_all_mistakes_of_a_file_come_together(tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(
        'delay_ms = -1\nlos = 0.1\nburst = "long"\n[down]\nrate_kbit = 0\n'
        "[blackouts]\ngap_s = [5, 2]\n[bursts]\ngap_s = [1, 2]\nlength_s = [1, 1]\n"
    )
    with pytest.raises(LinkProfileError) as raised:
        load_profile(str(path))
    text = "\n".join(raised.value.problems)
    for part in ("delay_ms", "'los'", "burst", "rate_kbit", "gap_s", "'length_s' is missing"):
        assert part in text
    assert len(raised.value.problems) == 7
    assert "bad.toml:1:" in str(raised.value)


@for_each(
    ("content", "part"),
    [
        ("delay_ms = 10\njitter_ms = 21\n", "more than twice"),
        ("loss = 0.9\nburst = 2\n", "too short for loss"),
        ("delay_ms = nan\n", "nan"),
        ("[up]\nloss = 2\n", "between 0 and 0.9"),
        ("up = 3\n", "not a table"),
        ("blackouts = []\n", "not a table"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path: Path, content: str, part: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(content)
    with pytest.raises(LinkProfileError, match=part):
        load_profile(str(path))


def test_an_unknown_profile_names_those_that_there_are() -> None:
    with pytest.raises(LinkProfileError, match=r"did you mean 'rubble'.*wifi-good"):
        load_profile("ruble")
    with pytest.raises(LinkProfileError, match="cannot be read"):
        load_profile("/no/such/link.toml")


_ANY = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)
_KEYS = st.sampled_from(
    ["delay_ms", "jitter_ms", "loss", "burst", "rate_kbit", "queue_bytes", "gap_s", "length_s"]
)
_TABLES = st.sampled_from(["up", "down", "blackouts", "bursts", "delay_ms", "loss", "purpose", "x"])


@given(st.dictionaries(_TABLES, st.dictionaries(_KEYS, _ANY) | _ANY, max_size=4))
def test_any_content_gives_a_profile_or_mistakes(content: dict[str, object]) -> None:
    problems = toml.Problems()
    made = check_profile(content, problems)
    if not problems:
        assert made.up.rate > 0.0 <= made.down.delay
