"""Subscriptions to payloads: what arrives is what was sent, undecoded, all of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from hub.errors import RedefinedMessageError
from hub.ipc.definition import Keep, MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.values import dataclass
from tests.hub.ipc import vocabulary as v
from tests.hub.ipc.conftest import Peer
from tests.hub.ipc.vocabulary import Number
from tests.support.waiting import until

Connect = Callable[[str], Peer]


@dataclass(frozen=True, slots=True, kw_only=True)
class Words:
    """A message of variable length."""

    text: str = ""


STREAM = MessageDefinition(name="test_words", type=Words, keep=Keep.NEWEST)
OLD = MessageDefinition(name="test_old", type=Words, lifespan_s=0.001)


def tapped(peer: Peer, *definitions: MessageDefinition[Any]) -> list[tuple[bytes, MessageInfo]]:
    received: list[tuple[bytes, MessageInfo]] = []

    def subscribe() -> None:
        for each in definitions:
            peer.client.subscribe_payload(
                each, lambda payload, how: received.append((bytes(payload), how)), last=True
            )

    peer.call(subscribe)
    peer.call(lambda: peer.client.wait_subscribed(10.0))
    return received


def test_payloads_come_as_they_are_and_all_of_them(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = tapped(other, v.LOG, STREAM)
    for number in range(200):
        one.publish(v.LOG, Number(value=number))
        one.publish(STREAM, Words(text=f"word {number}"))
    until(lambda: len(received) >= 400, 20.0)
    numbers = [v.LOG.decode(p).value for p, _ in received if len(p) == _length(v.LOG)]
    assert numbers == list(range(200))
    words = [p for p, _ in received if len(p) != _length(v.LOG)]
    assert words == [b"".join(STREAM.encode(Words(text=f"word {n}"))) for n in range(200)]
    assert [how.sequence for p, how in received if len(p) == _length(v.LOG)] == list(range(1, 201))
    assert other.call(lambda: other.client.lost_by_message) == {}


def _length(definition: MessageDefinition[Any]) -> int:
    return len(b"".join(definition.encode(Number(value=1))))


def test_old_messages_come_too(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    received = tapped(other, OLD)
    one.publish(OLD, Words(text="late"), age=5.0)
    until(lambda: received, 10.0)
    assert received[0][1].age >= 5.0


def test_the_last_message_before_the_subscription_comes(connect: Connect) -> None:
    one, other = connect("one"), connect("other")
    one.publish(STREAM, Words(text="before"))
    until(lambda: one.client.connected, 10.0)
    received = tapped(other, STREAM)
    until(lambda: received, 10.0)
    assert STREAM.decode(received[0][0]).text == "before"


def test_one_client_gets_values_or_payloads_of_a_message(connect: Connect) -> None:
    one = connect("one")
    one.collect(v.LOG)
    with pytest.raises(RedefinedMessageError, match="as values and as payloads"):
        one.call(lambda: one.client.subscribe_payload(v.LOG, lambda *_: None))
