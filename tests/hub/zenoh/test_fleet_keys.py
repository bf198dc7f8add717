"""Keys and headers of a fleet: they come back as they were, and all others are refused in words."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import FleetKeyError, FrameError
from hub.gcm import navigation
from hub.gcm.catalog import MESSAGES
from hub.ipc.definition import Plane
from hub.ipc.roles import Principal, Role
from hub.zenoh.attachment import COMMAND_LIFESPAN_S, Attachment, lifespan, unpack
from hub.zenoh.fleet_keys import FleetKey, KeyKind, parse_key, parse_operator, pattern

_ROLES = (Role.OBSERVE, Role.OPERATE, Role.SUPERVISE)
_NAMES = st.from_regex(r"[A-Za-z0-9_][A-Za-z0-9._-]{0,63}", fullmatch=True)
_FLEETS = st.lists(_NAMES, min_size=1, max_size=3).map("/".join)
_MESSAGES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,63}", fullmatch=True)
_U32, _U64 = st.integers(0, 2**32 - 1), st.integers(0, 2**64 - 1)
_WITH_MESSAGE = {
    KeyKind.STATE,
    KeyKind.PICTURE,
    KeyKind.THIN,
    KeyKind.LAST,
    KeyKind.COMMAND,
    KeyKind.ASK,
}
_WITH_OPERATOR = {KeyKind.OPERATOR, KeyKind.COMMAND, KeyKind.ASK, KeyKind.REFUSAL}


@st.composite
def _keys(draw: st.DrawFn) -> FleetKey:
    kind = draw(st.sampled_from(KeyKind))
    who = Principal(name=draw(_NAMES), role=draw(st.sampled_from(_ROLES)))
    return FleetKey(
        kind=kind,
        robot=draw(_NAMES),
        operator=who if kind in _WITH_OPERATOR else None,
        session=draw(st.integers(1, 2**32 - 1)) if kind is KeyKind.OPERATOR else 0,
        message=draw(_MESSAGES) if kind in _WITH_MESSAGE else "",
    )


@given(_FLEETS, _keys())
def test_key_comes_back_as_it_was(fleet: str, key: FleetKey) -> None:
    assert parse_key(fleet, key.under(fleet)) == key


@given(st.text() | st.text(alphabet="/rune1v*:.", max_size=40).map(lambda end: "rune/v1/a/" + end))
def test_other_text_is_refused_and_what_is_not_is_a_key(text: str) -> None:
    with contextlib.suppress(FleetKeyError):
        assert parse_key("rune", text).under("rune") == text


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("rune/v2/a/alive", "begin with rune/v1/"),
        ("rune/v1/a/wheels", "its kind is none"),
        ("rune/v1/a", "its kind is none"),
        ("rune/v1/../alive", "the name of a robot"),
        ("rune/v1/a/state", "followed by 1 parts"),
        ("rune/v1/a/command/module:me/GCM_Stop", "one of observe, operate, supervise"),
        ("rune/v1/a/command/operate:/GCM_Stop", "the name of a operator"),
        ("rune/v1/a/operator/operate:me/007", "a number from 1"),
        ("rune/v1/a/state/GCM-State", "a message name"),
        ("rune/v1/a/" + "x" * 600, "begin with"),
    ],
)
def test_refusals_say_what_was_expected(text: str, why: str) -> None:
    with pytest.raises(FleetKeyError, match=why):
        parse_key("rune", text)


def test_patterns_name_what_is_given_and_match_the_rest() -> None:
    alice = parse_operator("operate:alice")
    assert pattern("a/b", KeyKind.ALIVE) == "a/b/v1/*/alive"
    assert pattern("a", KeyKind.COMMAND, robot="r") == "a/v1/r/command/*/*"
    assert pattern("a", KeyKind.COMMAND, operator=alice) == "a/v1/*/command/operate:alice/*"
    assert pattern("a", KeyKind.STATE, message="GCM_Stop") == "a/v1/*/state/GCM_Stop"
    with pytest.raises(FleetKeyError):
        pattern("a//b", KeyKind.ALIVE)


@given(_U32, _U64, _U64, st.integers(-(2**63), 2**63 - 1), st.just("") | _MESSAGES)
def test_attachment_comes_back_as_it_was(
    publisher: int, fingerprint: int, sequence: int, stamp_ns: int, name: str
) -> None:
    made = Attachment(
        publisher=publisher,
        fingerprint=fingerprint,
        sequence=sequence,
        stamp_ns=stamp_ns,
        name=name,
    )
    assert unpack(made.pack()) == made


@given(st.none() | st.binary(max_size=120))
def test_other_bytes_are_refused_as_bytes_from_the_wire(raw: bytes | None) -> None:
    with contextlib.suppress(FrameError):
        assert unpack(raw).pack()[4:] == (raw or b"")[4:]


def test_stop_is_never_too_old_and_no_other_command_lives_long() -> None:
    assert lifespan(navigation.STOP) == math.inf
    assert lifespan(navigation.VELOCITY_COMMAND) == navigation.VELOCITY_COMMAND.lifespan_s
    commands = [each for each in MESSAGES if each.plane is Plane.COMMAND]
    assert max(lifespan(each) for each in commands if each.unreadable is None) == COMMAND_LIFESPAN_S
