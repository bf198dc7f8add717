"""What a robot of a fleet says of itself: numbers beyond all bounds."""

from __future__ import annotations

import json

from hub.doors.mirror.documents import read_definitions, read_operators
from hub.gcm.navigation import ROBOT_STATE
from hub.ipc.wire.definition_listing import to_listing


def listed(**others: object) -> dict[str, object]:
    entry = to_listing(ROBOT_STATE)
    keys = ("name", "format", "fields", "keep", "plane")
    return {**{key: getattr(entry, key) for key in keys}, "name": "T_Other", **others}


def test_a_session_of_thousands_of_digits_is_left_out() -> None:
    said = {"operate:eve/" + "9" * 5000: 2, "operate:eve/7": 3, "operate:eve/\u00b2": 4}
    assert read_operators(json.dumps(said).encode(), "operate:eve") == {7: 3}


def test_a_session_of_another_operator_is_none_of_ours() -> None:
    said = {"operate:eve/7": 3, "supervise:sue/7": 4, "7": 5}
    assert read_operators(json.dumps(said).encode(), "supervise:sue") == {7: 4}


def test_a_listing_with_a_rate_beyond_all_floats_is_left_out() -> None:
    said = [listed(rate_hz=10**400), listed(lifespan_s=-(10**400)), listed(name="T_Right")]
    assert [each.name for each in read_definitions(json.dumps(said).encode())] == ["T_Right"]
