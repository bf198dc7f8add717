"""The report on a terminal, for people and for machines."""

from __future__ import annotations

import json

from rune_tui.compositor.depth import ColourDepth
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.specimen import specimens
from rune_tui.terminal.traits import Traits


def report(traits: Traits, answers: Answers, took: float, size: tuple[int, int]) -> str:
    """A table of traits with reasons, and a picture in each set of glyphs, if there is a choice.

    Args:
        traits: The terminal's assumed traits.
        answers: Its answers.
        took: How long its answers took [s].
        size: Columns and rows.
    """
    why = traits.reasons
    lines = [
        ("answers", _answered(answers, took), ""),
        ("size", f"{size[0]}x{size[1]} cells", ""),
        ("colours", traits.depth.value, why["depth"]),
        ("glyphs", traits.glyphs.value, why["glyphs"]),
        ("cell shape", f"1:{traits.aspect:.2f}", why["aspect"]),
        ("whole frames", _yes(yes=traits.synchronized), why["synchronized"]),
        ("acknowledges", _yes(yes=traits.acknowledges), why["acknowledges"]),
        ("key releases", _yes(yes=traits.releases), why["releases"]),
        ("long frames", "thrown away" if traits.discards else "kept", why["discards"]),
    ]
    table = "".join(
        f"{name:<13} {value:<26} {reason}".rstrip() + "\n" for name, value, reason in lines
    )
    # With fewer colours there is no choice to compare.
    return f"{table}\n{specimens()}" if traits.depth is ColourDepth.TRUECOLOUR else table


def as_json(traits: Traits, answers: Answers, took: float, size: tuple[int, int]) -> str:
    """The same in one line."""
    found = {
        "complete": answers.complete,
        "took_ms": round(1000 * took, 1),
        "columns": size[0],
        "rows": size[1],
        "colors": traits.depth.value,
        "glyphs": traits.glyphs.value,
        "aspect": round(traits.aspect, 3),
        "synchronized": traits.synchronized,
        "acknowledges": traits.acknowledges,
        "releases": traits.releases,
        "discards": traits.discards,
        "reasons": dict(traits.reasons),
    }
    return json.dumps(found) + "\n"


def _answered(answers: Answers, took: float) -> str:
    if answers.complete:
        return f"after {1000 * took:.0f} ms"
    return f"not within {took:.1f} s"


def _yes(*, yes: bool) -> str:
    return "yes" if yes else "no"
