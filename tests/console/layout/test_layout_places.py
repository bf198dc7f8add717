"""Places of mistakes: line and column of elements and attributes, whatever stands around them."""

from __future__ import annotations

from collections.abc import Iterator

from hypothesis import given
from hypothesis import strategies as st

from rune_tui.layout import loader
from rune_tui.layout.grammar import Node
from rune_tui.layout.places import Place, start_tags

AROUND = [
    "",
    " ",
    "\n",
    "\r\n",
    "<!-- <a b='>'> -->",
    "<?a <b c='d'?>",
    "<![CDATA[<a b='c'>]]>",
    "é",
]
NAMES = st.sampled_from(["a", "bb", "view", "x:y", "é"])
VALUES = st.sampled_from(["", "1", ">", "/>", "a='b'", "\n", "é", "\N{ROBOT FACE}"])
SPACES = st.sampled_from([" ", "\n", "\t ", "\r\n  "])


@st.composite
def elements(draw: st.DrawFn, depth: int = 3) -> str:
    """An element with attributes, text, comments and other elements in it."""
    name = draw(NAMES)
    attributes = ""
    for attribute in draw(st.lists(NAMES, unique=True, max_size=3)):
        quote, value = draw(st.sampled_from("\"'")), draw(VALUES)
        equals = draw(st.sampled_from(["=", " = ", "=\n"]))
        value = value.replace(quote, "")
        attributes += draw(SPACES) + attribute + equals + quote + value + quote
    if draw(st.booleans()) or not depth:
        return f"<{name}{attributes}/>"
    inner = draw(st.lists(elements(depth=depth - 1) | st.sampled_from(AROUND), max_size=3))
    return f"<{name}{attributes}>{''.join(inner)}</{name}>"


def all_nodes(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from all_nodes(child)


def rest(text: str, place: Place) -> str:
    """The text from a place on."""
    return "\n".join(text.split("\n")[place.line - 1 :])[place.column - 1 :]


@given(st.sampled_from(AROUND[:-2]), elements())
def test_every_element_and_attribute_is_found_where_it_stands(before: str, element: str) -> None:
    text = f"{before}<r xmlns:x='u:x'>{element}</r>"
    document = loader.parse(text, "layout.xml")
    found = list(all_nodes(loader.to_node(document, text, "layout.xml")))
    assert len(found) == sum(1 for _ in document.iter())
    for node in found:
        local = node.tag.rpartition("}")[2]
        assert rest(text, node.place).startswith((f"<{local}", f"<x:{local}"))
        assert set(node.places) == set(node.attributes)
        for attribute, place in node.places.items():
            local = attribute.rpartition("}")[2]
            assert rest(text, place).startswith((local, f"x:{local}"))
            assert rest(text, place).lstrip(f"x:{local}").lstrip().startswith("=")


def test_a_column_counts_characters_from_one() -> None:
    tags = list(start_tags("<a>\n  <é ü='\N{ROBOT FACE}' b='1'/>", "f.xml"))
    assert [tag.place for tag in tags] == [Place("f.xml", 1, 1), Place("f.xml", 2, 3)]
    assert tags[1].attributes == {"ü": Place("f.xml", 2, 6), "b": Place("f.xml", 2, 12)}
