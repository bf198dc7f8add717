"""Takes out of effects what the condition of a study refuses; pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, SendEffect
from rune_tui.model.operating_limits import NO_LIMITS


def within(effects: Iterable[Effect], state: ConsoleState) -> list[Effect]:
    """The effects without messages that the limits refuse; a notice takes their place.

    Later notices without alarm of such a robot are left out, as they confirm what is not done.
    """
    if state.limits is NO_LIMITS:
        return list(effects)
    kept: list[Effect] = []
    refused: set[str] = set()
    for effect in effects:
        why = _refusal(effect, state)
        if why and isinstance(effect, SendEffect):
            text = f"not in this condition: {why}"
            kept.append(Notify.now(state, text, robot=effect.robot, alarm=True))
            refused.add(effect.robot)
        elif not confirms(effect, refused):
            kept.append(effect)
    return kept


def confirms(effect: Effect, robots: Collection[str]) -> bool:
    """Whether an effect is a notice without alarm of one of these robots."""
    return isinstance(effect, Notify) and not effect.notice.alarm and effect.notice.robot in robots


def _refusal(effect: Effect, state: ConsoleState) -> str:
    """Why an effect may not be executed; empty: it may."""
    if not isinstance(effect, SendEffect):
        return ""
    return state.limits.refusal(effect.definition, effect.value)
