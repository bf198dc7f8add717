"""From the elements of a faultless layout file to its frozen specs."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from hub.hub_sockets import NAMED, PREFERRED
from hub.ipc.endpoints import endpoint_of
from rune_tui.layout import names
from rune_tui.layout.checks import viewport_robot
from rune_tui.layout.grammar import Mistake, Node, Rules
from rune_tui.layout.inputs import inputs_of
from rune_tui.layout.joysticks import Input, JoystickNodes
from rune_tui.layout.rules import LOCAL_MESSAGES, HandlerRule, Option, Options, Vocabulary
from rune_tui.layout.spec import (
    CHOSEN,
    ArrangementSpec,
    CapabilitySpec,
    EventSpec,
    FontSpec,
    LayoutSpec,
    PlaceSpec,
    RobotSpec,
    ViewportSpec,
    ViewSpec,
    VisualizerSpec,
    WidgetSpec,
)

_logger = logging.getLogger(__name__)

_LONGEST_REASON = 200


class SpecBuilder:
    """Builds specs; the caller has checked the file.

    Attributes:
        mistakes: Visualizers and widgets that refuse their values in the layout.
        notes: Changes that the author should make some time, a sentence each.
    """

    def __init__(
        self, rules: Rules, path: str, vocabulary: Vocabulary, fonts: Mapping[str, FontSpec]
    ) -> None:
        self._fonts = fonts
        self._rules = rules
        self._path = path
        self._vocabulary = vocabulary
        self._robots: tuple[str, ...] = ()
        self._joysticks = JoystickNodes((), rules)
        self.mistakes: list[Mistake] = []
        self.notes: list[str] = []

    def layout(self, root: Node, files: tuple[Path, ...]) -> LayoutSpec:
        """The whole layout, which these files make up."""
        self._robots = tuple(self._text(robot, "name") for robot in root.of("robot"))
        self._joysticks = JoystickNodes(root.of("joystick"), self._rules)
        (node,) = root.of("view")
        view = self._view(node)
        widgets = [
            widget for owner in (node, *node.of("viewport")) for widget in owner.of("widget")
        ]
        return LayoutSpec(
            path=self._path,
            run_number=self._whole(root, "run"),
            robots=tuple(self._robot(robot, view) for robot in root.of("robot")),
            view=view,
            joysticks=self._joysticks.specs(
                event for widget in widgets for event in widget.of("event")
            ),
            files=files,
            notes=tuple(self.notes),
            vocabulary=self._vocabulary,
        )

    def _text(self, node: Node, attribute: str) -> str:
        return self._rules.value(node, attribute) or ""

    def _file(self, name: str) -> str:
        """The path of a file that the layout names: in its folder, the user's, or a whole path."""
        return str(Path(self._path).parent / Path(name).expanduser()) if name else ""

    def _whole(self, node: Node, attribute: str) -> int:
        return int(self._text(node, attribute))

    def _decimal(self, node: Node, attribute: str) -> float:
        return float(self._text(node, attribute))

    def _robot(self, node: Node, view: ViewSpec) -> RobotSpec:
        name = self._text(node, "name")
        viewports = [viewport for viewport in view.viewports if viewport.robot in {name, CHOSEN}]
        widgets = [widget for viewport in viewports for widget in viewport.widgets]
        rules = [self._vocabulary.widgets[widget.handler].rule for widget in widgets]
        drawn = {message for viewport in viewports for message in self._drawn(viewport)}
        return RobotSpec(
            name=name,
            hub=self._hub(endpoint_of(self._text(node, "hub")), name),
            keys=self._file(self._text(node, "keys")),
            fleet=self._text(node, "fleet"),
            capabilities=tuple(map(self._capability, node.of("capability"))),
            messages=frozenset(drawn.union(*(rule.uses for rule in rules))),
            commands=frozenset().union(*(rule.sends for rule in rules)),
        )

    @staticmethod
    def _hub(endpoint: str, robot: str) -> str:
        """An endpoint; where any hub will do, that of the robot's name comes first."""
        return f"{NAMED}{PREFERRED}{robot}" if endpoint == NAMED else endpoint

    def _drawn(self, viewport: ViewportSpec) -> Iterator[str]:
        """Names of the messages that a viewport's visualizer makes use of."""
        if viewport.visualizer:
            rule = self._vocabulary.visualizers[viewport.visualizer.function].rule
            drawn = filter(None, (viewport.visualizer.message, *rule.others))
            yield from (message for message in drawn if message not in LOCAL_MESSAGES)

    def _capability(self, node: Node) -> CapabilitySpec:
        name = self._text(node, "name")
        interval = self._rules.value(node, "interval_ms")
        milliseconds = names.CAPABILITY_INTERVALS_MS[name] if interval is None else int(interval)
        return CapabilitySpec(name=name, interval_s=milliseconds / 1000)

    def _view(self, node: Node) -> ViewSpec:
        viewports = {self._text(each, "name"): each for each in node.of("viewport")}
        own = (
            ArrangementSpec(
                xsize=self._whole(node, "xsize"),
                ysize=self._whole(node, "ysize"),
                places=tuple(self._place(each, name, each) for name, each in viewports.items()),
            )
            if not node.of("arrangement")
            else None
        )
        return ViewSpec(
            background=self._background(node),
            viewports=tuple(map(self._viewport, viewports.values())),
            widgets=tuple(map(self._widget, node.of("widget"))),
            arrangements=(own,)
            if own
            else tuple(self._arrangement(each, viewports) for each in node.of("arrangement")),
        )

    def _arrangement(self, node: Node, viewports: Mapping[str, Node]) -> ArrangementSpec:
        names_of = ((place, self._text(place, "viewport")) for place in node.of("place"))
        return ArrangementSpec(
            name=self._text(node, "name"),
            min_columns=self._whole(node, "min-columns"),
            min_rows=self._whole(node, "min-rows"),
            xsize=self._whole(node, "xsize"),
            ysize=self._whole(node, "ysize"),
            places=tuple(self._place(each, name, viewports[name]) for each, name in names_of),
        )

    def _place(self, node: Node, viewport: str, otherwise: Node) -> PlaceSpec:
        """The place of a viewport; the viewport's own attributes fill in missing ones."""

        def how(attribute: str) -> str:
            given = self._rules.value(node, attribute)
            return self._text(otherwise, attribute) if given is None else given

        return PlaceSpec(
            viewport=viewport,
            visible=how("visible") == "true",
            transparency=int(how("transparency")),
            xpos=self._whole(node, "xpos"),
            ypos=self._whole(node, "ypos"),
            zpos=int(how("zpos")),
            xsize=self._whole(node, "xsize"),
            ysize=self._whole(node, "ysize"),
            scaled=how("fit") == "scale",
        )

    def _background(self, node: Node) -> tuple[int, int, int] | None:
        given = self._text(node, "background")
        if not given:
            return None
        red, green, blue = bytes.fromhex(given.removeprefix("#"))
        return red, green, blue

    def _viewport(self, node: Node) -> ViewportSpec:
        name = self._text(node, "name")
        visualizers = tuple(self._visualizer(child, name) for child in node.of("visualizer"))
        robot = viewport_robot(node, self._robots, self._rules)
        return ViewportSpec(
            name=name,
            title=self._text(node, "title"),
            robot=robot,
            visualizer=visualizers[0] if visualizers else None,
            widgets=tuple(self._widget(child, robot, name) for child in node.of("widget")),
        )

    def _visualizer(self, node: Node, viewport: str) -> VisualizerSpec:
        function = self._text(node, "function")
        rule = self._vocabulary.visualizers[function].rule
        spec = VisualizerSpec(
            function=function,
            message=self._text(node, "message") or rule.message,
            option=self._decimal(node, "option"),
            text=self._text(node, "text"),
            options=self._options(node, rule.options),
            viewport=viewport,
            font=self._fonts.get(self._text(node, "font")),
        )
        self._try(node, "function", self._vocabulary.visualizers[function].from_spec, spec)
        return spec

    def _try(self, node: Node, name: str, make: Callable[..., object], *said: object) -> None:
        """Make each part of a layout once, so that none fails in use."""
        try:
            make(*said)
        except Exception as error:  # an extension may fail in any way
            reason = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST_REASON]
            message = f"{node.attributes[name]} cannot be made: {reason}"
            _logger.debug("%s", message, exc_info=True)
            self.mistakes.append(Mistake(node.at(name), message))

    def _widget(self, node: Node, robot: str = "", viewport: str = "") -> WidgetSpec:
        handler = self._text(node, "handler")
        rule = self._vocabulary.widgets[handler].rule
        spec = WidgetSpec(
            handler=handler,
            options=self._options(node, rule.options),
            events=tuple(
                self._event(event, each, rule)
                for event in node.of("event")
                for each in inputs_of(event, self._rules, self._joysticks)
            ),
            viewport=viewport,
        )
        self._try(node, "handler", self._vocabulary.widgets[handler].from_spec, spec, robot)
        return spec

    def _options(self, node: Node, rules: Mapping[str, Option]) -> Options:
        given = {self._text(each, "name"): self._text(each, "value") for each in node.of("option")}
        for name, text in given.items():
            if text != (now := rules[name].value(text)) and isinstance(now, str):
                where = f"line {node.place.line}: the {name} {text}"
                self.notes.append(f'{where} is now called {now}; write value="{now}"')
        return Options.of(rules, {name: rules[name].value(text) for name, text in given.items()})

    def _event(self, node: Node, wanted: Input, rule: HandlerRule) -> EventSpec:
        control, value = self._text(node, "control"), self._decimal(node, "value")
        if wanted.pushed and rule.plane:
            across, along = rule.plane
            control = across if wanted.pushed in {"left", "right"} else along
            value = -value if wanted.pushed in {"right", "down"} else value
        return EventSpec(
            name=wanted.name,
            control=control,
            value=value,
            line=node.place.line,
            released=self._text(node, "when") == "released",
            kind=wanted.kind,
        )
