"""From the elements of a faultless layout file to its frozen specs."""

from __future__ import annotations

from rune_tui.layout import names
from rune_tui.layout.checks import viewport_robot
from rune_tui.layout.grammar import Node, Rules
from rune_tui.layout.spec import (
    CapabilitySpec,
    EventSpec,
    LayoutSpec,
    RobotSpec,
    ViewportSpec,
    ViewSpec,
    VisualizerSpec,
    WidgetSpec,
)


class SpecBuilder:
    """Builds specs; the caller has checked the file."""

    def __init__(self, rules: Rules, path: str) -> None:
        self._rules = rules
        self._path = path
        self._robots: tuple[str, ...] = ()

    def layout(self, root: Node) -> LayoutSpec:
        """The whole file."""
        robots = tuple(map(self._robot, root.of("robot")))
        self._robots = tuple(robot.name for robot in robots)
        (view,) = root.of("view")
        return LayoutSpec(
            path=self._path,
            run_number=self._whole(root, "run"),
            robots=robots,
            view=self._view(view),
        )

    def _text(self, node: Node, attribute: str) -> str:
        return self._rules.value(node, attribute) or ""

    def _whole(self, node: Node, attribute: str) -> int:
        return int(self._text(node, attribute))

    def _decimal(self, node: Node, attribute: str) -> float:
        return float(self._text(node, attribute))

    def _robot(self, node: Node) -> RobotSpec:
        return RobotSpec(
            name=self._text(node, "name"),
            hub=self._text(node, "hub"),
            capabilities=tuple(map(self._capability, node.of("capability"))),
        )

    def _capability(self, node: Node) -> CapabilitySpec:
        name = self._text(node, "name")
        interval = self._rules.value(node, "interval_ms")
        milliseconds = names.CAPABILITY_INTERVALS_MS[name] if interval is None else int(interval)
        return CapabilitySpec(name=name, interval_s=milliseconds / 1000)

    def _view(self, node: Node) -> ViewSpec:
        red, green, blue = bytes.fromhex(self._text(node, "background").removeprefix("#"))
        return ViewSpec(
            xsize=self._whole(node, "xsize"),
            ysize=self._whole(node, "ysize"),
            background=(red, green, blue),
            viewports=tuple(map(self._viewport, node.of("viewport"))),
            widgets=tuple(map(self._widget, node.of("widget"))),
        )

    def _viewport(self, node: Node) -> ViewportSpec:
        visualizers = tuple(map(self._visualizer, node.of("visualizer")))
        return ViewportSpec(
            name=self._text(node, "name"),
            robot=viewport_robot(node, self._robots, self._rules),
            visible=self._text(node, "visible") == "true",
            transparency=self._whole(node, "transparency"),
            xpos=self._whole(node, "xpos"),
            ypos=self._whole(node, "ypos"),
            zpos=self._whole(node, "zpos"),
            xsize=self._whole(node, "xsize"),
            ysize=self._whole(node, "ysize"),
            scaled=self._text(node, "fit") == "scale",
            visualizer=visualizers[0] if visualizers else None,
            widgets=tuple(map(self._widget, node.of("widget"))),
            line=node.line,
        )

    def _visualizer(self, node: Node) -> VisualizerSpec:
        function = self._text(node, "function")
        return VisualizerSpec(
            function=function,
            message=names.VISUALIZERS[function].message,
            option=self._decimal(node, "option"),
            text=self._text(node, "text"),
            line=node.line,
        )

    def _widget(self, node: Node) -> WidgetSpec:
        options = node.of("option")
        return WidgetSpec(
            handler=self._text(node, "handler"),
            options=tuple(
                (self._text(option, "name"), self._decimal(option, "value")) for option in options
            ),
            events=tuple(map(self._event, node.of("event"))),
            line=node.line,
        )

    def _event(self, node: Node) -> EventSpec:
        return EventSpec(
            key=names.canonical_key(self._text(node, "key")),
            control=self._text(node, "control"),
            value=self._decimal(node, "value"),
            line=node.line,
        )
