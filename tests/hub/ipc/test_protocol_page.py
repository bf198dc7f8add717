"""The page that describes the protocol agrees with the code."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

from hub.gcm.catalog import MESSAGES
from hub.ipc import endpoints
from hub.ipc.broker import connections, definitions, listing, message_users, query_routing
from hub.ipc.formats import grammar as formats
from hub.ipc.node import connection
from hub.ipc.transport import sockets
from hub.ipc.wire import control_codec, definition_listing, frames
from tests.support.cases import for_each

_PAGE = (Path(__file__).parents[3] / "docs" / "protocol.md").read_text()


def _rows(title: str) -> list[list[str]]:
    """The cells of the first table under a heading, without its two head lines."""
    section = _PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    from_table = itertools.dropwhile(lambda line: not line.startswith("|"), section.splitlines())
    lines = list(itertools.takewhile(lambda line: line.startswith("|"), from_table))
    return [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_control_kinds_and_formats_are_those_of_the_code() -> None:
    rows = [(int(kind), name, text) for kind, name, _, text in _rows("Control messages")]
    assert rows == [
        (n, kind.name, kind.wire_format) for n, kind in enumerate(control_codec.KINDS, 1)
    ]


def test_messages_of_the_vocabulary_are_those_of_the_catalog() -> None:
    rows = [tuple(row) for row in _rows("Messages of the vocabulary")]
    assert rows == [(d.name, d.plane.value, d.keep.value) for d in MESSAGES]


def test_header_fields_are_those_of_the_code() -> None:
    fields = [row for row in _rows("A message frame") if row[0].startswith("h")]
    sizes = [int(size) for _, size, _, _ in fields[:-1]]
    assert sum(sizes) == frames.HEADER.size == 36
    offsets = [0 if offset == "h" else int(offset.removeprefix("h + ")) for offset, *_ in fields]
    assert offsets == [sum(sizes[:place]) for place in range(len(fields))]


def test_every_primitive_is_in_the_table_of_formats() -> None:
    named = set(re.findall(r"`(\w+)`", _PAGE.partition("## Formats")[2].partition("### ")[0]))
    assert set(formats.PRIMITIVES) <= named


@for_each(
    "phrase",
    [
        f"Version {frames.VERSION}.",
        f"p is {endpoints.DEFAULT_PORT}",
        f"{frames.MAX_FRAME:,} bytes",
        f"{formats.MAX_TEXT:,} characters, written and spelt out, {formats.MAX_DEPTH} levels",
        f"levels, {formats.MAX_ELEMENTS:,} elements",
        f"{formats.MAX_NODES:,} nodes in a list",
        f"{formats.MAX_DIMENSIONS} dimensions or size members",
        f"up to {definition_listing.MAX_FIELDS:,}",
        f"PING every {connection.PING_S:g} s",
        f"not heard central for {connection.LOST_S:g} s",
        f"silent for {connections.SILENCE_S:g} s",
        f"| connected clients | {connections.MAX_PEERS} |",
        f"| definitions | {definitions.MAX_DEFINITIONS:,}, "
        f"with {definitions.MAX_LISTED:,} characters",
        f"| queries under way | {query_routing.MAX_QUERIES:,} |",
        f"answers, each | {message_users.MAX_NAMES:,} |",
        f"| time central remembers a query | {query_routing.MAX_QUERY_S:g} s |",
        f"cut at {listing.MAX_NAMES:,} characters",
        "holds {} frames (state), {} (command) or {} (picture)".format(*sockets.QUEUE.values()),
    ],
)
def test_number_on_the_page_is_that_of_the_code(phrase: str) -> None:
    assert phrase in " ".join(_PAGE.split())
