"""The tables of a study's file: a dataclass for each, and a key for each of its fields.

Times are in seconds. The `key` of a field says how the file's value is read, which values it may
have, and what it means; `docs/studies.md` lists the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hub.toml_reader import (
    RefusedError,
    choice,
    key,
    number,
    plain_name,
    several,
    shorten,
    text,
    truth,
    variables,
    whole_number,
)
from hub.values import dataclass
from rune_study.plan.orders import BY_LOT, ROWS
from rune_tui.model.operating_limits import ASSISTANCE, AUTONOMY

MOST_PARTICIPANTS = 1000
MOST_CONDITIONS = 26
"""As many as codes A to Z."""
ENDS = ("time", "victims", "collisions", "operator", "experimenter")
"""What can end a trial."""
SEED_RULES = ("trial", "condition", "study")
"""For what one seed stays the same."""
_SECONDS = number(0.0, 86_400.0)
_NAME = plain_name(64)
_NAMES = several(_NAME, 100)


def read_level(value: object) -> str | float | bool:
    """One level of a factor."""
    if isinstance(value, str) and 1 <= len(value) <= 200 and value.isprintable():
        return value
    if isinstance(value, bool | int | float):
        return value
    reason = f"{shorten(value)} is no level: a text of 1 to 200 characters, a number or a truth"
    raise RefusedError(reason)


def _span(value: object) -> tuple[float, float]:
    """A shortest and a longest time [s]."""
    if isinstance(value, list) and len(value) == 2:
        least, most = (number(0.5, 3600.0)(each) for each in value)
        if least <= most:
            return least, most
    reason = f"{shorten(value)} is not a list of a shortest and a longest time, 0.5 to 3600"
    raise RefusedError(reason)


def _setting(value: object) -> str:
    setting: str = text(300)(value)
    name, given, _ = setting.partition("=")
    if not given or name.count(".") != 1:
        reason = f"{shorten(value)} is no TABLE.KEY=VALUE"
        raise RefusedError(reason)
    return setting


_SETTINGS = several(_setting, 50)
_VARIABLES = variables(200, 50)


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionSpec:
    """What a participant works with; every key can be a factor."""

    layout: str = key(text(300), "search", "a layout: a shipped one, or a file of the study")
    robot: str = key(text(300), "magellan", "the simulated robot: a shipped one, or its file")
    robots: int = key(whole_number(1, 16), 1, "number of robots, each with a hub")
    hubs: tuple[str, ...] = key(
        several(text(200), 16),
        (),
        "HOST or HOST:PORT of real robots, one for each",
        without="simulated robots",
    )
    arena: str = key(
        text(300), "", "a shipped arena, or a file of the study", without="the robot's"
    )
    link: str = key(text(64), "", "profile of the link to the hub", without="as it is")
    link_seed: str = key(choice(SEED_RULES), "trial", "for what the link's seed stays the same")
    assistance: str = key(
        choice(ASSISTANCE),
        "",
        "whether robots stop before obstacles",
        without="`switched`: as the operator wants",
    )
    autonomy: str = key(
        choice(AUTONOMY),
        "",
        "the most that robots do by themselves",
        without="what the layout offers",
    )
    speed: float | None = key(
        number(0.01, 3.0), None, "largest forward velocity [m/s]", without="the robot's"
    )
    variables: tuple[tuple[str, str], ...] = key(
        _VARIABLES, (), "values of the layout's variables", without="none"
    )
    settings: tuple[str, ...] = key(
        _SETTINGS, (), "values in place of the robot file's: TABLE.KEY=VALUE", without="none"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelSpec:
    """What a level of a factor changes besides the condition's own keys."""

    factor: str = key(_NAME, meaning="the factor")
    level: str | float | bool = key(read_level, meaning="its level")
    variables: tuple[tuple[str, str], ...] = key(
        _VARIABLES, (), "values of the layout's variables", without="none"
    )
    settings: tuple[str, ...] = key(
        _SETTINGS, (), "values in place of the robot file's: TABLE.KEY=VALUE", without="none"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignSpec:
    """How conditions are ordered."""

    order: str = key(choice([*ROWS, *BY_LOT]), "williams", "the design")
    trials: int = key(whole_number(1, 100), 1, "trials of each condition")
    longest_run: int = key(
        whole_number(0, 100), 0, "how often a condition comes in a row at most", without="any"
    )
    apart: tuple[str, ...] = key(
        _NAMES, (), "factors whose levels never come twice in a row", without="none"
    )
    blind: bool = key(truth, default=False, meaning="whether files and screens name codes only")


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSpec:
    """What a participant does, step by step."""

    steps: tuple[str, ...] = key(
        _NAMES,
        ("trials",),
        "`practice`, `trials`, `break`, `secondary`, questionnaires, texts of `texts/`",
    )
    break_s: float = key(_SECONDS, 60.0, "least length of a break [s]")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSpec:
    """One trial."""

    seconds: float = key(number(1.0, 86_400.0), 600.0, "its longest time [s]")
    ends: tuple[str, ...] = key(
        several(choice(ENDS), len(ENDS)), ("time",), "what ends it; time always does"
    )
    collisions: int = key(whole_number(1, 10_000), 5, "collisions that end it")
    before: tuple[str, ...] = key(
        _NAMES, (), "texts and questionnaires before each", without="none"
    )
    after: tuple[str, ...] = key(_NAMES, (), "the same after each", without="none")
    begins: str = key(choice(("operator", "experimenter")), "operator", "who begins it, by a key")


@dataclass(frozen=True, slots=True, kw_only=True)
class MomentsSpec:
    """Moments by lot within a trial."""

    count: int = key(whole_number(1, 100), 1, "how many in a trial")
    not_before_s: float = key(_SECONDS, 60.0, "least time from the trial's start [s]")
    apart_s: float = key(_SECONDS, 60.0, "least time between two [s]")
    not_after_s: float | None = key(
        _SECONDS, None, "latest time from the trial's start [s]", without="the trial's end"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class FreezeSpec(MomentsSpec):
    """Questions while screen and simulation stand still (SAGAT)."""

    questions: str = key(_NAME, "sagat", "the questionnaire")
    draws: int = key(
        whole_number(0, 100), 0, "how many of its questions each time, by lot", without="all"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class WithholdSpec(MomentsSpec):
    """Control that is withheld until the robot needs its operator: neglect probes."""

    longest_s: float = key(number(1.0, 3600.0), 120.0, "longest time without control [s]")
    still_s: float = key(number(0.1, 600.0), 3.0, "time without work of a robot that ends it [s]")


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondarySpec:
    """A task beside the main one."""

    every_s: tuple[float, float] = key(
        _span, (15.0, 30.0), "least and longest time between two [s]"
    )
    longest_s: float = key(number(0.5, 600.0), 10.0, "time for an answer [s]")
    alone_s: float = key(
        number(10.0, 3600.0), 120.0, "length of the step `secondary`: the task without a robot [s]"
    )
    ask: tuple[str, ...] = key(
        several(text(60), 100), ("EVEN OR ODD: 4", "EVEN OR ODD: 7"), "what is shown"
    )
    keys: tuple[str, ...] = key(several(text(20), 20), ("f6", "f7"), "the keys of answers")
    right: tuple[str, ...] = key(
        several(text(20), 100), ("f6", "f7"), "the right key of each text of `ask`"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PracticeSpec:
    """Practice until a criterion holds."""

    layout: str = key(text(300), "", "its layout", without="the first trial's")
    arena: str = key(text(300), "", "its arena", without="the first trial's")
    criterion: str = key(
        text(200),
        "",
        "when it is enough: clauses such as `bumps <= 1` with `and` between",
        without="the operator's key",
    )
    window_s: float = key(number(1.0, 3600.0), 120.0, "the criterion looks back so far [s]")
    least_s: float = key(_SECONDS, 0.0, "shortest practice [s]")
    most_s: float = key(number(1.0, 86_400.0), 600.0, "longest practice [s]")


@dataclass(frozen=True, slots=True, kw_only=True)
class MetricsSpec:
    """What is measured, chosen before the first participant."""

    primary: tuple[str, ...] = key(_NAMES, (), "metrics that decide", without="none")
    secondary: tuple[str, ...] = key(_NAMES, (), "other metrics", without="all others")
    effectiveness: str = key(_NAME, "new_area", "the rate that is task effectiveness")
    threshold: float = key(
        number(0.0, 1.0), 0.5, "share of the median effectiveness below which attention is needed"
    )
    gap_s: float = key(number(0.1, 600.0), 2.0, "pause between inputs that ends an episode [s]")
    hold_s: float = key(number(0.1, 600.0), 3.0, "how long effectiveness stays low [s]")
    tau_s: float = key(
        number(0.0, 86_400.0),
        0.0,
        "bound of restricted means of neglect tolerance [s]",
        without="the longest neglect of each trial",
    )
    victim_radius_m: float = key(number(0.01, 100.0), 1.0, "how near a mark is to its victim [m]")


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkersSpec:
    """Markers for other instruments."""

    lsl: bool = key(truth, default=False, meaning="whether markers go to Lab Streaming Layer")


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySpec:
    """A study.

    Attributes:
        folder: Its folder.
        digest: SHA-256 of its files, in hexadecimal digits.
        conditions: All conditions, in the order of the file.
        levels: Of each condition: the levels of its factors.
        session: Steps of a session.
        design: Order of conditions.
        trial: One trial.
        practice: None: there is none.
        freeze: None: there is none.
        withhold: None: there is none.
        task: The secondary task; None: there is none.
        metrics: What is measured.
        markers: Markers for other instruments.
    """

    title: str = key(text(200), meaning="what it is about")
    seed: str = key(text(200), meaning="words that all draws depend on; never change them later")
    participants: int = key(whole_number(1, MOST_PARTICIPANTS), meaning="how many are planned")
    folder: Path
    digest: str
    conditions: tuple[ConditionSpec, ...]
    levels: tuple[Mapping[str, Any], ...]
    session: SessionSpec
    design: DesignSpec
    trial: TrialSpec
    practice: PracticeSpec | None
    freeze: FreezeSpec | None
    withhold: WithholdSpec | None
    task: SecondarySpec | None
    metrics: MetricsSpec
    markers: MarkersSpec
