"""Carries out what widgets want done beyond the console's own state and screen."""

from __future__ import annotations

from collections.abc import Callable

from rune_tui.compositor.cells import Cells
from rune_tui.controls.joystick_set import Joysticks
from rune_tui.files import user_files
from rune_tui.files.file_writer import Filing
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    CalibrateEffect,
    ControlEffect,
    ExportEffect,
    MissionEffect,
    NextLayoutEffect,
    RecordEffect,
    ScreenshotEffect,
    SendEffect,
)
from rune_tui.startup.following import LayoutFollower

Deed = (
    SendEffect
    | ControlEffect
    | MissionEffect
    | ScreenshotEffect
    | RecordEffect
    | ExportEffect
    | CalibrateEffect
    | NextLayoutEffect
)
"""What is done here; what concerns the screen, the console does itself."""


class Deeds:
    """Sends, files, calibrates and opens what widgets ask for."""

    def __init__(
        self,
        links: RobotLinks,
        filing: Filing,
        joysticks: Joysticks,
        layouts: LayoutFollower,
        tell: Callable[[user_files.Outcome], None],
    ) -> None:
        """Prepare.

        Args:
            links: Where messages go.
            filing: Writes files.
            joysticks: Calibrates.
            layouts: Opens the next layout.
            tell: Tells the operator what became of it.
        """
        self._links = links
        self._filing = filing
        self._joysticks = joysticks
        self._layouts = layouts
        self._tell = tell

    def do(
        self, effect: Deed, layout: LayoutSpec, state: ConsoleState, cells: Cells | None
    ) -> None:
        """Do what a widget wants.

        Args:
            effect: What that is.
            layout: What is shown.
            state: What the console knows.
            cells: What the operator sees; None before the first picture.
        """
        match effect:
            case SendEffect() | ControlEffect() | MissionEffect():
                self._send(effect)
            case ScreenshotEffect() | RecordEffect() | ExportEffect():
                self._filing.do(effect, layout, state, cells)
            case CalibrateEffect(joystick=name, control=control):
                self._joysticks.calibrate(name, control, state.now)
            case NextLayoutEffect():
                if not self._layouts.next():
                    self._tell(
                        user_files.Outcome(text="the console was started with no other layout")
                    )

    def _send(self, effect: SendEffect | ControlEffect | MissionEffect) -> None:
        link = self._links[effect.robot]
        if isinstance(effect, ControlEffect):
            link.control(effect.action, by_driving=effect.by_driving)
        elif isinstance(effect, MissionEffect):
            link.mission(effect.action, effect.name)
        else:
            link.send(effect.definition, effect.value)
        if (outcome := user_files.undelivered(effect, link.state)) is not None:
            self._tell(outcome)
