"""What a recording has of an input: the widgets that it woke, and what became of it; pure."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from rune_tui.controls.events import ControlEvent
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import Effect, Notify, OrderEffect, SendEffect
from rune_tui.model.own_records import InputOutcome, InputRecord
from rune_tui.model.robot_state import LinkPhase
from rune_tui.widgets.listeners import Listener
from rune_tui.widgets.widget import commanded


def input_record(
    event: ControlEvent,
    bound: Sequence[Listener],
    effects: Collection[Effect],
    state: ConsoleState,
    read: float,
) -> InputRecord:
    """The record of an input.

    Args:
        event: The input.
        bound: The widgets that the layout binds to it there.
        effects: Its effects.
        state: The state of the console then.
        read: Time at which its report was read [s].
    """
    hit = event.hits[0] if event.hits else None
    robots = [commanded(each.widget, state) for each in bound]
    robot = next(filter(None, robots), hit.robot if hit is not None else "")
    return InputRecord(
        t_read=read,
        input=event.name,
        pressed=event.pressed,
        repeat=event.repeat,
        value=float(event.value),
        viewport=hit.viewport if hit is not None else "",
        x=hit.x if hit is not None else math.nan,
        y=hit.y if hit is not None else math.nan,
        in_picture=hit is not None and hit.in_picture is not None,
        handlers=tuple(dict.fromkeys(each.handler for each in bound)),
        robot=robot,
        outcome=_outcome(event, bound, effects, state),
    )


def _outcome(
    event: ControlEvent,
    bound: Sequence[Listener],
    effects: Collection[Effect],
    state: ConsoleState,
) -> InputOutcome:
    orders = [each for each in effects if isinstance(each, OrderEffect)]
    if orders:
        sent = any(_arrives(each, state) for each in orders)
        return InputOutcome.SENT if sent else InputOutcome.REFUSED
    if not any(each.widget.rule.needs_robot for each in bound):
        return InputOutcome.NONE
    if any(isinstance(each, Notify) for each in effects):
        return InputOutcome.REFUSED
    kept_back = event.stale or event.must_release_first or state.paged or bool(state.peeked)
    return InputOutcome.DEAF if kept_back else InputOutcome.NONE


def _arrives(order: OrderEffect, state: ConsoleState) -> bool:
    """Whether the link to the robot takes an order."""
    robot = state.robots.get(order.robot)
    if robot is None or robot.link.phase is not LinkPhase.CONNECTED:
        return False
    if isinstance(order, SendEffect):
        return robot.link.may_send(order.definition.name)
    return robot.link.may_command
