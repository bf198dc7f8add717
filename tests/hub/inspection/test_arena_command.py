"""`rune-hub arena`, as a person types it, and the pictures of arenas on the page."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hub.command_line import ExitCode
from hub.inspection.png_file import png
from hub.sim.arena import arena_path, load_arena, shipped_arenas
from hub.sim.arena_file import read_arena_file
from hub.sim.top_view import draw_top_view
from tests.support.command_line import rune_hub

DOCS = Path(__file__).parents[3] / "docs"


def pixels_of(content: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(content)) as picture:
        assert picture.mode == "RGB"
        return np.asarray(picture)


@given(height=st.integers(1, 9), width=st.integers(1, 9), seed=st.integers(0, 99))
def test_a_png_file_holds_the_picture(height: int, width: int, seed: int) -> None:
    drawn = np.random.default_rng(seed).integers(0, 256, (height, width, 3)).astype(np.uint8)
    assert np.array_equal(pixels_of(png(drawn)), drawn)


def test_it_lists_the_shipped_arenas() -> None:
    done = rune_hub("arena")
    assert (done.returncode, done.stderr) == (ExitCode.OK, "")
    assert [line.split()[0] for line in done.stdout.splitlines()] == list(shipped_arenas())
    listed = [json.loads(line) for line in rune_hub("arena", "--json").stdout.splitlines()]
    assert [each["name"] for each in listed] == list(shipped_arenas())


def test_it_shows_what_is_in_an_arena_and_draws_it(tmp_path: Path) -> None:
    path = tmp_path / "pool.png"
    done = rune_hub("arena", "pool", "-o", str(path), "--size", "200")
    assert (done.returncode, done.stderr) == (ExitCode.OK, "")
    for part in ("victim 3  crates  lying, faces north", "berth     rov", "visibility 12 m"):
        assert part in done.stdout
    assert "157 by 200 pixels" in done.stdout
    assert pixels_of(path.read_bytes()).shape == (200, 157, 3)


def test_json_has_a_line_for_each_thing() -> None:
    lines = rune_hub("arena", "yellow", "--json").stdout.splitlines()
    things = [json.loads(line) for line in lines]
    spec = read_arena_file(arena_path("yellow"))
    assert len(things) == 1 + len(spec.victims) + len(spec.landmarks) + len(spec.rings)
    assert things[1] == {
        "kind": "victim 1",
        "name": "office",
        "x": 1.4,
        "y": 2.55,
        "height": 0.0,
        "more": "sitting, faces south, counts 0.5",
    }


def test_heights_are_those_on_the_ground_or_the_deck() -> None:
    lines = rune_hub("arena", "orange", "--json").stdout.splitlines()
    things = [json.loads(line) for line in lines]
    victims = {each["name"]: each["height"] for each in things if "victim" in each["kind"]}
    assert victims["under the deck"] == 0.0
    assert abs(victims["on the deck"] - 0.96) < 1e-6
    (sign,) = [each for each in things if each["name"] == "blue"]
    assert abs(sign["height"] - 1.36) < 1e-6


def test_mistakes_are_one_sentence(tmp_path: Path) -> None:
    for words, code, text in (
        (("pol",), ExitCode.USAGE, "did you mean 'pool'?"),
        (("pool", "-o", "pool.jpg"), ExitCode.USAGE, "'pool.jpg' does not end in .png"),
        (("pool", "--size", "9"), ExitCode.USAGE, "number of pixels from 64 to 4096"),
        (("pool", "-o", f"{tmp_path}/no/pool.png"), ExitCode.FAULT, "pool.png cannot be written"),
    ):
        done = rune_hub("arena", *words)
        assert done.returncode == code
        assert text in done.stderr
        assert len(done.stderr.splitlines()) == 1


def test_the_page_has_a_picture_of_each_shipped_arena() -> None:
    """After a wanted change, draw them again: RUNE_WRITE_SNAPSHOTS=1 pytest with this file."""
    page = (DOCS / "writing-an-arena.md").read_text()
    for name in shipped_arenas():
        path = DOCS / "images" / f"arena-{name}.png"
        spec = read_arena_file(arena_path(name))
        drawn = draw_top_view(load_arena(name), [victim.at for victim in spec.victims])
        if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
            path.write_bytes(png(drawn))
        shown = pixels_of(path.read_bytes())
        assert shown.shape == drawn.shape, f"{path.name} is out of date"
        # Rounding differs from machine to machine.
        assert np.abs(shown.astype(int) - drawn).mean() < 0.2, f"{path.name} is out of date"
        assert f"(images/arena-{name}.png)" in page
