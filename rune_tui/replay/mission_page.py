"""A report of what a recording shows: one HTML page that stands alone."""

from __future__ import annotations

import base64
import datetime
import io
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Final

from hub.gcm.mapping import INTEREST_POINTS
from hub.plain_text import counted, markup
from hub.values import dataclass
from rune_tui.compositor.picture import image
from rune_tui.export.report import drawing
from rune_tui.model.attention import Problem
from rune_tui.model.robot_state import RobotState
from rune_tui.replay import timeline
from rune_tui.replay.desk import SECOND
from rune_tui.replay.player import Player
from rune_tui.replay.source import (
    EventKind,
    Overview,
    ReplayEvent,
    ReplayFrame,
    ReplaySource,
    with_notes,
)
from rune_tui.visualizers.words.troubles import problems, troubles_of_all

_MOST_PICTURES: Final = 12
_STEP_NS: Final = SECOND
"""The robots' ways have a place for each such time [ns]."""
_COLUMNS: Final = 110
_SCALE: Final = 5
_WRONG: Final = (EventKind.ALARM, EventKind.BUMP)
_NAMES: Final = {kind: kind.name.lower() for kind in EventKind}
_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 70em; color: #181c22 }
table { border-collapse: collapse }
th, td { text-align: left; padding: .2em .7em; border-bottom: 1px solid #c4c8cc }
pre { background: #f2f3f5; padding: .6em; overflow-x: auto; line-height: 1.1 }
svg { width: 100%; max-height: 80vh; background: #b0b4b8 }
img { width: 100% }
.pictures { display: grid; grid-template-columns: 1fr 1fr; gap: 1em }
"""


@dataclass(slots=True)
class _LastingProblem:
    """A problem that the console could show, as far as it was looked at once a second.

    Attributes:
        begin: When it was there first [ns].
        end: When it was there last [ns].
        seconds: How long it was there [s].
        problem: What it was at its worst.
    """

    begin: int
    end: int
    seconds: int
    problem: Problem


@dataclass(frozen=True, slots=True)
class _Way:
    """What is kept of a robot: its places, and its state at the end."""

    places: list[tuple[float, float]]
    last: RobotState


def mission_page(
    player: Player, progress: Callable[[float], None], notes: Sequence[ReplayEvent] = ()
) -> str:
    """The page: what went wrong, all events, each robot's map with its way, and pictures.

    Args:
        player: Plays the recording.
        progress: Gets the share that is done, 0 to 1.
        notes: What people noted while they looked at the recording.
    """
    source, overview = player.source, with_notes(player.survey(), notes)
    ways, shown = _ways(player, lambda share: progress(0.7 * share))
    moments = _moments(player, overview)
    pictures = []
    for number, (stamp, words) in enumerate(moments, 1):
        pictures.append(_picture(player, stamp, words))
        progress(0.7 + 0.3 * number / len(moments))
    progress(1.0)
    start, end = source.start, source.end
    row = timeline.marks_row(_COLUMNS, start, end, end, overview)
    wrong = [event for event in overview.events if event.kind in _WRONG]
    heading = markup(f"What happened: {source.title}")
    parts = [
        f"<h1>{heading}</h1>",
        f"<p>{_clock(start, date=True)} to {_clock(end)}, {_length(end - start)}. "
        f"{counted(len(overview.episodes), 'episode')} of interaction, "
        f"{counted(len(overview.events), 'event')}.</p>",
        f"<pre>{markup(row)}</pre>",
        "<p>F freeze, ! alarm, V victim, B bump, | trial, · note, ▂ interaction, ╱ nothing.</p>",
        "<h2>What went wrong</h2>",
        _events(wrong, start) if wrong else _nothing_wrong(source),
        *_problems(shown, start),
        *(
            f"<p>Nothing is recorded from {_length(gap.start - start)} to "
            f"{_length(gap.end - start)}.</p>"
            for gap in overview.gaps
        ),
        *(f"<p>{markup(fault)}</p>" for fault in source.faults),
        "<h2>Robots</h2>",
        *(_robot(name, way) for name, way in ways.items()),
        "<h2>Pictures</h2>",
        f'<div class="pictures">{"".join(pictures)}</div>',
        "<h2>All events</h2>",
        _events(overview.events, start) if overview.events else "<p>There are none.</p>",
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f"<title>{heading}</title><style>{_STYLE}</style></head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def _nothing_wrong(source: ReplaySource) -> str:
    unread = " in what can be read; parts of the recording cannot be read" if source.faults else ""
    return f"<p>No alarm and no bump is recorded{unread}.</p>"


def _problems(shown: Sequence[_LastingProblem], start: int) -> Iterator[str]:
    """A table of what was wrong for a while; alarms come first."""
    if not shown:
        return
    yield "<p>What a console says was wrong, looked at once a second:</p>"
    yield "<table><tr><th>first</th><th>last</th><th>for</th><th>robot</th><th></th><th></th></tr>"
    for each in sorted(shown, key=lambda each: (not each.problem.alarm, each.begin)):
        times = (_length(each.begin - start), _length(each.end - start), f"{each.seconds} s")
        problem = each.problem
        cells = (*times, problem.robot, "alarm" if problem.alarm else "warning", problem.text)
        yield "<tr>" + "".join(f"<td>{markup(cell)}</td>" for cell in cells) + "</tr>"
    yield "</table>"


def _note_problems(shown: dict[tuple[str, str], _LastingProblem], frame: ReplayFrame) -> None:
    """Add the problems of a frame to those before."""
    for problem in problems(troubles_of_all(frame.state)):
        key = problem.robot, problem.cause
        known = shown.setdefault(key, _LastingProblem(frame.stamp, frame.stamp, 0, problem))
        known.end = frame.stamp
        known.seconds += 1
        if problem.alarm and not known.problem.alarm:
            known.problem = problem


def _ways(
    player: Player, progress: Callable[[float], None]
) -> tuple[dict[str, _Way], list[_LastingProblem]]:
    source = player.source
    ways: dict[str, _Way] = {}
    shown: dict[tuple[str, str], _LastingProblem] = {}
    due = source.start
    for frame in source.frames(source.start - 1, source.end):
        if frame.stamp < due and frame.stamp < source.end:
            continue
        due = frame.stamp + _STEP_NS
        _note_problems(shown, frame)
        for name, robot in frame.state.robots.items():
            known = ways.get(name)
            places = known.places if known is not None else []
            at = robot.navigation
            if at is not None and math.isfinite(at.value.x) and math.isfinite(at.value.y):
                places.append((at.value.x, at.value.y))
            ways[name] = _Way(places, robot)
        progress((frame.stamp - source.start) / max(1, source.end - source.start))
    lasting = [
        each
        for each in shown.values()
        # A console that begins has no link yet.
        if each.problem.alarm or each.seconds > 1 or each.begin - source.start >= SECOND
    ]
    return ways, lasting


def _moments(player: Player, overview: Overview) -> list[tuple[int, str]]:
    """Times of pictures with their words: the begin, the events that matter most, the end."""
    source = player.source
    order = list(EventKind)
    chosen = sorted(overview.events, key=lambda each: (order.index(each.kind), each.stamp))
    found = [(each.stamp, each.text or _NAMES[each.kind]) for each in chosen[: _MOST_PICTURES - 2]]
    return sorted([(source.start, "The begin"), *found, (source.end, "The end")])


def _picture(player: Player, stamp: int, words: str) -> str:
    player.seek(stamp)
    cells = player.drawer.cells
    if cells is None:
        return ""
    file = io.BytesIO()
    image(cells, scale=_SCALE).quantize(64).save(file, "PNG", optimize=True)
    code = base64.b64encode(file.getvalue()).decode()
    when = markup(f"{_length(stamp - player.source.start)}: {words}")
    return f'<div><p>{when}</p><img alt="" src="data:image/png;base64,{code}"></div>'


def _robot(name: str, way: _Way) -> str:
    reported = way.last.newest(INTEREST_POINTS)
    points = [
        point
        for point in (reported.value.points if reported is not None else ())
        if math.isfinite(point.x) and math.isfinite(point.y)
    ]
    grid = way.last.map.value if way.last.map is not None else None
    steps = zip(way.places, way.places[1:], strict=False)
    driven = sum(math.dist(first, second) for first, second in steps)
    way_words = f"about {driven:.1f} m driven" if way.places else "where it was is not recorded"
    marks = counted(len(points), "mark") if reported is not None else "no report of marks"
    words = f"{way.last.title}: {way_words}, {marks} at the end."
    picture = drawing(points, grid, way.places) if way.places or points else ""
    return f"<h3>{markup(name)}</h3><p>{markup(words)}</p>{picture}"


def _events(events: Sequence[ReplayEvent], start: int) -> str:
    head = "<tr><th>at</th><th>what</th><th>robot</th><th></th></tr>"
    return f"<table>{head}{''.join(_rows(events, start))}</table>"


def _rows(events: Sequence[ReplayEvent], start: int) -> Iterator[str]:
    for event in events:
        cells = (_length(event.stamp - start), _NAMES[event.kind], event.robot, event.text)
        yield "<tr>" + "".join(f"<td>{markup(cell)}</td>" for cell in cells) + "</tr>"


def _clock(stamp: int, *, date: bool = False) -> str:
    moment = datetime.datetime.fromtimestamp(stamp / SECOND).astimezone()
    return f"{moment:%Y-%m-%d %H:%M:%S}" if date else f"{moment:%H:%M:%S}"


def _length(nanoseconds: int) -> str:
    seconds = max(0, nanoseconds) // SECOND
    return f"{seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"
