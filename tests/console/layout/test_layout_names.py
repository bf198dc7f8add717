"""Schema, tables of names, registries and the reference page speak of the same things."""

from __future__ import annotations

import re
import string
from pathlib import Path

import pytest
from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual.keys import _character_to_key

from hub.gcm import catalog
from hub.gcm.capability import Capability
from rune_tui.layout import names
from rune_tui.layout.loader import _schema, load_layout
from rune_tui.visualizers.registry import VISUALIZERS
from rune_tui.widgets.registry import WIDGETS

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "layout-reference.md").read_text()
RULES = _schema()[0]


def rows(heading: str) -> list[list[str]]:
    """Cells of all table rows below a heading of the page."""
    section = re.split(r"^#+ ", PAGE.split(f"\n{heading}\n", 1)[1], maxsplit=1, flags=re.MULTILINE)
    return [
        [cell.strip().strip("`") for cell in line.strip("|").split("|")]
        for line in section[0].splitlines()
        if line.startswith("| `")
    ]


def test_every_handler_has_a_widget_and_every_widget_a_handler():
    assert set(WIDGETS) == set(names.HANDLERS)


def test_every_visualizer_that_layouts_may_name_exists_and_no_other():
    assert set(VISUALIZERS) == set(names.VISUALIZERS)


def test_visualizers_draw_messages_of_the_catalogue():
    drawn = {rule.message for rule in names.VISUALIZERS.values()} - {""}
    assert drawn <= set(catalog.BY_NAME)


def test_every_capability_has_an_interval():
    assert set(names.CAPABILITY_INTERVALS_MS) == {member.value for member in Capability}


def test_defaults_lie_within_their_ranges():
    options = [option for rule in names.HANDLERS.values() for option in rule.options.values()]
    options += [rule.option for rule in names.VISUALIZERS.values() if rule.option]
    for option in options:
        assert option.least <= option.default <= option.most


def test_the_page_has_a_section_for_every_element_and_no_other():
    assert set(re.findall(r"^### `<(\w+)>`$", PAGE, re.MULTILINE)) == set(RULES.elements)


@pytest.mark.parametrize("element", sorted(RULES.elements))
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


def test_the_page_lists_every_visualizer_with_its_message_and_option():
    table = {row[0]: row[1:] for row in rows("### `<visualizer>`") if len(row) == 5}
    assert set(table) == set(names.VISUALIZERS)
    for function, rule in names.VISUALIZERS.items():
        message, _, option, text = table[function]
        assert message == (rule.message or "none")
        assert (option != "none") == (rule.option is not None)
        assert (text != "none") == rule.text
        if rule.option:
            assert f"{rule.option.least:g} to {rule.option.most:g} {rule.option.unit}" in option


def test_the_page_lists_every_handler_with_its_controls():
    table = {row[0]: row[1:] for row in rows("### `<widget>`") if len(row) == 4}
    assert set(table) == set(names.HANDLERS)
    for handler, rule in names.HANDLERS.items():
        place, controls, _ = table[handler]
        assert place == ("viewport" if rule.needs_robot else "anywhere")
        assert tuple(re.findall(r"\w+", controls)) == (rule.controls or ("none",))


def test_the_page_lists_every_option_with_its_range_and_default():
    table = {(row[0], row[1]): row[2:] for row in rows("### `<option>`") if len(row) == 5}
    options = {
        (handler, name): option
        for handler, rule in names.HANDLERS.items()
        for name, option in rule.options.items()
    }
    assert set(table) == set(options)
    for key, option in options.items():
        limits, default, _ = table[key]
        assert limits == f"{option.least:g} to {option.most:g} {option.unit}".rstrip()
        assert default == f"{option.default:g}"


def test_the_page_lists_every_named_key():
    section = PAGE.split("# Keys\n", 1)[1].split("\n## ", 1)[0]
    named = set(re.findall(r"`([^`]+)`", section))
    assert set(names.NAMED_KEYS) <= named
    assert set(names.KEYS_REPORTED_AS) <= named
    assert {"f1", "f12"} <= named


def test_the_example_of_the_page_is_the_minimal_layout(tmp_path: Path):
    example = PAGE.split("```xml\n")[1].split("```")[0]
    path = tmp_path / "example.xml"
    path.write_text(example)
    assert load_layout(path).robots == load_layout(ROOT / "layouts" / "minimal.xml").robots
    assert example in (ROOT / "layouts" / "minimal.xml").read_text()


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
    assert set(names.KEYS) <= reported
    assert not set(names.KEYS_REPORTED_AS) & reported


@pytest.mark.parametrize("key", ["", " ", "W", "ww", "ctrl+", "ctrl+1", "f0", "f13", "\x9b"])
def test_what_no_terminal_reports_is_no_key(key: str):
    assert not names.is_key(key)


@pytest.mark.parametrize(
    ("written", "known"), [("plus", "+"), ("W", "w"), (" ", "space"), ("CTRL+C", "ctrl+c")]
)
def test_a_key_that_goes_by_several_names_has_one(written: str, known: str):
    assert names.canonical_key(written) == known
