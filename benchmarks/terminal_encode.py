"""What a frame costs on its way to the terminal, in time and in bytes; 160 x 48 cells.

All that draw half blocks take turns with the same frames, so that what else the machine does
harms them alike; times are CPU times, medians. How good a picture is that was sent with fewer
bytes is measured on a terminal that has eaten them.
"""

from __future__ import annotations

import json
import math
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from statistics import mean, median

import numpy as np
from PIL import Image

from benchmarks.camera_scenes import (
    COLUMNS,
    FRAMES,
    ROWS,
    fixed,
    fixed_frames,
    panning,
    panning_frames,
    photo,
    photo_frames,
    seen,
    seen_in_quadrants,
    static,
)
from benchmarks.figures import report, say
from benchmarks.peers.contest import PEERS_PYTHON, ROOT
from benchmarks.peers.terminal_programs import Played, played_by_mpv, played_by_timg
from rune_tui.compositor.cells import Cells
from rune_tui.compositor.looks import looks_of
from rune_tui.compositor.quality import EXACT, Quality
from rune_tui.compositor.screen_encoder import ScreenEncoder
from rune_tui.compositor.seen_pictures import SeenPicture
from tests.console.compositor.terminal_model import Terminal

GOOD = Quality(tolerance=8, threshold=10)
ROUNDS, IN_A_ROW = 6, 10
WAKING_UP = 3
"""Frames in a row that are not counted: others have had the processor and its caches."""
_MISSING = "run `make bench-peers bench-notcurses`"


@dataclass(frozen=True, slots=True)
class Costs:
    """What frames of one scene cost one renderer: CPU time [ms] and bytes of each."""

    milliseconds: list[float] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)

    def add(self, milliseconds: float, size: int) -> None:
        self.milliseconds.append(milliseconds)
        self.sizes.append(size)

    @property
    def typical_ms(self) -> float:
        return median(self.milliseconds)

    @property
    def mean_kb(self) -> float:
        return mean(self.sizes) / 1e3


Frame = tuple[Cells, tuple[SeenPicture, ...]]
"""Cells, and the pictures in them that have more pixels."""
Draw = Callable[[str, int], tuple[float, int]]
"""Draws a frame of a scene, by its number; CPU time [ms] and bytes."""


class Ours:
    """The encoder over all scenes, each on a terminal of its own."""

    def __init__(self, scenes: Mapping[str, list[Frame]], quality: Quality) -> None:
        self._scenes, self._quality = scenes, quality
        self._encoders = {scene: ScreenEncoder() for scene in scenes}

    def draw(self, scene: str, number: int) -> tuple[float, int]:
        frame, encoder = self._scenes[scene][number], self._encoders[scene]
        start = time.process_time()
        encoded = encoder.encode(looks_of(*frame), self._quality)
        return (time.process_time() - start) * 1e3, len(encoded)


def without_pictures(frames: list[Cells]) -> list[Frame]:
    """The same frames, as cells without pictures."""
    return [(cells, ()) for cells in frames]


def plain_python(cells: Cells) -> str:
    """The same picture as one writes it first: a loop over cells with f-strings."""
    lines = []
    for upper, lower in zip(cells.pixels[0::2].tolist(), cells.pixels[1::2].tolist(), strict=True):
        parts = [
            f"\x1b[38;2;{a[0]};{a[1]};{a[2]};48;2;{b[0]};{b[1]};{b[2]}m▀"
            for a, b in zip(upper, lower, strict=True)
        ]
        lines.append("".join(parts) + "\x1b[0m\n")
    return "".join(lines)


@contextmanager
def libraries(folder: Path) -> Iterator[dict[str, Draw]]:
    """Renderers in the peers' own environment, by name and version."""
    if not PEERS_PYTHON.exists():
        say(f"peers are not installed; {_MISSING}")
        yield {}
        return
    command = [str(PEERS_PYTHON), "-m", "benchmarks.peers.terminal_renderers"]
    arguments = [str(folder), str(COLUMNS), str(ROWS)]
    with subprocess.Popen(
        command + arguments,
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        inlet, outlet = process.stdin, process.stdout
        there = json.loads(outlet.readline())
        for name, why in there["missing"].items():
            say(f"{name} cannot be measured: {why}; {_MISSING}")

        def drawer(name: str) -> Draw:
            def draw(scene: str, number: int) -> tuple[float, int]:
                inlet.write(f"{name} {scene} {number}\n")
                inlet.flush()
                milliseconds, size = outlet.readline().split()
                return float(milliseconds), int(size)

            return draw

        yield {f"{name} {known}": drawer(name) for name, known in there["versions"].items()}
        inlet.close()


def contest(contenders: Mapping[str, Draw], scene: str, rounds: int = ROUNDS) -> dict[str, Costs]:
    """What a scene costs each, in turns."""
    costs: dict[str, Costs] = defaultdict(Costs)
    for turn in range(rounds):
        for name, draw in contenders.items():
            for number in range(IN_A_ROW):
                cost = draw(scene, (IN_A_ROW * turn + number) % FRAMES)
                if number >= WAKING_UP:
                    costs[name].add(*cost)
    return costs


def quality_of(
    frames: list[Frame], quality: Quality, pictures: list[np.ndarray] | None = None
) -> tuple[float, float]:
    """Kilobytes a frame after the first, and what the terminal then shows of it [dB].

    Args:
        frames: What is drawn.
        quality: How exactly.
        pictures: What it should look like, shape (4 * rows, 2 * columns, 3) each; as it is drawn
            with two pixels a cell, if None.
    """
    encoder, terminal = ScreenEncoder(), Terminal(COLUMNS, ROWS)
    sizes, errors = [], []
    for number, (cells, seen_pictures) in enumerate(frames):
        encoded = encoder.encode(looks_of(cells, seen_pictures), quality)
        terminal.feed(encoded.decode())
        marks = np.array([terminal.marks[place].quarters for place in np.ndindex(ROWS, COLUMNS)])
        shown = marks.reshape(ROWS, COLUMNS, 2, 2, 3).transpose(0, 2, 1, 3, 4)
        shown = shown.reshape(2 * ROWS, 2 * COLUMNS, 3).repeat(2, axis=0)
        wanted = cells.pixels[..., :3].repeat(2, axis=0).repeat(2, axis=1)
        if pictures is not None:
            wanted = pictures[number]
        sizes.append(len(encoded))
        errors.append(np.square(shown - wanted.astype(float)).mean())
    error = mean(errors[1:])
    return mean(sizes[1:]) / 1e3, 10.0 * math.log10(255.0**2 / error) if error else math.inf


def programs(folder: Path, scene: str) -> dict[str, Played]:
    """What programs that are installed take for a scene."""
    players = {"timg": played_by_timg, "mpv --vo=tct": played_by_mpv}
    played = {name: play(folder / scene, COLUMNS, ROWS, FRAMES) for name, play in players.items()}
    return {name: cost for name, cost in played.items() if cost is not None}


def main() -> None:
    say("making scenes")
    scenes = {"pan": panning(), "photo": photo(), "static": static(), "fixed": fixed()}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for scene, frames in scenes.items():
            (folder / scene).write_bytes(b"".join(f.pixels[..., :3].tobytes() for f in frames))
        with libraries(folder) as others:
            report_times(scenes, others, folder)
            report_bytes(scenes, others, folder)
    report_quadrants()


def report_times(
    scenes: Mapping[str, list[Cells]], others: Mapping[str, Draw], folder: Path
) -> None:
    def naive(scene: str, number: int) -> tuple[float, int]:
        start = time.process_time()
        drawn = plain_python(scenes[scene][number])
        return (time.process_time() - start) * 1e3, len(drawn.encode())

    frames = {scene: without_pictures(cells) for scene, cells in scenes.items()}
    exact, good = Ours(frames, EXACT), Ours(frames, GOOD)
    say(f"{ROUNDS} rounds of a panning camera")
    contenders = {"exact": exact.draw, "good": good.draw, "f-strings (Python)": naive, **others}
    costs = contest(contenders, "pan")
    ours, lossy = costs.pop("exact"), costs.pop("good")
    played = programs(folder, "pan")
    times = {name: cost.typical_ms for name, cost in costs.items()}
    times |= {name: cost.milliseconds for name, cost in played.items()}
    rounded = {name: round(value, 2) for name, value in times.items()}
    note = f"{ours.mean_kb:.0f} kB a frame; nothing is left out but what the terminal has"
    report("terminal.exact_ms", ours.typical_ms, "ms", bar=0.9, peers=rounded, note=note)
    note = f"{lossy.mean_kb:.0f} kB a frame"
    report("terminal.good_ms", lossy.typical_ms, "ms", peers=rounded, note=note)
    for peer, bar in (("chafa.py", 15), ("rich-pixels", 100), ("textual-image", 100)):
        taken = [value for name, value in times.items() if name.startswith(peer)]
        report(
            f"terminal.exact_vs_{peer.removesuffix('.py').replace('-', '_')}",
            taken[0] / ours.typical_ms if taken else None,
            "times faster",
            bar=bar,
            better="higher",
            note="" if taken else f"{peer} is not installed; {_MISSING}",
        )
    rivals = {name: value for name, value in times.items() if name.startswith("notcurses")}
    report(
        "terminal.exact_vs_notcurses",
        ours.typical_ms / min(rivals.values()) if rivals else None,
        "times its time",
        bar=1.5,
        note=", ".join(rivals) or f"notcurses is not installed; {_MISSING}",
    )


def report_bytes(
    scenes: Mapping[str, list[Cells]], others: Mapping[str, Draw], folder: Path
) -> None:
    for scene, quality, bar_kb, bar_db in (
        ("static", EXACT, 2.9, None),
        ("pan", GOOD, 55, 35),
        ("fixed", GOOD, 10, 36),
        ("photo", GOOD, None, None),
    ):
        say(f"bytes of scene {scene}")
        frames = without_pictures(scenes[scene])
        kilobytes, decibels = quality_of(frames, quality)
        peers = {name: cost.mean_kb for name, cost in contest(others, scene, rounds=1).items()}
        peers["exact"], _ = quality_of(frames, EXACT)
        peers |= {name: cost.kilobytes for name, cost in programs(folder, scene).items()}
        rounded = {name: round(value, 1) for name, value in peers.items()}
        report(f"terminal.{scene}_kB", kilobytes, "kB", bar=bar_kb, peers=rounded)
        if quality is not EXACT:
            note = f"tolerance {quality.tolerance}, threshold {quality.threshold}"
            report(f"terminal.{scene}_dB", decibels, "dB", bar=bar_db, better="higher", note=note)


def report_quadrants() -> None:
    """Half blocks and quadrants beside each other, against the picture of 320 x 192 pixels."""
    gains: dict[str, float] = {}
    for scene, frames in (
        ("pan", panning_frames()),
        ("photo", photo_frames()),
        ("fixed", fixed_frames()),
    ):
        say(f"quadrants of scene {scene}")
        size = 2 * COLUMNS, 4 * ROWS
        pictures = [
            np.asarray(Image.fromarray(frame).resize(size, Image.Resampling.BOX))
            for frame in frames
        ]
        drawn = {
            "half": without_pictures(list(map(seen, frames))),
            "quadrants": list(map(seen_in_quadrants, frames)),
        }
        for label, quality in (("exact", EXACT), ("good", GOOD)):
            found = {name: quality_of(each, quality, pictures) for name, each in drawn.items()}
            sizes = {name: round(kilobytes, 1) for name, (kilobytes, _) in found.items()}
            likeness = {name: round(decibels, 2) for name, (_, decibels) in found.items()}
            gains[f"{scene} {label}"] = likeness["quadrants"] - likeness["half"]
            report(
                f"terminal.quadrants_{scene}_{label}_kB",
                sizes["quadrants"],
                "kB",
                peers={"half": sizes["half"]},
                note=f"dB against the picture of 320x192: {likeness}",
            )
        costs = contest(
            {name: Ours({scene: each}, GOOD).draw for name, each in drawn.items()}, scene
        )
        report(
            f"terminal.quadrants_{scene}_ms",
            costs["quadrants"].typical_ms,
            "ms",
            peers={"half": round(costs["half"].typical_ms, 2)},
        )
    note = ", ".join(f"{name} {gain:.2f}" for name, gain in gains.items())
    report("terminal.quadrants_gain_dB", gains["pan exact"], "dB", better="higher", note=note)


if __name__ == "__main__":
    main()
