"""Keys mean the same in all layouts, and the page of layouts has all of them.

After a wanted change, write it anew: RUNE_WRITE_SNAPSHOTS=1 pytest tests/house/test_layout_keys.py
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from hub.gcm.capability import Capability
from hub.robots.registry import body_of
from hub.robots.robot_file import SHIPPED, read_description
from rune_tui.layout.actions import actions_of
from rune_tui.layout.names import JOYSTICK, MOUSE
from rune_tui.layout.rules import Section
from rune_tui.layout.spec import LayoutSpec, WidgetSpec
from rune_tui.startup.auto_layout import layout_text
from rune_tui.startup.fleet_layout import fleet_layout_text
from rune_tui.startup.opening import open_layout
from tests.support.page_tables import check_page, put_table

ROOT = Path(__file__).parents[2]
SAFETY = {
    *("widgetSetSpeed", "widgetStop", "widgetSafety", "widgetArm", "widgetDisarm", "widgetQuit"),
    *("widgetTakeControl", "widgetTakeOver", "widgetReleaseControl"),
    *("widgetGrantControl", "widgetDenyControl", "widgetAutonomy"),
}
"""Handlers whose keys mean nothing else anywhere."""


def shipped() -> dict[str, LayoutSpec]:
    return {path.stem: open_layout(path) for path in sorted((ROOT / "layouts").glob("*.xml"))}


def made(folder: Path) -> dict[str, LayoutSpec]:
    """Layouts that Rune makes: for each shipped robot, and for a fleet."""
    can = {capability.value for capability in Capability}
    robots = {path.stem: read_description(path)[0] for path in SHIPPED.glob("*.toml")}
    texts = {
        f"auto {name}": layout_text(body_of(robot), can, "tcp://127.0.0.1:1381")
        for name, robot in robots.items()
    }
    texts["fleet"] = fleet_layout_text(["rover", "blimp"], "rune/lab")
    layouts = {}
    for name, text in texts.items():
        path = folder / f"{name}.xml"
        path.write_text(text)
        layouts[name] = open_layout(path)
    return layouts


def keys_of(layout: LayoutSpec) -> Iterator[tuple[str, str]]:
    """Each key, and the handler that it wakes."""
    widgets: list[WidgetSpec] = [*layout.view.widgets]
    for viewport in layout.view.viewports:
        widgets += viewport.widgets
    for widget in widgets:
        for event in widget.events:
            if not event.name.startswith((MOUSE, JOYSTICK)):
                yield event.name, widget.handler


def test_a_key_that_drives_stops_arms_or_is_about_control_means_nothing_else_anywhere(
    tmp_path: Path,
) -> None:
    uses: defaultdict[str, defaultdict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for name, layout in (shipped() | made(tmp_path)).items():
        for key, handler in keys_of(layout):
            uses[key][handler].add(name)
    assert {"f8", "f9", "space", "0"} <= uses.keys()
    clashes = {
        key: {handler: sorted(names) for handler, names in handlers.items()}
        for key, handlers in uses.items()
        if len(handlers) > 1 and SAFETY & handlers.keys()
    }
    assert clashes == {}


def test_the_page_of_layouts_has_all_their_keys() -> None:
    layouts = shipped()
    rows: defaultdict[tuple[int, str], defaultdict[str, set[str]]]
    rows = defaultdict(lambda: defaultdict(set))
    sections = list(Section)
    for name, layout in layouts.items():
        for action in actions_of(layout):
            for key in filter(_shown_keys(layout).__contains__, action.inputs):
                rows[sections.index(action.section), action.words][key].add(name)
    lines = (ROOT / "docs/layouts.md").read_text().splitlines()
    table = []
    for (_, words), keys in sorted(rows.items(), key=lambda row: row[0][0]):
        groups: defaultdict[frozenset[str], list[str]] = defaultdict(list)
        for key, users in keys.items():
            groups[frozenset(users)].append(key)
        for names, same in groups.items():
            missing = layouts.keys() - names
            where = ", ".join(sorted(names))
            if not missing:
                where = "all"
            elif len(missing) < len(names):
                where = f"all but {', '.join(sorted(missing))}"
            shown = " ".join(f"`{key}`" for key in same)
            table.append(f"| {shown} | {words} | {where} |")
    put_table(lines, "These are all keys", table)
    check_page(ROOT / "docs/layouts.md", lines)


def _shown_keys(layout: LayoutSpec) -> set[str]:
    """The keys of a layout as its help shows them."""
    bound = {key for key, _ in keys_of(layout)}
    return {key.upper() if len(key) == 1 else key for key in bound}
