"""What each role may do, and which endpoints are allowed with and without keys."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hub.errors import EndpointError, NotAllowedError
from hub.ipc import endpoints, roles
from hub.ipc.roles import Action, Principal, Role
from hub.ipc.security.client_keys import KeyPair
from tests.support.cases import for_each

PLACES = [
    "control",
    *(f"{p} {way}" for p in ("state", "command", "picture") for way in ("in", "out")),
]


def test_each_role_may_do_what_is_written_in_the_documentation() -> None:
    watch = {Action.SUBSCRIBE, Action.LIST, Action.PRESENCE, Action.QUERY}
    allowed = {role: {action for action in Action if roles.may(role, action)} for role in Role}
    assert allowed[Role.OBSERVE] == watch
    assert allowed[Role.OPERATE] == watch
    assert allowed[Role.SUPERVISE] == watch | {Action.TAKE_OVER}
    assert allowed[Role.MODULE] == set(Action)


def test_only_modules_enter_where_states_and_pictures_go_in() -> None:
    entered = {role: [p for p in PLACES if roles.may_connect(role, p)] for role in Role}
    out = ["control", "state out", "command out", "picture out"]
    for role in (Role.OBSERVE, Role.OPERATE, Role.SUPERVISE):
        assert sorted(entered[role]) == sorted([*out, "command in"])
    assert entered[Role.MODULE] == PLACES


@for_each("place", ["", " ", "in", "out", " in", " out", "state", "CONTROL", "a b"])
def test_place_that_is_none_is_entered_by_nobody(place: str) -> None:
    assert not any(roles.may_connect(role, place) for role in Role)


@for_each("place", PLACES)
def test_each_role_enters_where_the_ones_before_it_do(place: str) -> None:
    for less, more in itertools.pairwise(Role):
        assert roles.may_connect(less, place) <= roles.may_connect(more, place)


def test_what_a_role_does_not_allow_is_refused_with_the_role_that_does() -> None:
    alice = Principal(name="alice", role=Role.OBSERVE)
    roles.demand(alice, Action.SUBSCRIBE)
    with pytest.raises(NotAllowedError, match=r"alice .*may not take control.*--role supervise$"):
        roles.demand(alice, Action.TAKE_OVER)
    with pytest.raises(NotAllowedError, match="do it on the robot's machine"):
        roles.demand(Principal(name="bob", role=Role.OPERATE), Action.CLOSE_MODULE)


def test_this_machine_may_do_everything() -> None:
    for action in Action:
        roles.demand(roles.LOCAL, action)


@given(st.sampled_from(Role), st.from_regex(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", fullmatch=True))
def test_principal_is_read_back_from_what_goes_with_its_frames(role: Role, name: str) -> None:
    principal = Principal.of(name, role, KeyPair.new().public)
    assert roles.parse_principal(principal.user_id) == principal
    assert roles.parse_principal(principal.user_id) != Principal.of(
        name, role, KeyPair.new().public
    )


@for_each(
    "user_id",
    ["", "alice", ":", "operate:", "operate:alice", "operate:alice:", f"root:alice:{32 * '0'}"],
)
def test_user_id_that_names_no_role_has_no_rights(user_id: str) -> None:
    with pytest.raises(NotAllowedError, match="no role, name and key"):
        roles.parse_principal(user_id)


@for_each(
    ("text", "address"),
    [
        ("tcp://0.0.0.0:1481", "tcp://0.0.0.0:1481"),
        ("tcp://192.168.1.5:0", "tcp://192.168.1.5:*"),
        ("tcp://[::]:1481", "tcp://[::]:1481"),
        ("tcp://127.0.0.1:1481", "tcp://127.0.0.1:1481"),
        ("ipc:///a/b", "ipc:///a/b"),
    ],
)
def test_hub_with_keys_may_listen_beyond_this_machine(text: str, address: str) -> None:
    assert str(endpoints.parse_endpoint(text, beyond_loopback=True)) == address


@for_each("text", ["tcp://robot:1481", "tcp://*:1481", "tcp://:1481", "tcp://224.0.0.1:1481"])
def test_hub_listens_at_addresses_only(text: str) -> None:
    with pytest.raises(EndpointError, match=r"0\.0\.0\.0"):
        endpoints.parse_endpoint(text, beyond_loopback=True)


@for_each(
    ("text", "address"),
    [
        ("tcp://robot.example:1481", "tcp://robot.example:1481"),
        ("tcp://192.168.1.5:1481", "tcp://192.168.1.5:1481"),
        ("tcp://[fe80::1%eth0]:1481", "tcp://[fe80::1%eth0]:1481"),
        ("tcp://localhost:1481", "tcp://127.0.0.1:1481"),
        ("ipc:///a/b", "ipc:///a/b"),
    ],
)
def test_client_with_keys_may_connect_beyond_this_machine(text: str, address: str) -> None:
    assert endpoints.connectable(text, with_keys=True) == address


@for_each(
    "text",
    ["tcp://0.0.0.0:1481", "tcp://[::]:1", "tcp://robot:0", "tcp://a b:1", "tcp://-:1", "tcp://:1"],
)
def test_client_cannot_connect_to_what_is_no_machine(text: str) -> None:
    with pytest.raises(EndpointError, match="cannot be used"):
        endpoints.connectable(text, with_keys=True)


@pytest.mark.parametrize("text", ["tcp://192.168.1.5:1481", "tcp://robot.example:1481"])
def test_without_keys_the_error_says_how_to_make_one(text: str) -> None:
    for use in (endpoints.parse_endpoint, endpoints.connectable):
        with pytest.raises(EndpointError, match=r"rune-hub keys make NAME --role") as refusal:
            use(text)
        assert len(str(refusal.value).split()) <= 25


@given(st.text(max_size=60))
def test_any_text_is_an_endpoint_or_refused_in_our_words(rest: str) -> None:
    for text in (rest, f"tcp://{rest}", f"tcp://{rest}:5", f"tcp://[{rest}]:5"):
        for use in (
            lambda text: endpoints.parse_endpoint(text, beyond_loopback=True),
            lambda text: endpoints.connectable(text, with_keys=True),
        ):
            try:
                use(text)
            except EndpointError as error:
                assert "cannot be used" in str(error)  # noqa: PT017
