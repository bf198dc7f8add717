"""The schema in RELAX NG's compact form, for people and for editors that read it."""

from __future__ import annotations

import importlib.resources
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from lxml import etree

from tests.support.layouts import relax_ng

PATH = Path(__file__).parents[3] / "docs" / "layout-schema.rnc"
RNG = "{http://relaxng.org/ns/structure/1.0}"
ANNOTATIONS = "{http://relaxng.org/ns/compatibility/annotations/1.0}"
HEAD = """# What a layout file may hold, and a part of layouts; made of rune_tui/layout/schema.rng.
namespace a = "http://relaxng.org/ns/compatibility/annotations/1.0"
datatypes xsd = "http://www.w3.org/2001/XMLSchema-datatypes"
"""
MARKS = {"optional": "?", "zeroOrMore": "*", "oneOrMore": "+"}
JOINTS = {"interleave": " & ", "choice": " | "}


def identifier(name: str) -> str:
    """A name as the compact form wants it: words of its own have a backslash in front."""
    return f"\\{name}" if name in {"text", "include", "start", "element", "string"} else name


def compact(node: etree._Element) -> str:
    """A pattern in compact form."""
    kind = str(node.tag).removeprefix(RNG)
    if kind == "data":
        params = " ".join(f'{param.get("name")} = "{param.text}"' for param in node)
        return f"xsd:{node.get('type')}" + (f" {{ {params} }}" if params else "")
    parts = [compact(child) for child in node if str(child.tag).startswith(RNG)]
    if kind in MARKS:
        (inner,) = parts
        # An annotation binds to the one pattern behind it, so what has one needs parentheses.
        return f"({inner}){MARKS[kind]}" if inner.startswith("[") else inner + MARKS[kind]
    if kind in JOINTS:
        return JOINTS[kind].join(parts)
    if kind in ("element", "attribute"):
        default = node.get(f"{ANNOTATIONS}defaultValue")
        note = "" if default is None else f'[ a:defaultValue = "{default}" ] '
        joint = ",\n  " if kind == "element" else ""
        grouped = [f"({part})" if " & " in part and len(parts) > 1 else part for part in parts]
        inner = joint.join(part for part in grouped if part != "empty") or "empty"
        if kind == "element":
            return f"{note}element {node.get('name')} {{\n  {inner}\n}}"
        return f"{note}attribute {node.get('name')} {{ {inner} }}"
    if kind == "ref":
        return identifier(str(node.get("name")))
    if kind == "value":
        return f'xsd:string "{node.text}"'
    assert kind == "empty", f"the compact form of {kind} is not known here"
    return "empty"


def lines(grammar: etree._Element) -> Iterator[str]:
    yield HEAD
    for node in grammar:
        patterns = [child for child in node if str(child.tag).startswith(RNG)]
        for note in node.findall(f"{ANNOTATIONS}documentation"):
            yield f"## {note.text}"
        name = "start" if node.get("name") is None else identifier(str(node.get("name")))
        yield f"{name} = {compact(patterns[0])}"


def test_the_compact_schema_is_the_schema() -> None:
    """RUNE_WRITE_SNAPSHOTS=1 writes it anew."""
    data = importlib.resources.files("rune_tui.layout").joinpath("schema.rng").read_bytes()
    grammar = etree.fromstring(data, etree.XMLParser(remove_comments=True))
    text = "\n".join(lines(grammar)) + "\n"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        PATH.write_text(text)
    assert PATH.read_text() == text


def test_the_schema_allows_what_the_shipped_layouts_hold() -> None:
    """Editors validate with the schema alone, without the console's rules."""
    validator = relax_ng()
    for path in (PATH.parents[1] / "layouts").glob("*.xml"):
        assert validator.validate(etree.parse(path))


LAYOUTS = sorted(
    path
    for folder in ("layouts", "studies", "rune_study")
    for path in (PATH.parents[1] / folder).rglob("*.xml")
)


needs_xmllint = pytest.mark.skipif(shutil.which("xmllint") is None, reason="xmllint is missing")


def said_of(*layouts: Path) -> str:
    """What the command in the docs says of layouts."""
    command = ["xmllint", "--noout", "--relaxng", PATH.parents[1] / "rune_tui/layout/schema.rng"]
    return subprocess.run([*command, *layouts], capture_output=True, text=True, check=False).stderr


@needs_xmllint
def test_xmllint_takes_every_layout() -> None:
    """Its expressions are those of XML Schema, and stricter than those of Python."""
    said = said_of(*LAYOUTS)
    assert len(LAYOUTS) > 10
    assert said.count(" validates\n") == len(LAYOUTS) == said.count("\n"), said


@needs_xmllint
def test_xmllint_refuses_what_is_no_variable(tmp_path: Path) -> None:
    for number, run in enumerate(("x", "$", "${", "${1}", "$x{y}")):
        path = tmp_path / f"{number}.xml"
        path.write_text(LAYOUTS[0].read_text().replace('run="1"', f'run="{run}"', 1))
        assert "fails to validate" in said_of(path), run
