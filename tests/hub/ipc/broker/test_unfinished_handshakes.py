"""Handshakes that end early are counted, whatever order connections come and go in."""

from __future__ import annotations

from hub.ipc.broker.unfinished_handshakes import LONGEST_S, UnfinishedHandshakes


def test_a_client_that_leaves_while_another_arrives_is_not_taken_for_a_stranger() -> None:
    handshakes = UnfinishedHandshakes(lambda: 0.0)
    handshakes.accepted(1)
    handshakes.decided()
    handshakes.accepted(2)
    assert handshakes.ended(1) == 0
    handshakes.decided()
    assert handshakes.ended(2) == 0


def test_each_that_ends_before_its_handshake_is_counted_once() -> None:
    now = [0.0]
    handshakes = UnfinishedHandshakes(lambda: now[0])
    for descriptor in range(5):
        handshakes.accepted(descriptor)
    handshakes.decided()  # of one of them
    assert sum(handshakes.ended(descriptor) for descriptor in range(5)) == 4
    handshakes.accepted(7)
    handshakes.accepted(8)
    handshakes.decided()
    now[0] = 2 * LONGEST_S  # the one that is open is decided, so the other was not
    assert handshakes.ended(7) == 1
    assert handshakes.ended(8) == 0
