"""Sessions with a real router: what they announce, find and carry, also after it was away."""

from __future__ import annotations

import queue
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from hub.errors import RouterUnreachableError
from hub.zenoh.session import ZenohSample, ZenohSession, open_session
from tests.support.ports import free_port
from tests.support.waiting import until
from tests.support.zenoh_router import ROOT, ZenohRouter, zenoh_router


@pytest.fixture
def router() -> Iterator[ZenohRouter]:
    with zenoh_router() as running:
        yield running


@pytest.fixture
def pair(router: ZenohRouter) -> Iterator[tuple[ZenohSession, ZenohSession]]:
    one, other = open_session(router.endpoint), open_session(router.endpoint)
    yield one, other
    one.close()
    other.close()


def test_without_a_router_the_error_says_where_and_what_to_do() -> None:
    port = free_port()
    with pytest.raises(RouterUnreachableError, match=f"at tcp/127.0.0.1:{port}; start one"):
        open_session(f"tcp/127.0.0.1:{port}")


def test_tokens_are_seen_come_go_and_come_back_with_the_router(
    router: ZenohRouter, pair: tuple[ZenohSession, ZenohSession]
) -> None:
    one, other = pair
    alive: dict[str, bool] = {}
    links: list[bool] = []
    kept = other.declare_token("a/first")
    one.watch_tokens("a/**", alive.__setitem__)
    one.watch_link(links.append)
    until(lambda: alive == {"a/first": True}, 5.0)
    second = other.declare_token("a/second")
    until(lambda: alive.get("a/second"), 5.0)
    second.undeclare()
    until(lambda: alive == {"a/first": True, "a/second": False}, 5.0)
    router.kill()
    until(lambda: alive["a/first"] is False and links[-1] is False, 5.0)
    router.start()
    until(lambda: alive["a/first"] and links[-1], 10.0)
    kept.undeclare()
    until(lambda: not alive["a/first"], 5.0)


def test_samples_come_with_their_attachment_also_those_of_before(
    pair: tuple[ZenohSession, ZenohSession],
) -> None:
    one, other = pair
    came: queue.Queue[ZenohSample] = queue.Queue()
    latched = one.publisher("m/map", latched=True)
    latched.put(b"old", b"1")
    other.subscribe("m/*", came.put, history=1)
    first = came.get(timeout=5.0)
    assert (first.key, first.payload, first.attachment) == ("m/map", b"old", b"1")
    latched.put(memoryview(b"new"), b"2")
    assert came.get(timeout=5.0).payload == b"new"
    one.subscribe("m/*", came.put)
    latched.put(b"own", b"3")
    assert came.get(timeout=5.0).payload == b"own"
    assert came.empty(), "a session hears itself"


def test_a_query_ends_also_where_nobody_answers(pair: tuple[ZenohSession, ZenohSession]) -> None:
    answers: queue.Queue[bytes | None] = queue.Queue()
    pair[0].ask("nobody/there", b"", b"", 0.2, answers.put)
    assert answers.get(timeout=5.0) is None


def test_a_process_ends_although_its_session_is_open(router: ZenohRouter) -> None:
    program = (
        "from hub.zenoh.session import open_session\n"
        f"session = open_session({router.endpoint!r})\n"
        "kept = [session.subscribe('m/*', print), session.watch_tokens('a/**', print)]\n"
        "raise SystemExit(7)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, timeout=30.0, check=False)
    assert done.returncode == 7


def test_a_probe_waits_for_the_router(
    router: ZenohRouter, pair: tuple[ZenohSession, ZenohSession]
) -> None:
    ends: queue.Queue[float] = queue.Queue()
    pair[0].probe(lambda: ends.put(time.monotonic()), 5.0)
    ends.get(timeout=5.0)
    router.freeze()
    pair[0].probe(lambda: ends.put(time.monotonic()), 30.0)
    with pytest.raises(queue.Empty):
        ends.get(timeout=0.2)
    router.thaw()
    ends.get(timeout=5.0)
