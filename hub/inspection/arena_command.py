"""`rune-hub arena`: what an arena has in it, and its picture from above. No hub needs to run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from hub import files
from hub.command_line import ExitCode
from hub.command_output import print_error, put, put_json
from hub.inspection.output import table
from hub.inspection.png_file import png
from hub.sim.arena import arena_path, load_arena, shipped_arenas
from hub.sim.arena_file import read_arena_file
from hub.sim.arena_specs import ArenaSpec
from hub.sim.building import ground_under
from hub.sim.geometry import Side
from hub.sim.ground.height_field import HeightField
from hub.sim.top_view import draw_top_view
from hub.table_text import json_text

Row = tuple[str, str, float, float, float, str]
"""Kind, name, x, y, height [m], and what else is known."""


def list_all(*, as_json: bool) -> int:
    """Show the arenas that come with the hub."""
    for name in shipped_arenas():
        text = read_arena_file(arena_path(name)).description
        put(json_text({"name": name, "description": text}) if as_json else f"{name:<10} {text}")
    return 0


def show(name: str, output: Path | None, *, size: int, as_json: bool) -> int:
    """Show what is in an arena; write its picture.

    Args:
        name: A shipped arena, or an arena file.
        output: The PNG file; None: no picture.
        size: Length of the picture's longer side [px].
        as_json: Whether to write a line of JSON for each thing.

    Raises:
        ArenaError: There is no such arena, or its file has mistakes.
    """
    arena = load_arena(name)
    spec = read_arena_file(arena_path(name))
    rows = list(_things(spec, arena.ground))
    if as_json:
        keys = ("kind", "name", "x", "y", "height", "more")
        for row in rows:
            put_json(dict(zip(keys, row, strict=True)))
    else:
        put(f"{spec.name}: {spec.description}" if spec.description else spec.name)
        cells = [
            (kind, title, more, f"{x:.2f}", f"{y:.2f}", f"{height:.2f}")
            for kind, title, x, y, height, more in rows
        ]
        table(("WHAT", "NAME", "HOW", "X [m]", "Y [m]", "HEIGHT [m]"), cells, words=3)
    if output is not None:
        picture = draw_top_view(arena, [victim.at for victim in spec.victims], size)
        try:
            files.write_output(output, png(picture), sync=False)
        except OSError as error:
            print_error(f"{output} cannot be written: {error.strerror}")
            return ExitCode.FAULT
        if not as_json:
            put(f"{output}: {picture.shape[1]} by {picture.shape[0]} pixels, north is up")
    return 0


def _things(spec: ArenaSpec, ground: HeightField | None) -> Iterator[Row]:
    """What an operator looks for, and where robots start; victims in the order of their numbers."""
    height = 0.0 if ground is None else ground.height(*spec.start.at)
    yield "start", "", *spec.start.at, height, _heading(spec.start.heading)
    for berth in spec.berths:
        yield "berth", berth.robot, *berth.at, berth.height, _heading(berth.heading)
    for number, victim in enumerate(spec.victims, start=1):
        more = f"{victim.pose}, {_facing(victim.facing)}, counts {spec.scoring.weight:g}"
        yield f"victim {number}", victim.name, *victim.at, ground_under(victim, ground), more
    for landmark in spec.landmarks:
        height = ground_under(landmark, ground) + landmark.height
        yield "landmark", landmark.name, *landmark.at, height, _facing(landmark.facing)
    for ring in spec.rings:
        more = f"gap of {ring.gap_mm:g} mm {ring.gap}, {_facing(ring.facing)}"
        yield "ring", "", *ring.at, ground_under(ring, ground) + ring.height, more
    if spec.water is not None:
        more = f"type {spec.water.type}, visibility {spec.water.visibility:g} m"
        at = (0.0, 0.0) if spec.water.area is None else spec.water.area[0]
        yield "water", "", *at, spec.water.surface, more


def _heading(heading: float) -> str:
    return f"heading {math.degrees(heading):g} degrees"


def _facing(side: Side) -> str:
    return f"faces {side.name.lower()}"
