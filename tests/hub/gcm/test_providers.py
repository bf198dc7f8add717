"""Every message either belongs to capabilities or is always there."""

from __future__ import annotations

from hub.gcm.catalog import BY_NAME
from hub.gcm.providers import ALWAYS_THERE, PROVIDED_BY, TAKEN_BY


def test_every_message_of_the_catalogue_has_one_place() -> None:
    assert {*PROVIDED_BY, *TAKEN_BY} | ALWAYS_THERE == set(BY_NAME)
    assert ALWAYS_THERE.isdisjoint({*PROVIDED_BY, *TAKEN_BY})
