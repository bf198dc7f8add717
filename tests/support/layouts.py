"""The schema of layouts as others use it: a validator of RELAX NG."""

from __future__ import annotations

import importlib.resources

from lxml import etree


def relax_ng() -> etree.RelaxNG:
    """A validator that knows the schema alone, as editors have it."""
    data = importlib.resources.files("rune_tui.layout").joinpath("schema.rng").read_bytes()
    return etree.RelaxNG(etree.fromstring(data))
