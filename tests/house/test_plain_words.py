"""Plain words for people who learnt English at school: in pages, docstrings, comments and names."""

from __future__ import annotations

import ast
import functools
import io
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.support.cases import for_each

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "robots").glob("*.md")),
]
MOST_WORDS = 25
"""The longest sentence [words]; what stands in `code` counts too."""
AVOIDED = (
    r"told|heeds?|heeded|minds?|minded|hinders?|hindered|buries|buried|bury|deeds?|strangers?",
    r"anew|afresh|lest|thereof|whence|hence|whoever|whatever|gravest|betokens?|fares?|likewise",
    r"so long as|who was|of which|but for|ere|as it were",
    r"is to be|are to be|was to be|were to be|is to|are to",
)
"""Words that a reader looks up, or has to read twice."""
AVOIDED_IN_CODE = (
    *AVOIDED,
    r"somebody|hands? on|once more|for ever|all the same|lets? go|going on|thus|sake|all else",
    r"amid|amiss|grave|thrown away|throws away|held up|what is known|has come|have come",
    r"so many|so long|somebody else|nobody else|whom|ours|goes by|gone by|tells? of|told of",
    r"chores?|errands?|complaints?|weather|moods?|by whoever|nobody|anybody|everybody",
    r"in vain|to and fro|far off|so far off|so near|so much|at hand|fit to be|for want of",
    r"knows of|gets about|lets? in|let in|let go of|hears?|mends?|mended|speaks?|hardly|seldom",
    r"dearer|dearly|what (?:becomes|is known) of|what there is|what (?:comes|came|goes)",
)
"""The same in docstrings and comments, which have no page around them to explain a word."""
NAMES_TO_AVOID = re.compile(
    r"anew|bur(?:y|ied)|chores?|complaints?|deeds?|errands?|heeds?|hind(?:er|rances?)|lest|minds?"
    r"|moods?|somebody|strangers?|tell|tells|telling|told|weather|whose"
    r"|apology|bearers?|beat|dearer|everybodys|forg(?:ive|iven)|gravest|homeward|makings|mend"
    r"|sayable|saying|sendings|strays|tidy|troubled|un(?:asked|hurried|noted|said)"
    r"|un(?:settled|taken|told)|vain|veil|whence"
)
"""Words that name nothing of the field; they do not occur in names of the rooms that are done."""
FIELD_TERMS = {"tell"}
"""Names that others gave: the method of a file."""
ROOMS = ("benchmarks", "hub", "rune_study", "rune_tui")
"""Rooms whose names, docstrings and comments are plain."""
_LIST_ITEM = re.compile(r"\s*(?:[-*]|\d+\.)\s+")
_END = re.compile(r"(?<=[.!?])[\"*_)]*\s+")


def prose(text: str) -> Iterator[str]:
    """The paragraphs and list items of a page, without code blocks, tables and headings."""
    block: list[str] = []
    fenced = False
    for line in [*text.splitlines(), ""]:
        fence = line.lstrip().startswith("```")
        fenced ^= fence
        left_out = fenced or fence or line.lstrip().startswith(("|", "#", "!["))
        item = _LIST_ITEM.match(line)
        if left_out or item or not line.strip():
            if block:
                yield " ".join(block)
            block = []
        if not left_out and line.strip():
            block.append(line[item.end() :] if item else line.strip())


def plain(text: str) -> str:
    """Prose as it is read: no addresses of links; of `code`, nothing that ends a sentence."""
    text = re.sub(r"\]\([^)]*\)", "]", text)
    return re.sub(r"`[^`]*`", lambda code: re.sub(r"[^\w\s`]", "_", code[0]), text)


def sentences(text: str) -> Iterator[str]:
    """The sentences of a page."""
    for block in prose(text):
        yield from filter(None, _END.split(plain(block)))


def long_sentences(text: str) -> list[str]:
    """Sentences with too many words; marks such as "-" or "·" between words are none."""
    return [
        f"{count} words: {sentence}"
        for sentence in sentences(text)
        if (count := sum(bool(re.search(r"\w", word)) for word in sentence.split())) > MOST_WORDS
    ]


def avoided_words(text: str) -> list[str]:
    """Lines with a word to avoid, tables too; code and names in capitals do not count."""
    without_blocks = re.sub(r"^\s*```.*?^\s*```", "", text, flags=re.DOTALL | re.MULTILINE)
    words = re.compile(rf"\b(?:{'|'.join(AVOIDED)})\b", re.IGNORECASE)
    named = r"`[^`\n]*`|\]\([^)]*\)|\b[A-Z_]{2,}\b"
    lines = re.sub(named, "", without_blocks).splitlines()
    return [f"{found[0]}: {line}" for line in lines if (found := words.search(line))]


def python_files(room: str) -> list[Path]:
    """The Python files of a room, or the one file."""
    path = ROOT / room
    return sorted(path.rglob("*.py")) if path.is_dir() else [path]


def words_of(name: str) -> Iterator[str]:
    """The words of a Python name, in lower case."""
    yield from (word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name))


def names_in(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Names that a file gives: of classes, functions, parameters, variables and attributes."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.attr


@dataclass(frozen=True, slots=True, kw_only=True)
class Written:
    """What is written in a source file, each with its line.

    Attributes:
        docstrings: Docstrings, those of attributes too.
        names: Names that the file gives.
    """

    docstrings: tuple[tuple[int, str], ...]
    names: tuple[tuple[int, str], ...]


def docstrings_in(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Docstrings, those of attributes too."""
    for node in ast.walk(tree):
        match node:
            case ast.Expr(value=ast.Constant(value=str() as text)):
                yield node.lineno, text


def comments_in(text: str) -> Iterator[tuple[int, str]]:
    """Comments, without orders to tools."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], re.sub(r"#\s*(?:noqa|type):[^-]*", "", token.string)


def docstring_sentences(text: str) -> Iterator[str]:
    """The sentences of a docstring without grammars and trees, code as a word, attributes apart."""
    headed = re.sub(r"^\s*\w+:(?=\s)|^.*(?::=|──).*$", "\n", text, flags=re.MULTILINE)
    for sentence in sentences(re.sub(r"`[^`]*`", "code", headed)):
        yield from re.split(r"(?<=[:;])\s", sentence)


@functools.cache
def written_in(path: Path) -> Written:
    """What is written in a source file."""
    tree = ast.parse(path.read_text())
    return Written(docstrings=tuple(docstrings_in(tree)), names=tuple(names_in(tree)))


@pytest.mark.parametrize("room", ROOMS)
def test_docstrings_and_comments_have_no_words_that_few_know(room: str) -> None:
    avoided = re.compile(rf"\b(?:{'|'.join(AVOIDED_IN_CODE)})\b", re.IGNORECASE)
    found = [
        f"{path.relative_to(ROOT)}:{line}: {word[0]}"
        for path in python_files(room)
        for source in [path.read_text()]
        if avoided.search(source)  # to read the comments of all files would take longer
        for line, text in (*written_in(path).docstrings, *comments_in(source))
        for word in avoided.finditer(re.sub(r"`[^`]*`", "", text))
    ]
    assert found == []


@pytest.mark.parametrize("room", ROOMS)
def test_sentences_of_docstrings_are_short(room: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {sentence}"
        for path in python_files(room)
        for line, text in written_in(path).docstrings
        for sentence in docstring_sentences(text)
        if sum(bool(re.search(r"\w", word)) for word in sentence.split()) > MOST_WORDS
    ]
    assert found == []


@pytest.mark.parametrize("room", ROOMS)
def test_names_are_of_the_field(room: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in python_files(room)
        for line, name in written_in(path).names
        if name not in FIELD_TERMS and any(map(NAMES_TO_AVOID.fullmatch, words_of(name)))
    ]
    assert found == []


@for_each("page", PAGES)
def test_no_sentence_is_long(page: Path) -> None:
    assert long_sentences(page.read_text()) == []


@for_each("page", PAGES)
def test_words_that_few_know_do_not_occur(page: Path) -> None:
    assert avoided_words(page.read_text()) == []


def test_what_counts_as_a_sentence() -> None:
    long = " ".join(["word"] * 26)
    page = (
        f"# {long}\n\n| {long} |\n\n```\n{long}\n```\n\nOne `a. b` [two](x y z). Three!\n- {long}\n"
    )
    assert list(sentences(page)) == ["One `a_ b` [two].", "Three!", long]
    assert long_sentences(page) == [f"26 words: {long}"]


def test_words_to_avoid_are_found_in_tables_and_not_in_code() -> None:
    page = "| it was\n| TOLD\n| told | `told` |\n\n```\ntold\n```\nThe list, of which one is long."
    assert [found.partition(":")[0] for found in avoided_words(page)] == ["told", "of which"]


def test_a_name_is_split_into_words() -> None:
    assert list(words_of("_HTTPServer_told2")) == ["http", "server", "told"]
