"""Whatever robots say, within its bounds, every shipped layout draws it and its keys go on.

States are made of extreme messages of all kinds at once; nothing may fail, not even where the view
or the dispatch would go on without it and log why.
"""

from __future__ import annotations

import dataclasses
import itertools
import logging
import os
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest

from hub.errors import CodecError
from hub.gcm.catalog import MESSAGES
from hub.gcm.control import CONTROL_STATE, ControlState
from hub.gcm.mapping import MAP
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.vision import IMAGE
from rune_tui.compositor.picture import plain_text
from rune_tui.controls.events import ControlEvent
from rune_tui.dispatch import Dispatch
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.pictures import picture_of
from rune_tui.model.change_notifier import ChangeNotifier
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import SendEffect, StateEffect
from rune_tui.model.robot_state import LinkPhase, LinkState, Received, RobotState
from rune_tui.model.state_changes import changed
from rune_tui.view import View
from rune_tui.visualizers.words.status_words import status_parts
from tests.console.situations import shipped
from tests.console.test_layout_snapshots import robot as usual
from tests.console.test_layout_snapshots import room
from tests.support import extremes

ROOT = Path(__file__).parents[2]
LAYOUTS = sorted(path.stem for path in (ROOT / "layouts").glob("*.xml"))
ROUNDS = max(3, int(os.environ.get("RUNE_EXTREMES", "30")) // 10)
"""In each there is a new message of every kind; drawing takes the most time."""
SIZE = (70, 22)
OWN = 2


class Robots:
    """Robots of a layout that know nothing but extreme messages."""

    def __init__(self, layout: LayoutSpec, random: Random) -> None:
        self._random = random
        self._layout = layout
        self._sources = {each.name: extremes.taken(each, random) for each in MESSAGES}
        self._numbers = itertools.count(1)

    def after(self, now: float) -> dict[str, RobotState]:
        return {spec.name: self._robot(spec.name, now) for spec in self._layout.robots}

    def _robot(self, name: str, now: float) -> RobotState:
        values = {each: next(source) for each, source in self._sources.items()}
        control: ControlState = values[CONTROL_STATE.name]
        if self._random.random() < 0.5:  # keys do something where this console has control
            owner = self._random.choice((0, OWN))
            values[CONTROL_STATE.name] = dataclasses.replace(control, owner=owner)
        known = {each: self._received(value, now) for each, value in values.items()}
        some = {each: value for each, value in known.items() if self._random.random() < 0.9}
        phase = self._random.choice((LinkPhase.CONNECTED,) * 4 + (LinkPhase.LOST,))
        link = LinkState(phase=phase, since=now - 1.0, endpoint=extremes.CONTROL, number=OWN)
        picture = self._decoded(picture_of, values[IMAGE.name], usual(0.1).picture, now)
        return RobotState(
            name=name,
            link=link,
            picture=picture,
            map=self._decoded(OccupancyMap.of, values[MAP.name], self._received(room(), now), now),
            messages=some,
        )

    def _decoded(self, decode: Any, message: Any, otherwise: Any, now: float) -> Any:
        try:
            return self._received(decode(message), now)
        except CodecError:
            kept = dataclasses.replace(otherwise, measured=now, number=next(self._numbers))
            if hasattr(message, "camera"):
                changed_camera = dataclasses.replace(kept.value, camera=message.camera)
                return dataclasses.replace(kept, value=changed_camera)
            moved = {"origin_x": message.origin_x, "origin_y": message.origin_y}
            moved["resolution"] = message.resolution
            return dataclasses.replace(kept, value=dataclasses.replace(kept.value, **moved))

    def _received(self, value: Any, now: float) -> Received[Any]:
        age = self._random.choice((0.0, 0.1, 3.0, 1e6))
        return Received(value=value, measured=now - age, number=next(self._numbers))


def inputs(layout: LayoutSpec, random: Random) -> Iterator[ControlEvent]:
    widgets = [
        *layout.view.widgets,
        *(each for part in layout.view.viewports for each in part.widgets),
    ]
    names = {event.name for widget in widgets for event in widget.events}
    for name in random.sample(sorted(names), min(6, len(names))):
        if "wheel" in name or name.startswith("joystick"):
            yield ControlEvent(name=name, pressed=True, value=random.choice((-1.0, 0.3, 1.0)))
        yield ControlEvent(name=name, pressed=True)
        yield ControlEvent(name=name, pressed=False)


@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")
@pytest.mark.timeout(7200 if ROUNDS > 100 else 300)
@pytest.mark.parametrize("name", LAYOUTS)
def test_layout_takes_whatever_robots_say(name: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.WARNING)
    layout, random = shipped(name), Random(3)
    view, dispatch, watch = View(layout, lambda: 0.0), Dispatch(layout), ChangeNotifier()
    view.resize(*SIZE)
    robots = Robots(layout, random)
    state = ConsoleState.at_start(layout, 1000.0, "ada")
    for number in range(ROUNDS):
        now = 1000.0 + number * 0.05
        state = dataclasses.replace(state, now=now, robots=robots.after(now))
        notices = watch.look(state)
        state = dataclasses.replace(state, notices=(*state.notices, *notices)[-50:])
        cells = view.render(state)
        if cells is not None and number % 10 == 0:
            assert all(row.isprintable() for row in plain_text(cells).split("\n"))
        view.picture_needs(state)
        hits = view.hits(random.randrange(SIZE[0]), random.randrange(2 * SIZE[1]), state)
        events = [dataclasses.replace(each, hits=hits) for each in inputs(layout, random)]
        effects = [*dispatch.tick(state)]
        for event in events:
            effects += dispatch.handle(event, state)
        for effect in effects:
            if isinstance(effect, SendEffect):
                notes: list[str] = []
                definition = effect.definition
                definition.decode(b"".join(definition.encode(effect.value)), notes.append)
                assert not notes
            elif isinstance(effect, StateEffect):
                state = changed(state, effect)
        if number % 7 == 0:
            state = dataclasses.replace(state, help=False, full="", shown={})
        for robot in state.robots.values():
            status_parts(robot, state)
        said = [record for record in caplog.records if record.levelno >= logging.ERROR]
        assert not said, (number, said[0].getMessage(), said[0].exc_text)
