"""XML of files that come with a robot; only this file of the hub imports lxml."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from lxml.etree import _Element  # noqa: TID251 - its type only

XmlElement: TypeAlias = "_Element"


def xml_root(raw: bytes) -> XmlElement:
    """The first element of a text; entities stay as they are, and nothing else is read.

    Raises:
        ValueError: It is no XML, or lxml is missing.
    """
    try:
        from lxml import etree  # noqa: TID251 - the only XML of the hub, read if it is asked for
    except ImportError as error:
        reason = "lxml is not installed, which reads URDF files; pip install lxml"
        raise ValueError(reason) from error
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False
    )
    try:
        return etree.fromstring(raw, parser)
    except etree.XMLSyntaxError as fault:
        reason = f"is not XML: {fault}"
        raise ValueError(reason) from fault
