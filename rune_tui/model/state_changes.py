"""Applies effects to the console's state."""

from __future__ import annotations

import bisect
import dataclasses
from collections.abc import Mapping
from typing import TypeVar

from rune_tui.model.console_state import MOST_NOTICES, ConsoleState, Notice
from rune_tui.model.effects import (
    MOST_TRIM,
    SPEED_LIMITS,
    AskToLeave,
    ChooseCamera,
    ChooseRobot,
    CoverEffect,
    FillView,
    LimitSpeed,
    MarksWaiting,
    Notify,
    Peek,
    SetTheme,
    ShowGhost,
    ShowViewport,
    StateEffect,
    ToggleHelp,
    ToggleLog,
    ToggleNight,
    TrimSpeed,
    TurnPage,
    WishPictures,
    Zoom,
)
from rune_tui.model.page import Page
from rune_tui.model.theme import THEMES

_LATE_S = 1.0
"""Notices whose times differ by less stay in the order of their arrival [s]."""
LEAST_ZOOM = 0.05
MOST_ZOOM = 50.0

K = TypeVar("K")
T = TypeVar("T")


def changed(state: ConsoleState, effect: StateEffect) -> ConsoleState:
    """The console's state after an effect."""
    match effect:
        case ShowViewport():
            return _showing(state, effect)
        case FillView() | ToggleHelp() | ToggleLog() | TurnPage() | AskToLeave():
            return _covered(state, effect)
        case ChooseRobot(robot=name):
            chosen = name or _next(state.chosen, state.robots)
            return _looked_away(dataclasses.replace(state, chosen=chosen, peeked=""), state)
        case Peek(robot=name):
            return _looked_away(dataclasses.replace(state, peeked=name), state)
        case Zoom(viewport=name, factor=factor):
            zoom = state.zooms.get(name, 1.0) * factor if factor > 0.0 else 1.0
            zoom = min(MOST_ZOOM, max(LEAST_ZOOM, zoom))
            return dataclasses.replace(state, zooms=_with(state.zooms, name, zoom))
        case (
            WishPictures()
            | ChooseCamera()
            | ToggleNight()
            | LimitSpeed()
            | TrimSpeed()
            | ShowGhost()
        ):
            return _of_robot(state, effect)
        case MarksWaiting(source=source, robot=name, count=count, overdue=overdue):
            return dataclasses.replace(
                state,
                unconfirmed=_with(state.unconfirmed, (source, name), count),
                overdue=_with(state.overdue, (source, name), overdue),
            )
        case SetTheme(name=name):
            theme = THEMES.get(name or _next(state.theme.name, THEMES), state.theme)
            return dataclasses.replace(state, theme=theme)
        case Notify(notice=notice):
            return dataclasses.replace(state, notices=_with_notice(state.notices, notice))


def _looked_away(state: ConsoleState, before: ConsoleState) -> ConsoleState:
    """The state with the time at which the operator looked away from a robot."""
    if state.seen == before.seen:
        return state
    return dataclasses.replace(state, looked=_with(state.looked, before.seen, before.now))


def _covered(state: ConsoleState, effect: CoverEffect) -> ConsoleState:
    """The state after a page or a full viewport opens or closes."""
    match effect:
        case FillView(viewport=name):
            return dataclasses.replace(state, full="" if state.full == name else name)
        case ToggleHelp():
            return dataclasses.replace(state, help=not state.help, log=False, page=Page())
        case ToggleLog():
            shown = not state.log
            return dataclasses.replace(state, log=shown, help=False, page=Page())
        case TurnPage(page=page):
            return dataclasses.replace(state, page=page)
        case AskToLeave(reasons=reasons):
            clear = not reasons
            return dataclasses.replace(
                state, leaving=reasons, help=state.help and clear, log=state.log and clear
            )


def _of_robot(
    state: ConsoleState,
    effect: WishPictures | ChooseCamera | ToggleNight | LimitSpeed | TrimSpeed | ShowGhost,
) -> ConsoleState:
    """The state after an effect on one robot."""
    match effect:
        case WishPictures(robot=name, wish=wish):
            return dataclasses.replace(state, wishes=_with(state.wishes, name, wish))
        case ChooseCamera(robot=name, camera=camera):
            return dataclasses.replace(state, cameras=_with(state.cameras, name, camera))
        case ToggleNight(robot=name, on=on):
            wanted = name not in state.night if on is None else on
            night = state.night | {name} if wanted else state.night - {name}
            return dataclasses.replace(state, night=night)
        case LimitSpeed(robot=name):
            limits = _with(state.speed_limits, name, _limit(state.speed_limit(name), effect))
            return dataclasses.replace(state, speed_limits=limits)
        case TrimSpeed(robot=name):
            trims = _with(state.trims, name, _trimmed(state.trim(name), effect))
            return dataclasses.replace(state, trims=trims)
        case ShowGhost(robot=name, ghost=ghost):
            others = {each: shown for each, shown in state.ghosts.items() if each != name}
            ghosts = others if ghost is None else {**others, name: ghost}
            return dataclasses.replace(state, ghosts=ghosts)


def _trimmed(now: Mapping[str, float], effect: TrimSpeed) -> Mapping[str, float]:
    """The trims of a robot after an effect, rounded so that steps back give 0 again."""
    if not effect.control:
        return {}
    trim = round(now.get(effect.control, 0.0) + effect.change, 6) if effect.change else 0.0
    return {**now, effect.control: max(-MOST_TRIM, min(MOST_TRIM, trim))}


def _limit(now: float, effect: LimitSpeed) -> float:
    """The speed limit after an effect."""
    if effect.share is not None:
        return min(1.0, max(0.0, effect.share))
    if effect.up:
        return next((limit for limit in SPEED_LIMITS if limit > now), SPEED_LIMITS[-1])
    return next((limit for limit in reversed(SPEED_LIMITS) if limit < now), SPEED_LIMITS[0])


def _showing(state: ConsoleState, effect: ShowViewport) -> ConsoleState:
    """The state with a viewport shown or hidden, and a notice if this size has no room for it."""
    name = effect.viewport
    if state.places and name not in state.places:
        text = f"{name} has no place on a terminal of this size"
        return changed(state, Notify.now(state, text))
    now = state.shown.get(name, state.places.get(name, True))
    wanted = not now if effect.shown is None else effect.shown
    return dataclasses.replace(state, shown=_with(state.shown, name, wanted))


def _with_notice(notices: tuple[Notice, ...], notice: Notice) -> tuple[Notice, ...]:
    """The newest notices with one more; one that is known late goes where it happened."""
    if not notices or notice.when > notices[-1].when - _LATE_S:
        return (*notices[1 - MOST_NOTICES :], notice)
    place = bisect.bisect_right(notices, notice.when, key=lambda each: each.when)
    return (*notices[:place], notice, *notices[place:])[-MOST_NOTICES:]


def _with(mapping: Mapping[K, T], name: K, value: T) -> Mapping[K, T]:
    return {**mapping, name: value}


def _next(name: str, names: Mapping[str, object]) -> str:
    """The next name in cyclic order; the first for an unknown name."""
    known = list(names)
    if not known:
        return ""
    return known[(known.index(name) + 1) % len(known)] if name in known else known[0]
