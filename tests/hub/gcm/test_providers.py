"""Every message either belongs to capabilities or is always there."""

from __future__ import annotations

from hub.gcm import body, common, control, pad, shaper, supervision, transforms
from hub.gcm.catalog import BY_NAME
from hub.gcm.providers import PROVIDED_BY, TAKEN_BY


def test_every_message_of_the_catalogue_has_one_place() -> None:
    always_there = {
        definition.name
        for definition in (
            *common.MESSAGES,
            *body.MESSAGES,
            transforms.STATIC_TRANSFORMS,
            *supervision.MESSAGES,
            *control.MESSAGES,
            *pad.MESSAGES,
            *shaper.MESSAGES,
        )
    }
    assert {*PROVIDED_BY, *TAKEN_BY} | always_there == set(BY_NAME)
    assert always_there.isdisjoint({*PROVIDED_BY, *TAKEN_BY})
