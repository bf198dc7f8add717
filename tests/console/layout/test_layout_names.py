"""Schema, tables of names, registries and the reference page speak of the same things."""

from __future__ import annotations

import os
import re
import string
from pathlib import Path
from typing import Any

import pytest
from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual._keyboard_protocol import FUNCTIONAL_KEYS
from textual.keys import _character_to_key

from hub.gcm import catalog
from hub.gcm.capability import Capability
from rune_tui.controls.hid import usages
from rune_tui.layout import names
from rune_tui.layout.loader import schema_rules
from rune_tui.layout.rules import LOCAL_MESSAGES, HandlerRule, Option, VisualizerRule
from rune_tui.startup.opening import BUILT_IN, open_layout
from rune_tui.terminal import input_stream
from tests.support.cases import for_each

ROOT = Path(__file__).parents[3]
PATH = ROOT / "docs" / "layout-reference.md"
PAGE = PATH.read_text()
RULES = schema_rules()


def rows(heading: str) -> list[list[str]]:
    """Cells of all table rows below a heading of the page."""
    section = re.split(r"^#+ ", PAGE.split(f"\n{heading}\n", 1)[1], maxsplit=1, flags=re.MULTILINE)
    return [
        [cell.strip().strip("`") for cell in line.strip("|").split("|")]
        for line in section[0].splitlines()
        if line.startswith("| `")
    ]


def test_visualizers_and_widgets_name_messages_of_the_catalogue():
    named = set()
    for kind in BUILT_IN.visualizers.values():
        named |= {kind.rule.message, *kind.rule.others}
    for widget in BUILT_IN.widgets.values():
        named |= {*widget.rule.sends, *widget.rule.uses}
    assert named - {""} - LOCAL_MESSAGES <= set(catalog.BY_NAME)


def test_every_capability_has_an_interval():
    assert set(names.CAPABILITY_INTERVALS_MS) == {member.value for member in Capability}


def test_defaults_are_allowed():
    for _, _, option in options():
        assert option.accepts(option.shown(option.default).replace("empty", ""))


def test_the_page_has_a_section_for_every_element_and_no_other():
    assert set(re.findall(r"^### `<(\w+)>`$", PAGE, re.MULTILINE)) == set(RULES.elements)


@for_each("element", sorted(RULES.elements))
def test_the_page_lists_the_attributes_of_an_element_with_values_and_defaults(element: str):
    table = {row[0]: row[1:] for row in rows(f"### `<{element}>`") if len(row) == 3}
    attributes = RULES.elements[element].attributes
    assert set(attributes) <= set(table)
    assert not set(table) - set(attributes)
    for name, rule in attributes.items():
        value, default = table[name]
        if rule.default is not None:
            assert default == rule.default
        elif rule.required:
            assert default == ""
        allowed = RULES.values[rule.type].allowed
        if rule.type not in {"name", "text"}:
            assert allowed in value


def test_the_page_lists_every_capability():
    listed = {row[0] for row in rows("### `<capability>`") if len(row) == 2}
    assert listed == {member.value for member in Capability}


def options() -> list[tuple[str, str, Option]]:
    """Every option, with the name of its visualizer or handler and its own."""
    kinds: dict[str, Any] = {**BUILT_IN.visualizers, **BUILT_IN.widgets}
    found = [
        (owner, name, option)
        for owner, kind in kinds.items()
        for name, option in kind.rule.options.items()
    ]
    numbers = {owner: kind.rule.option for owner, kind in BUILT_IN.visualizers.items()}
    return found + [(owner, "", option) for owner, option in numbers.items() if option]


def table(*lines: tuple[str, ...]) -> str:
    head, *rest = ["| " + " | ".join(line).replace("|  |", "| |") + " |" for line in lines]
    return "\n".join([head, "|" + " --- |" * len(lines[0]), *rest])


def visualizer_line(name: str, rule: VisualizerRule) -> tuple[str, ...]:
    message = "any" if rule.any_message else f"`{rule.message}`" if rule.message else "none"
    option = f"{rule.option.allowed}: {rule.option.meaning}" if rule.option else "none"
    return f"`{name}`", message, rule.meaning, option, "what it shows" if rule.text else "none"


def handler_line(name: str, rule: HandlerRule) -> tuple[str, ...]:
    controls = ", ".join(f"`{control}`" for control in rule.controls) or "none"
    return f"`{name}`", "viewport" if rule.needs_robot else "anywhere", controls, rule.meaning


def option_line(owner: str, name: str, option: Option) -> tuple[str, ...]:
    default = f"`{option.shown(option.default)}`"
    return f"`{owner}`", f"`{name}`", option.allowed, default, option.meaning


TABLES = {
    "visualizers": table(
        ("function", "message", "what it draws", "`option`", "`text`"),
        *(visualizer_line(name, kind.rule) for name, kind in BUILT_IN.visualizers.items()),
    ),
    "handlers": table(
        ("handler", "where", "controls", "what it does"),
        *(handler_line(name, kind.rule) for name, kind in BUILT_IN.widgets.items()),
    ),
    "options": table(
        ("visualizer or handler", "option", "value", "default", "meaning"),
        *(
            (
                f"`{owner}`",
                f"`{name}`",
                option.allowed,
                f"`{option.shown(option.default)}`",
                option.meaning,
            )
            for owner, name, option in options()
            if name
        ),
    ),
}


@pytest.mark.parametrize("name", TABLES)
def test_the_page_has_the_tables_of_what_there_is(name: str):
    """RUNE_WRITE_SNAPSHOTS=1 writes them anew."""
    mark = f"<!-- {name} -->\n"
    before, _, behind = PATH.read_text().partition(mark)
    assert behind
    _, _, rest = behind.partition("\n\n")
    whole = f"{before}{mark}{TABLES[name]}\n\n{rest}"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        PATH.write_text(whole)
    assert PATH.read_text() == whole


def test_the_page_lists_every_named_key():
    section = PAGE.split("# Keys\n", 1)[1].split("\n## ", 1)[0]
    named = set(re.findall(r"`([^`]+)`", section))
    assert {key for key in names.KEYPAD_KEYS if names.KEYPAD_KEYS[key] in "./*-+="} <= named
    assert set(names.NAMED_KEYS) <= named
    assert set(names.KEYS_REPORTED_AS) <= named
    assert {"f1", "f12"} <= named


def test_the_example_of_the_page_drives_stops_and_quits(tmp_path: Path):
    example = PAGE.split("## A minimal file")[1].split("```xml\n")[1].split("```")[0]
    path = tmp_path / "example.xml"
    path.write_text(example)
    layout = open_layout(path)
    widgets = [*layout.view.widgets, *layout.view.viewports[0].widgets]
    assert [widget.handler for widget in widgets] == ["widgetQuit", "widgetSetSpeed", "widgetStop"]


def test_keys_are_named_as_textual_names_them():
    for character in string.printable.strip():
        textual = _character_to_key(character)
        assert names.canonical_key(textual) == names.canonical_key(character)
        assert names.is_key(names.canonical_key(character))
    reported = {
        getattr(key, "value", key)
        for keys in ANSI_SEQUENCES_KEYS.values()
        if isinstance(keys, tuple)
        for key in keys
    }
    plain = {key.removeprefix(names.SHIFT).removeprefix(names.ALT) for key in names.KEYS}
    letters = set(string.ascii_lowercase + string.digits)
    assert plain - set(names.KEYPAD_KEYS) - letters <= reported | set(FUNCTIONAL_KEYS.values())
    assert set(names.KEYPAD_KEYS) < {f"kp_{each}" for each in input_stream.KEYPAD}
    assert not set(names.KEYS_REPORTED_AS) & reported


@for_each("key", ["", " ", "W", "ww", "ctrl+", "ctrl+1", "f0", "f25", "\x9b"])
def test_what_no_terminal_reports_is_no_key(key: str):
    assert not names.is_key(key)


@for_each(("written", "known"), [("plus", "+"), ("W", "w"), (" ", "space"), ("CTRL+C", "ctrl+c")])
def test_a_key_that_goes_by_several_names_has_one(written: str, known: str):
    assert names.canonical_key(written) == known


@pytest.mark.parametrize(
    ("said", "name"),
    [
        (("pad", "lefty"), "joystick pad lefty"),
        (("pad", "pov", "up"), "joystick pad pov up"),
        (("pad", "righttrigger", names.PRESSED), "joystick pad righttrigger pressed"),
    ],
)
def test_inputs_of_joysticks_have_names_that_no_key_has(said: tuple[str, ...], name: str):
    assert names.joystick_input(*said) == name
    assert not names.is_key(name)


def test_layouts_and_the_decoder_of_reports_call_axes_the_same():
    assert sorted(names.AXIS_USAGES) == sorted(usages.AXES.values())


def test_the_page_lists_every_role_and_every_usage_of_axes():
    listed = set(re.findall(r"`([^`]+)`", PAGE.split("### Roles\n", 1)[1].split("\n### ", 1)[0]))
    numbered = {f"button{number}" for number in range(2, 32)}
    assert names.ROLES.keys() - numbered <= listed
    assert {*names.AXIS_USAGES, names.HAT_USAGE} <= listed
