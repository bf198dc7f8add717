"""Widgets for the camera: kind and size of pictures, and night mode."""

from __future__ import annotations

import dataclasses
import math
from typing import ClassVar

from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.vision import (
    NIGHT_COMMAND,
    ImageCoding,
    ImageKind,
    NightCommand,
)
from rune_tui.controls.events import ControlEvent
from rune_tui.layout.rules import ChoiceOption, HandlerRule, NumberOption, Section, TextOption
from rune_tui.layout.spec import CHOSEN, ControlKind, EventSpec
from rune_tui.model.cameras import camera_names, camera_of, unknown_camera
from rune_tui.model.console_state import ConsoleState, PictureWish
from rune_tui.model.effects import (
    ChooseCamera,
    Effect,
    Notify,
    SendEffect,
    ToggleNight,
    WishPictures,
)
from rune_tui.model.lacks import why_unsupported
from rune_tui.model.robot_state import RobotState
from rune_tui.widgets.widget import OrderWidget, PressWidget

_MOST_PIXELS = 4096.0
_QUALITY_STEP = 10.0
"""Change of the quality by a key or button."""
_LEAST_CHANGE = 5
"""Least change of the quality by an axis; smaller ones only make requests."""
_KINDS = tuple(kind.name.lower() for kind in ImageKind)
_AUTO = "auto"
_CODINGS = (_AUTO, *(coding.name.lower() for coding in ImageCoding))


class SetImageRequest(OrderWidget):
    """Asks for another kind of pictures, and for the usual ones again."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Other pictures, or the usual ones"},
        meaning="Asks for other pictures; pressed again, for the usual ones.",
        options={
            "kind": ChoiceOption(default="colour", choices=_KINDS, meaning="colours"),
            "width": NumberOption(
                default=0.0,
                least=0.0,
                most=_MOST_PIXELS,
                unit="px",
                meaning="width wanted; 0: as wide as is shown",
            ),
            "height": NumberOption(
                default=0.0,
                least=0.0,
                most=_MOST_PIXELS,
                unit="px",
                meaning="height wanted; 0: as high as is shown",
            ),
            "quality": NumberOption(
                default=60.0,
                least=1.0,
                most=100.0,
                meaning="1 is the least, 100 the best; with coding auto, of what is sent as rle",
            ),
            "coding": ChoiceOption(
                default=_AUTO,
                choices=_CODINGS,
                meaning="how pictures are coded on their way; auto: by measurement of the link, "
                "which also chooses quality, and size last",
            ),
        },
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The other kind, or the usual one if the other is asked for already."""
        options = self.spec.options
        coding = options.word("coding")
        wish = PictureWish(
            kind=ImageKind[options.word("kind").upper()],
            width=round(options.number("width")),
            height=round(options.number("height")),
            quality=round(options.number("quality")),
            coding=None if coding == _AUTO else ImageCoding[coding.upper()],
        )
        if state.wishes.get(robot.name) == wish:
            wish = PictureWish()
        return (WishPictures(robot=robot.name, wish=wish),)


class SetImageQuality(PressWidget):
    """Sets the quality of pictures by the position of an axis, such as a throttle."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Pictures {direction}"},
        meaning=(
            "Sets the quality of pictures by the position of an axis, such as a throttle: from "
            "`least` at its one end, or in its middle, to `most` at its other end. A key or button "
            "changes it by 10."
        ),
        options={
            "least": NumberOption(default=10.0, least=1.0, most=100.0, meaning="worst quality"),
            "most": NumberOption(default=90.0, least=1.0, most=100.0, meaning="best quality"),
            "coding": ChoiceOption(
                default="jpeg",
                choices=tuple(coding.name.lower() for coding in ImageCoding),
                meaning="how pictures are coded on their way",
            ),
        },
        words={"": ("better", "worse")},
    )
    repeats: ClassVar[bool] = True

    def handle(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The quality at this position; an axis in its middle or at its end has one too."""
        if event_spec.kind is ControlKind.AXIS and not event_spec.released:
            return self.press(event, event_spec, state)
        return super().handle(event, event_spec, state)

    def press(
        self, event: ControlEvent, event_spec: EventSpec, state: ConsoleState
    ) -> tuple[Effect, ...]:
        """The wish for pictures of that quality, if it changes by enough to be seen."""
        robot = state.robot(self.robot)
        if robot is None:
            return ()
        options = self.spec.options
        before = state.wishes.get(robot.name) or PictureWish()
        least, most = options.number("least"), options.number("most")
        if event_spec.kind is ControlKind.AXIS:
            share = abs(event.value * event_spec.value) if event.pressed else 0.0
            quality = least + min(1.0, share) * (most - least)
        else:
            quality = before.quality + math.copysign(_QUALITY_STEP, event_spec.value)
        low, high = sorted((least, most))
        wish = dataclasses.replace(
            before,
            quality=round(min(high, max(low, quality))),
            coding=ImageCoding[options.word("coding").upper()],
        )
        near = abs(wish.quality - before.quality) < _LEAST_CHANGE
        at_end = wish.quality in {round(low), round(high)}
        if wish == before or (wish.coding is before.coding and near and not at_end):
            return ()
        return (WishPictures(robot=robot.name, wish=wish),)


class ChooseCameraWidget(OrderWidget):
    """Shows another camera of the robot."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Camera: {camera}"},
        meaning="Shows another camera of the robot in viewports with the camera `*`.",
        options={
            "camera": TextOption(
                longest=100,
                unnamed="the next one",
                meaning="name of the camera; empty: the next one",
            )
        },
        uses=(ROBOT_DESCRIPTION.name,),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """The camera, or why it cannot be shown."""
        names = camera_names(robot)
        wanted = self.spec.options.word("camera")
        if why := unknown_camera(wanted, robot):
            return (Notify.now(state, why, robot=robot.name),)
        if not wanted:
            if len(names) < 2:
                return (Notify.now(state, "it has no other camera", robot=robot.name),)
            now = camera_of(CHOSEN, robot, state) or names[0]
            number = names.index(now) + 1 if now in names else 0
            wanted = names[number % len(names)]
        return (ChooseCamera(robot=robot.name, camera=wanted),)


class ToggleNightMode(OrderWidget):
    """Has the robot see in the dark, or no longer."""

    rule: ClassVar = HandlerRule(
        section=Section.LOOK,
        says={"": "Night mode on or off"},
        meaning=(
            "Switches night mode on or off: brighter pictures, and the headlight of a robot that "
            "has one."
        ),
        sends=(NIGHT_COMMAND.name,),
    )

    def order(self, robot: RobotState, state: ConsoleState) -> tuple[Effect, ...]:
        """Night mode here and on the robot; of a robot that has none, why not."""
        if why := why_unsupported(robot, NIGHT_COMMAND.name):
            return (Notify.now(state, f"no night mode: {why}", robot=robot.name),)
        wanted = robot.name not in state.night
        command = NightCommand(on=int(wanted))
        send = SendEffect(robot=robot.name, definition=NIGHT_COMMAND, value=command)
        return (ToggleNight(robot=robot.name, on=wanted), send)
