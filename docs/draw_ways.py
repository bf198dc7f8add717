"""Draws the two ways through Rune as pictures of the architecture page: python -m docs.draw_ways.

It needs the tools of the tests, which `make setup` installs.

A way is a list of files. What joins one file to the next is found in the imports: one imports the
other, a third puts both together, or two processes share the definition of a message. A file that
is gone, or that nothing joins to the next, ends the script with an error.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from typing import Final
from xml.sax.saxutils import escape

import grimp

from hub.values import dataclass

ROOT: Final = Path(__file__).parents[1]
_IMAGES: Final = ROOT / "docs" / "images"
_GRAPH: Final = grimp.build_graph("hub", "rune_tui")


@dataclass(frozen=True, slots=True, kw_only=True)
class Process:
    """The part of a way inside one process.

    Attributes:
        name: What the picture calls it.
        colour: Of its boxes.
        modules: Files of the way, in the order of the data.
    """

    name: str
    colour: str
    modules: tuple[str, ...]


UP: Final = (
    Process(
        name="vision, on the robot",
        colour="#dcead8",
        modules=(
            "hub.robots.interfaces",
            "hub.robots.registry",
            "hub.modules.vision.__main__",
            "hub.ipc.client",
            "hub.ipc.node.publisher",
            "hub.ipc.node.send_queue",
            "hub.ipc.node.direct_sockets",
        ),
    ),
    Process(
        name="the console",
        colour="#d8e4f0",
        modules=(
            "hub.ipc.node.receive_queue",
            "hub.ipc.node.subscription",
            "hub.ipc.node.subscriptions",
            "hub.ipc.node.session",
            "hub.ipc.node.base_client",
            "hub.ipc.client",
            "rune_tui.link.picture_stream",
            "rune_tui.link.camera_streams",
            "rune_tui.link.robot_link",
            "rune_tui.link.pictures",
            "rune_tui.model.robot_state",
            "rune_tui.view",
            "rune_tui.drawn_viewport",
            "rune_tui.visualizers.visualizer",
            "rune_tui.visualizers.video.camera_image",
            "rune_tui.raster.canvas",
            "rune_tui.compositor.blend",
            "rune_tui.compositor.cells",
            "rune_tui.compositor.seen_pictures",
            "rune_tui.compositor.looks",
            "rune_tui.compositor.screen_encoder",
            "rune_tui.terminal.block_output",
            "rune_tui.compositor.output",
            "rune_tui.ui.painter",
        ),
    ),
)
DOWN: Final = (
    Process(
        name="the console",
        colour="#d8e4f0",
        modules=(
            "rune_tui.terminal.input_stream",
            "rune_tui.ui.input_events",
            "rune_tui.controls.keyboard",
            "rune_tui.controls.events",
            "rune_tui.dispatch",
            "rune_tui.widgets.widget",
            "rune_tui.widgets.speed",
            "rune_tui.model.effects",
            "rune_tui.effect_runner",
            "rune_tui.link.robot_links",
            "rune_tui.link.robot_link",
        ),
    ),
    Process(
        name="navigation, on the robot",
        colour="#f0e6d2",
        modules=(
            "hub.modules.navigation.__main__",
            "hub.control_gate",
            "hub.modules.navigation.speed_governor",
            "hub.modules.navigation.dynamic_window",
        ),
    ),
    Process(
        name="the driver, on the robot",
        colour="#dcead8",
        modules=(
            "hub.modules.driver.__main__",
            "hub.modules.driver.watchdog",
            "hub.robots.registry",
            "hub.robots.interfaces",
        ),
    ),
)
WAYS: Final = {
    "way-up.svg": ("UP: a picture, from the camera to the terminal", UP),
    "way-down.svg": ("DOWN: a key, from the terminal to the wheels", DOWN),
}

_WIDTH, _BOX, _STEP, _LEFT, _TOP = 860, 40, 66, 150, 50
_FONT = 'font-family="DejaVu Sans, Verdana, sans-serif"'


def path_of(module: str) -> str:
    """The file of a module, from the root of the project."""
    return module.replace(".", "/") + ".py"


def meaning_of(module: str) -> str:
    """The first sentence of a module's docstring."""
    docstring = ast.get_docstring(ast.parse((ROOT / path_of(module)).read_text("utf-8"))) or ""
    return " ".join(docstring.split("\n\n")[0].split()).split(". ")[0].rstrip(".")


def joint(first: str, second: str) -> str:
    """What joins two files of one process, by the imports.

    Raises:
        LookupError: Nothing does.
    """
    if second in _GRAPH.find_modules_directly_imported_by(first):
        return f"{_short(first)} imports {_short(second)}"
    if first in _GRAPH.find_modules_directly_imported_by(second):
        return f"{_short(second)} imports {_short(first)}"
    users = _GRAPH.find_modules_that_directly_import(first)
    both = users & _GRAPH.find_modules_that_directly_import(second)
    if not both:
        text = f"no import joins {path_of(first)} to {path_of(second)}; mend the way in this script"
        raise LookupError(text)
    return f"{_short(min(both, key=lambda each: (len(each), each)))} joins both"


def messages(sender: Process, receiver: Process) -> str:
    """The files of `hub.gcm` whose messages two processes share.

    Raises:
        LookupError: There are none.
    """
    both = _definitions(sender) & _definitions(receiver)
    if not both:
        text = f"{sender.name} and {receiver.name} share no message; mend the way in this script"
        raise LookupError(text)
    return "central or a direct socket; messages of hub/gcm: " + ", ".join(sorted(both))


def _definitions(process: Process) -> set[str]:
    used = set().union(*map(_GRAPH.find_modules_directly_imported_by, process.modules))
    names = {each.removeprefix("hub.gcm.") for each in used if each.startswith("hub.gcm.")}
    return names - {"common", "catalog", "fields", "providers", "capability"}


def _short(module: str) -> str:
    return "/".join(module.split(".")[-2:]) + ".py"


def _text(x: int, y: int, text: str, *, size: int, style: str = "") -> str:
    return f'<text x="{x}" y="{y}" {_FONT} font-size="{size}" {style}>{escape(text)}</text>'


def _arrow(y: int, text: str, *, dashed: bool = False) -> list[str]:
    """From the lower edge of the box above `y` down to the next one."""
    dashes = ' stroke-dasharray="5 4"' if dashed else ""
    end = y + _STEP - _BOX
    return [
        f'<path d="M {_LEFT + 40} {y} V {end - 3}" stroke="#333" stroke-width="2"{dashes}'
        ' marker-end="url(#head)"/>',
        _text(_LEFT + 54, y + 17, text, size=11, style='fill="#555"'),
    ]


def drawn(title: str, way: tuple[Process, ...]) -> str:
    """A way as SVG."""
    parts: list[str] = []
    y, before = _TOP, None
    for process in way:
        top = y if before is None else y + _STEP - _BOX
        if before is not None:
            parts += _arrow(y, messages(before, process), dashed=True)
            y = top
        for number, module in enumerate(process.modules):
            if number:
                parts += _arrow(y, joint(process.modules[number - 1], module))
                y += _STEP - _BOX
            parts.append(
                f'<rect x="{_LEFT}" y="{y}" width="{_WIDTH - _LEFT - 10}" height="{_BOX}" rx="5"'
                f' fill="{process.colour}" stroke="#777"/>'
            )
            bold = 'font-weight="bold"'
            parts.append(_text(_LEFT + 10, y + 16, path_of(module), size=13, style=bold))
            parts.append(_text(_LEFT + 10, y + 33, meaning_of(module), size=11))
            y += _BOX
        parts.append(f'<path d="M {_LEFT - 12} {top} V {y}" stroke="#777" stroke-width="3"/>')
        for row, words in enumerate(process.name.split(", ")):
            parts.append(_text(10, (top + y) // 2 + 16 * row, words, size=13))
        before = process
    marker = (
        '<defs><marker id="head" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="7"'
        ' markerHeight="7" orient="auto"><path d="M 0 0 L 8 4 L 0 8 z" fill="#333"/>'
        "</marker></defs>"
    )
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{y + 12}">',
        marker,
        f'<rect width="{_WIDTH}" height="{y + 12}" fill="white"/>',
        _text(10, 28, title, size=16, style='font-weight="bold"'),
    ]
    return "\n".join([*head, *parts, "</svg>"]) + "\n"


def pictures() -> dict[Path, str]:
    """What the files of the pictures are to hold.

    Raises:
        LookupError: A way goes where no import does.
        OSError: A file of a way is gone.
    """
    return {_IMAGES / name: drawn(*way) for name, way in WAYS.items()}


if __name__ == "__main__":
    for path, picture in pictures().items():
        path.write_text(picture, "utf-8")
        sys.stdout.write(f"{path.relative_to(ROOT)}\n")
