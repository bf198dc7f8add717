"""Reads a layout file: bytes to XML to specs, with every mistake of the file at once.

Only this file uses the XML library. Files are not trusted: no DTD, no entity, no network, and a
limit on the size.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib.resources
import itertools
import logging
import re
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path

from lxml import etree

from hub.plain_text import plain
from rune_tui.errors import LayoutError, LayoutProblem
from rune_tui.layout.building import SpecBuilder
from rune_tui.layout.checks import find_mistakes
from rune_tui.layout.extensions import extended, refused_extensions
from rune_tui.layout.fonts import named_fonts
from rune_tui.layout.grammar import Mistake, Node, Rules, read_rules
from rune_tui.layout.parts import Assembly
from rune_tui.layout.places import Place, start_tags
from rune_tui.layout.rules import Vocabulary
from rune_tui.layout.spec import LayoutSpec

_logger = logging.getLogger(__name__)

LARGEST_FILE = 1024 * 1024
"""Bytes of a layout file, and of it and its parts together; a large one has a few thousand."""

_MOST_ELEMENTS = 20_000
"""Elements that a file may have; a large layout has a few hundred."""

_DEEPEST = 16
"""Most levels of elements; valid layouts have five, the schema eight."""

_MOST_ATTRIBUTES = 100
"""Most attributes of an element; the schema allows 11, and the check is quadratic."""

# Atomic and possessive, so that a hostile file cannot make the search backtrack.
_DOCTYPE = re.compile(r"(?>\s|<\?(?>.*?\?>)|<!--(?>.*?-->))*+<!DOCTYPE", re.DOTALL)


def load_layout(
    path: str | Path,
    vocabulary: Vocabulary,
    variables: Mapping[str, str] | None = None,
    *,
    trusted: bool = True,
) -> LayoutSpec:
    """Read and check a layout file and the parts that it includes.

    Args:
        path: The file.
        vocabulary: The visualizers and widgets there are without the layout's own extensions.
        variables: Values of the layout's variables that are not those of the file.
        trusted: Whether the operator chose the layout; else none of its extensions run.

    Raises:
        LayoutError: A file cannot be read or has mistakes; all of them are listed.
    """
    path = Path(path)
    rules = schema_rules()

    def read(file: Path) -> tuple[Node, int]:
        text = _read_text(file, str(file))
        return to_node(parse(text, str(file)), text, str(file)), len(text)

    root, size = read(path)
    if root.tag != rules.root:
        raise _error(rules.mistakes(root))
    assembly = Assembly(rules, read, path, largest=LARGEST_FILE)
    root = assembly.whole(root, size, variables or {})
    mistakes = [*assembly.mistakes, *rules.mistakes(root)]
    if not trusted and (refused := refused_extensions(root)):
        raise _error(refused)
    vocabulary, scripts, wrong = extended(vocabulary, root, rules, path.parent)
    fonts, letters, unreadable = named_fonts(root, rules, path.parent)
    mistakes += [*wrong, *unreadable]
    mistakes += find_mistakes(root, rules, vocabulary)
    files = (*assembly.files, *scripts, *letters)
    if mistakes:
        raise _error(_traced(mistakes, assembly.given), files)
    builder = SpecBuilder(rules, str(path), vocabulary, fonts)
    layout = builder.layout(root, files)
    for note in builder.notes:
        _logger.warning("%s: %s", path, note)
    if builder.mistakes:
        raise _error(_traced(builder.mistakes, assembly.given), files)
    return dataclasses.replace(layout, variables=tuple((variables or {}).items()))


def _traced(mistakes: Iterable[Mistake], given: Mapping[Place, str]) -> list[Mistake]:
    """The mistakes; those at a value of `--set` name that option."""
    return [
        dataclasses.replace(each, message=f"{each.message}; that is from --set {source}")
        if (source := given.get(each.place))
        else each
        for each in mistakes
    ]


def _error(mistakes: Iterable[Mistake], files: tuple[Path, ...] = ()) -> LayoutError:
    return LayoutError([_problem(mistake) for mistake in mistakes], files)


def _refusal(shown: str, message: str, line: int = 0, column: int = 0) -> LayoutError:
    return _error([Mistake(Place(shown, line, column), message)])


def _problem(mistake: Mistake) -> LayoutProblem:
    # Names of and in the file reach the operator's terminal, so nothing in them may control it.
    place, message = mistake.place, plain(mistake.message)
    return LayoutProblem(
        path=plain(place.path), line=place.line, column=place.column, message=message
    )


def _read_text(path: Path, shown: str) -> str:
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise _refusal(shown, "this is a directory; name a layout file in it")
        if not stat.S_ISREG(mode):
            raise _refusal(shown, "this is not a regular file; name a layout file")
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except FileNotFoundError as error:
        message = "there is no such file; check the path, or name a layout that comes with Rune, "
        raise _refusal(shown, message + "such as demo") from error
    except PermissionError as error:
        raise _refusal(shown, "the file may not be read; check its permissions") from error
    except OSError as error:
        message = f"the file cannot be read: {error.strerror or error}"
        raise _refusal(shown, message) from error
    except UnicodeEncodeError as error:
        raise _refusal(ascii(shown), "this is no path: it holds a broken character") from error
    except ValueError as error:
        if isinstance(error, LayoutError):
            raise
        raise _refusal(shown, "this is no path: it holds a zero byte") from error
    if len(data) > LARGEST_FILE:
        message = f"the file is larger than {LARGEST_FILE} bytes; a layout is a few thousand long"
        raise _refusal(shown, message)
    return decode(data, shown)


def decode(data: bytes, shown: str) -> str:
    """The text of a file."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = error.start - (data.rfind(b"\n", 0, error.start) + 1) + 1
        message = f"byte 0x{data[error.start]:02x} is not UTF-8; save the file as UTF-8"
        raise _refusal(shown, message, line, column) from error


def parse(text: str, shown: str) -> etree._Element:
    """The elements of a text, without those that could harm the reader."""
    if found := _DOCTYPE.match(text):
        start = found.end() - len("<!DOCTYPE")
        line, column = text.count("\n", 0, start) + 1, start - text.rfind("\n", 0, start)
        message = "a document type (<!DOCTYPE ...>) is not allowed in a layout; remove it"
        raise _refusal(shown, message, line, column)
    if not text.strip():
        raise _refusal(shown, "the file is empty; a layout is one <rune> element")
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        load_dtd=False,
        no_network=True,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return etree.fromstring(text.encode(), parser)
    except etree.XMLSyntaxError as error:
        line, column = error.position
        message = f"this is not well-formed XML: {_plain(error.msg or '')}"
        raise _refusal(shown, message, line or 1, max(column, 0)) from error


_PLAIN = (
    (
        r"Opening and ending tag mismatch: (\S+) line (\d+) and (\S+)",
        r"</\3> ends <\1>, which line \2 opened",
    ),
    (r"Premature end of data in tag (\S+) line (\d+)", r"<\1> of line \2 has no end tag"),
    (r"Start tag expected, '<' not found", "the file must begin with an element"),
    (r"Extra content at the end of the document", "something follows the end of </rune>"),
    (r"EntityRef: expecting ';'", "a plain & must be written &amp;"),
    (r"xmlParseEntityRef: no name", "a plain & must be written &amp;"),
    (r"Entity '(.*)' not defined", r"the entity &\1; is not known; write the character itself"),
    (r"Unescaped '<' not allowed in attributes values", "a < in a value must be written &lt;"),
    (r"AttValue: \" or ' expected", "a value must stand in quotes"),
    (r"Excessive depth in document: .*", "the elements are nested too deeply"),
    (r"Invalid character: Char (\S+) .*", r"the character \1 is not allowed in XML"),
    (r"xmlParseCharRef: invalid xmlChar value .*", "a character reference to no character"),
    (r"(StartTag|xmlParseStartTag): invalid element name", "a plain < must be written &lt;"),
    (r"Double hyphen within comment.*", "a comment may not hold two hyphens in a row"),
    (r"Attribute (\S+) redefined", r"the attribute \1 is given twice"),
)


def _plain(reason: str) -> str:
    """The parser's reason in plain words, where there are any."""
    reason = re.sub(r", line \d+, column \d+$", "", " ".join(reason.split()))
    for pattern, words in _PLAIN:
        if found := re.fullmatch(pattern, reason):
            return found.expand(words)
    return reason or "the parser gives no reason"


@functools.cache
def schema_rules() -> Rules:
    """The rules of the schema; they refuse the same as a RELAX NG validator, in plain words."""
    data = importlib.resources.files("rune_tui.layout").joinpath("schema.rng").read_bytes()
    document = etree.fromstring(data, etree.XMLParser(remove_comments=True))
    return read_rules(to_node(document, data.decode(), "schema.rng"))


def to_node(document: etree._Element, text: str, shown: str) -> Node:
    """The elements as nodes with their places."""
    if sum(1 for _ in document.iter()) > _MOST_ELEMENTS:
        message = f"the file has more than {_MOST_ELEMENTS} elements; a layout has a few hundred"
        raise _refusal(shown, message)
    tags = dict(zip(document.iter(), start_tags(text, shown), strict=True))

    def node(element: etree._Element, depth: int) -> Node:
        names = itertools.islice(element.attrib, _MOST_ATTRIBUTES)
        inner = (element.text or "") + "".join(child.tail or "" for child in element)
        written = tags[element].attributes.items()
        places = (place for name, place in written if not re.match("xmlns(:|$)", name))
        return Node(
            tag=str(element.tag),
            attributes={(name := str(each)): str(element.attrib[name]) for each in names},
            children=tuple(node(child, depth + 1) for child in element if depth < _DEEPEST),
            text=inner.strip(" \t\n\r"),
            place=tags[element].place,
            places=dict(zip(map(str, element.attrib), places, strict=True)),
        )

    return node(document, 0)
