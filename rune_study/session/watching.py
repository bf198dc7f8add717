"""The experimenter's screen: how far a session is, and orders to it."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.containers import Horizontal, VerticalScroll
from textual.widgets import Input, Static

from hub.plain_text import plain
from rune_study.errors import StudyError
from rune_study.plan.study_spec import StudySpec
from rune_study.session.journal import DONE, Record, journal_path, read_journal
from rune_study.session.live import RobotSigns, read_signs
from rune_study.session.orders import ABORT, BEGIN, END, MARK, NOTE, PAUSE, give_order
from rune_study.session.overview import Overview, State, overview

_LOOK_S = 0.3
_KEYS: Mapping[str, tuple[str, str, str]] = {
    "b": (f"order('{BEGIN}')", "begin", "begin or go on"),
    "p": (f"order('{PAUSE}')", "pause", "pause"),
    "e": (f"order('{END}')", "end", "end trial"),
    "a": ("abort", "abort", "abort"),
    "m": (f"order('{MARK}')", "mark", "mark"),
    "n": ("note", "note", "note"),
    "q": ("quit", "quit", "quit"),
}
"""Action, short words and words of each key."""
_LINES = 200
_AGAIN_S = 3.0
"""Time within which the key that aborts has to be pressed twice [s]."""
_SAID_S = 4.0
"""How long the answer to a key is shown [s]."""
_ASKS_FOR_BEGIN = (State.WAITS, State.PAUSED)


class WatchScreen(App[None]):
    """Shows steps and journal of one participant; codes only."""

    CSS = """
    #now { height: auto; padding: 0 1; border-bottom: solid $accent; }
    #steps { width: 30; border-right: solid $accent; padding: 0 1; }
    #events { padding: 0 1; }
    #keys { dock: bottom; height: 1; padding: 0 1; background: $panel; }
    Input { dock: bottom; display: none; }
    """
    AUTO_FOCUS = ""  # keys are orders until a note is written
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar = [(key, action, name) for key, (action, name, _) in _KEYS.items()]

    def __init__(self, study: StudySpec, participant: int) -> None:
        """Watch a participant of a study."""
        super().__init__()
        self._study = study
        self._participant = participant
        self._path = journal_path(study.folder, participant)
        self._abort_at = float("-inf")
        self._said_at = float("-inf")

    def compose(self) -> ComposeResult:
        """State, steps, journal, keys, and the line of notes."""
        yield Static(id="now", markup=False)
        with Horizontal():
            with VerticalScroll(id="steps"):
                yield Static(id="list", markup=False)
            with VerticalScroll(id="events"):
                yield Static(id="journal", markup=False)
        yield Static(keys_line(State.ABSENT), id="keys", markup=False)
        yield Input(placeholder="a note; Enter writes it, an empty one is none")

    def on_mount(self) -> None:
        """Look at the journal now, and again and again."""
        self._look()
        self.set_interval(_LOOK_S, self._look)

    def action_order(self, do: str) -> None:
        """Give an order without words."""
        self._give(do, "")

    def action_abort(self) -> None:
        """Have the session left, at the second press."""
        now = time.monotonic()
        if now - self._abort_at < _AGAIN_S:
            self._give(ABORT, "")
        else:
            self._abort_at = now
            self._say("press a again to leave the session; it goes on later at this step")

    def action_note(self) -> None:
        """Open the line of notes."""
        line = self.query_one(Input)
        line.display = True
        line.focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Write a note."""
        if event.value.strip():
            self._give(NOTE, event.value.strip())
        event.input.value = ""
        event.input.display = False
        self.set_focus(None)

    def _give(self, do: str, text: str) -> None:
        try:
            give_order(self._path.parent, do, text)
        except StudyError as error:
            self._say(str(error))
        else:
            self._say(f"{do} is ordered")

    def _say(self, text: str) -> None:
        self._said_at = time.monotonic()
        self.query_one("#keys", Static).update(plain(text))

    def _look(self) -> None:
        records = read_journal(self._path) if self._path.exists() else []
        seen, robots = read_signs(self._path.parent)
        given = self._study, self._participant, records, robots
        found = overview(*given, now=time.time(), seen=seen)
        show = "\n".join(map(plain, now_lines(self._participant, found, robots)))
        self.query_one("#now", Static).update(show)
        self.query_one("#list", Static).update("\n".join(step_lines(found)))
        journal = self.query_one("#journal", Static)
        names = {each.number: each.name for each in found.steps}
        journal.update("\n".join(line_of(each, names) for each in records[-_LINES:]))
        self.query_one("#events", VerticalScroll).scroll_end(animate=False)
        if time.monotonic() - self._said_at > _SAID_S:
            self.query_one("#keys", Static).update(keys_line(found.state))


def keys_line(state: State) -> str:
    """The keys in one line, at most 78 characters; the key that is waited for is explained."""
    if state in _ASKS_FOR_BEGIN:
        words = {key: each[1] for key, each in _KEYS.items()} | {"b": "BEGIN OR GO ON"}
    else:
        words = {key: each[2] for key, each in _KEYS.items()}
    return "   ".join(f"{key} {text}" for key, text in words.items())


def now_lines(participant: int, found: Overview, robots: Sequence[RobotSigns]) -> Iterator[str]:
    """The session at a glance.

    Args:
        participant: The number.
        found: The session.
        robots: Its robots.
    """
    count = f"{len(found.done)} of {len(found.steps)} steps are done"
    left = f"about {found.minutes:.0f} min left" if found.minutes else "nothing left to do"
    yield f"participant {participant}: {count}, {left}, marks: {found.marks}"
    step = found.step
    if step is None:
        yield f"session {found.state.value}"
    elif found.state in (State.RUNS, State.PAUSED, State.FROZEN):
        time_left = max(0.0, step.seconds - found.elapsed)
        yield (
            f"{_name(found)}: {found.state.value}, {_clock(found.elapsed)} of "
            f"{_clock(step.seconds)}, {_clock(time_left)} left"
        )
        for number, robot in enumerate(robots, 1):
            yield f"robot {number}: {_robot(robot)}"
    else:
        yield f"{_name(found)}: session {found.state.value}, for {_clock(found.silence)}"
    yield from (f"ALARM: {each}" for each in found.alarms)


def step_lines(found: Overview) -> Iterator[str]:
    """A line for each step: `done`, `NOW`, or nothing before its name."""
    for each in found.steps:
        now = found.step is not None and each.number == found.step.number
        sign = "done" if each.number in found.done else "NOW" if now else ""
        yield f"{sign:<5}{each.name} {each.code if each.trial else ''}".rstrip()


def _name(found: Overview) -> str:
    step = found.step
    if step is None:
        return ""
    words = [step.name, *([step.code] if step.trial else [])]
    words += [f"(attempt {found.attempt})"] if found.attempt > 1 else []
    return " ".join(words)


def _clock(seconds: float) -> str:
    """A length of time as 4:05."""
    return f"{int(seconds) // 60}:{int(seconds) % 60:02}"


def _robot(robot: RobotSigns) -> str:
    silent = robot.get("silent", 0.0)
    parts = [
        f"{robot.get('speed', 0.0):.2f} m/s",
        f"{robot.get('distance', 0.0):.0f} m driven",
        f"{robot.get('collisions', 0.0):.0f} bumps",
        f"{robot.get('victims', 0.0):.0f} victims marked",
        f"heard {silent:.1f} s ago",
    ]
    return ", ".join(parts)


def line_of(record: Record, names: Mapping[int, str]) -> str:
    """A record in one line, without what blinds or identifies.

    Args:
        record: The record.
        names: Names of all steps, by their numbers.
    """
    shown = ("step", "code", "attempt", "number", "do", "text", "why", "key", "correct", "seconds")
    also = ("autonomy", "assistance")  # a blind study has none
    data = {
        name: record.data[name]
        for name in (*shown, *also)
        if record.data.get(name) not in (None, "")
    }
    attempt = data.pop("attempt", 1)
    words = [f"{each:.1f}" if isinstance(each, float) else str(each) for each in data.values()]
    if record.what in (DONE, "failed"):
        words[:0] = [names.get(record.data.get("n", -1), "")]
    words += [f"attempt {attempt}"] if attempt != 1 else []
    clock = time.strftime("%H:%M:%S", time.localtime(record.at))
    return plain(f"{clock} {record.what} {' '.join(words)}".rstrip())
