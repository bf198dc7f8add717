"""The page of questionnaires says what their keys and the truths of questions declare.

After a wanted change, write it anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from hub.toml_reader import REQUIRED, Key, keys_of
from rune_study.questionnaires.items import KINDS, ComparedItem, Item
from rune_study.questionnaires.questionnaire import Questionnaire
from rune_study.questionnaires.truths import TRUTHS
from tests.house.test_plain_words import avoided_words, long_sentences

_PAGE = Path(__file__).parents[2] / "docs" / "study-questions.md"
_HEAD = """# Questionnaires of a study

A questionnaire is a TOML file in the folder `questionnaires/` of a study. Rune ships `consent`,
`demographics`, `nasa-tlx`, `sus`, `sart` and `sagat`; a file of the same name in the study takes
their place.

One question is on the screen at a time, without an answer that stands there already. Each answer
is on the disk before the next question is shown, so a session goes on at the first question
without an answer. A terminal that is too small for a question says so, and takes no answer.

```toml
name = "trust"
title = "About the robot"

[[item]]
id = "trust"
kind = "scale"
text = "I trust the robot."
low = "not at all"
high = "fully"
marks = 7
least = 1
```
"""
_TRUTHS = """## Questions with a truth (SAGAT)

A question of a freeze may name a `truth`. Rune keeps the truth of that moment, compares the
answer with it, and scores the share of right answers for each level of awareness. Level 1 is what
people perceive, level 2 what it means, level 3 what they expect. Esc says "I do not know": that
counts as wrong, and is counted apart.

- What a robot does is taken from the simulator. A real robot's own state takes its place; what it
  does not know is not asked then, and the journal says so.
- Places are in the frame `map` [m], directions in degrees counter-clockwise. A direction on the
  map counts from its x axis; the dial shows it by the compass, with north up.
- A question about a place shows the walls of the arena if the condition names one, else the
  robot's own map. It shows no robot, marks or victims. Arrows or the mouse set the place.
- A choice says in `means` which values of the truth make each option right.
- With `draws`, each freeze asks the first questions of an order by lot whose truth is known.

| truth | level | answer | unit | tolerance | meaning |
| --- | --- | --- | --- | --- | --- |
"""


def _page() -> str:
    parts = [
        _HEAD,
        "## The file",
        "",
        *_table(keys_of(Questionnaire)),
        "",
        "## Each question",
        "",
        "| key | default | meaning |",
        "| --- | --- | --- |",
        "| `kind` |  | one of the kinds below |",
        *_rows(keys_of(Item)),
        "",
        "A choice, number, bearing or place may have these too:",
        "",
        *_table(_without(keys_of(ComparedItem), keys_of(Item))),
        "",
        *_kinds(),
        _TRUTHS + "\n".join(_truths()),
    ]
    return "\n".join(parts).rstrip() + "\n"


def _without(keys: Mapping[str, Key], others: Mapping[str, Key]) -> dict[str, Key]:
    return {name: key for name, key in keys.items() if name not in others}


def _table(keys: Mapping[str, Key]) -> Iterator[str]:
    yield "| key | default | meaning |"
    yield "| --- | --- | --- |"
    yield from _rows(keys)


def _rows(keys: Mapping[str, Key]) -> Iterator[str]:
    for name, key in keys.items():
        default = key.without or (
            "" if key.default in (REQUIRED, "") else f"`{_toml(key.default)}`"
        )
        yield f"| `{name}` | {default} | {key.meaning} |"


def _toml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else f"{value}"


def _kinds() -> Iterator[str]:
    yield "## Kinds of questions"
    yield ""
    yield "| kind | what it is | its own keys |"
    yield "| --- | --- | --- |"
    for name, kind in KINDS.items():
        own = _without(keys_of(kind), keys_of(ComparedItem))
        words = (kind.__doc__ or "").split("\n")[0].rstrip(".")
        keys = "; ".join(f"`{each}`: {key.meaning}" for each, key in own.items())
        yield f"| `{name}` | {words[0].lower()}{words[1:]} | {keys} |"
    yield ""


def _truths() -> Iterator[str]:
    for name, truth in TRUTHS.items():
        tolerance = f"{truth.tolerance:g}" if truth.unit else ""
        kind = " ".join(f"`{word}`" for word in truth.words) or truth.kind
        cells = (f"`{name}`", str(truth.level), kind, truth.unit, tolerance, truth.meaning)
        yield f"| {' | '.join(cells)} |"


def test_page_of_questions_is_that_of_their_declarations() -> None:
    wanted = _page()
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        _PAGE.write_text(wanted)
    assert _PAGE.read_text() == wanted, "write it anew, as this file's docstring says"


def test_its_words_are_plain() -> None:
    assert long_sentences(_PAGE.read_text()) == []
    assert avoided_words(_PAGE.read_text()) == []
