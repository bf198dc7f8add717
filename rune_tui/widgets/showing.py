"""Widgets that change the view, and command no robot."""

from __future__ import annotations

from typing import ClassVar

from rune_tui.layout.rules import ChoiceOption, HandlerRule, NumberOption, Section, TextOption
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.effects import (
    Effect,
    FillView,
    SetTheme,
    ShowViewport,
    ToggleHelp,
    ToggleLog,
    Zoom,
)
from rune_tui.model.theme import RENAMED, THEMES
from rune_tui.widgets.stepping import SteppingWidget
from rune_tui.widgets.widget import EffectWidget, PressWidget

_NEXT = "next"
_SHOWN = {"toggle": None, "show": True, "hide": False}
_VIEWPORT = TextOption(names="viewport", meaning="which one; empty: the widget's own")


def _viewport(widget: PressWidget) -> str:
    """The viewport that the layout names, else the widget's own."""
    return widget.spec.options.word("viewport") or widget.spec.viewport


class ShowViewportWidget(EffectWidget):
    """Shows or hides a viewport."""

    rule: ClassVar = HandlerRule(
        section=Section.SCREEN,
        says={"": "{shown} {viewport}"},
        meaning="Shows or hides a viewport.",
        options={
            "viewport": _VIEWPORT,
            "shown": ChoiceOption(
                default="toggle",
                choices=tuple(_SHOWN),
                words={"toggle": "Show or hide", "show": "Show", "hide": "Hide"},
                meaning="what is wanted",
            ),
        },
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """Show or hide the viewport."""
        shown = _SHOWN[self.spec.options.word("shown")]
        return ShowViewport(viewport=_viewport(self), shown=shown)


class FullScreen(EffectWidget):
    """Shows one viewport over the whole view, and all of them again."""

    rule: ClassVar = HandlerRule(
        section=Section.SCREEN,
        says={"": "Full screen: {viewport}"},
        meaning="Shows one viewport over the whole view; again, all of them.",
        options={"viewport": _VIEWPORT},
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """Enlarge the viewport to the view, or put it back."""
        return FillView(viewport=_viewport(self))


class ZoomMap(SteppingWidget):
    """Shows the world larger or smaller."""

    rule: ClassVar = HandlerRule(
        section=Section.SCREEN,
        says={"": "Show {viewport} {direction}"},
        meaning="Shows the world larger or smaller. The value 0 shows it as the layout says.",
        options={
            "viewport": _VIEWPORT,
            "factor": NumberOption(
                default=1.25, least=1.01, most=10.0, meaning="how many times larger a press"
            ),
        },
        needs_robot=False,
        words={"": ("larger", "smaller")},
    )

    def step(self, value: float, _control: str, _state: ConsoleState) -> Effect:
        """The factor to the power of the value; 0 restores the layout's scale."""
        factor = self.spec.options.number("factor") ** value if value else 0.0
        return Zoom(viewport=_viewport(self), factor=factor)


class ThemeWidget(EffectWidget):
    """Takes other colours."""

    rule: ClassVar = HandlerRule(
        section=Section.SCREEN,
        says={"": "Colours: {theme}"},
        meaning="Takes other colours.",
        options={
            "theme": ChoiceOption(
                default=_NEXT,
                choices=(_NEXT, *THEMES),
                meaning="which; or the next of them",
                renamed=RENAMED,
                words={_NEXT: "the next theme"},
            )
        },
        needs_robot=False,
    )

    def effect(self) -> Effect:
        """The theme."""
        name = self.spec.options.word("theme")
        return SetTheme(name="" if name == _NEXT else name)


class Help(EffectWidget):
    """Shows the actions of keys."""

    rule: ClassVar = HandlerRule(
        section=Section.SCREEN,
        says={"": "This help"},
        meaning="Shows what keys, the mouse and joysticks do, and hides it again.",
        needs_robot=False,
        under_help=True,
    )

    def effect(self) -> Effect:
        """The help."""
        return ToggleHelp()


class Messages(EffectWidget):
    """Shows all events."""

    rule: ClassVar = HandlerRule(
        section=Section.SCREEN,
        says={"": "All messages, to read and to search"},
        meaning="Shows all that happened, to scroll and to search, and hides it again.",
        needs_robot=False,
        under_help=True,
    )

    def effect(self) -> Effect:
        """The page of messages."""
        return ToggleLog()
