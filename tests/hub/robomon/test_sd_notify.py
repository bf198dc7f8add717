"""What the daemon says to systemd, on a real socket such as systemd has."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from hub.robomon.sd_notify import Notifier
from tests.support.cases import for_each

PID = 4711


@pytest.fixture
def listener(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as supervisor:
        supervisor.bind(str(tmp_path / "notify"))
        supervisor.settimeout(5.0)
        yield supervisor


def notifier(listener: socket.socket, **more: str) -> Notifier:
    return Notifier.from_environment({"NOTIFY_SOCKET": listener.getsockname(), **more}, PID)


def heard(listener: socket.socket) -> list[str]:
    return listener.recv(4096).decode().split("\n")


def test_each_event_is_one_datagram_in_systemds_words(listener: socket.socket) -> None:
    ours = notifier(listener)
    ours.ready("3 modules run")
    ours.status("2 modules run")
    ours.alive()
    ours.stopping()
    assert heard(listener) == ["READY=1", "STATUS=3 modules run"]
    assert heard(listener) == ["STATUS=2 modules run"]
    assert heard(listener) == ["WATCHDOG=1"]
    assert heard(listener) == ["STOPPING=1"]


def test_an_abstract_socket_is_reached() -> None:
    name = f"rune-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as supervisor:
        supervisor.bind(f"\0{name}")
        supervisor.settimeout(5.0)
        Notifier.from_environment({"NOTIFY_SOCKET": f"@{name}"}, PID).alive()
        assert heard(supervisor) == ["WATCHDOG=1"]


def test_a_status_cannot_smuggle_in_a_message(listener: socket.socket) -> None:
    notifier(listener).status("driver: bad\nSTOPPING=1\r\nREADY=1")
    assert heard(listener) == ["STATUS=driver: bad STOPPING=1 READY=1"]


def test_a_status_of_any_characters_does_not_keep_the_event_back(listener: socket.socket) -> None:
    notifier(listener).ready("grün \udcff" + "x" * 10_000)
    event, status = heard(listener)
    assert event == "READY=1"
    assert status.startswith("STATUS=grün \\udcffxx")


@pytest.mark.parametrize(
    ("variables", "period"),
    [
        ({}, None),
        ({"WATCHDOG_USEC": "10000000"}, 5.0),
        ({"WATCHDOG_USEC": "10000000", "WATCHDOG_PID": str(PID)}, 5.0),
        ({"WATCHDOG_USEC": "10000000", "WATCHDOG_PID": "1"}, None),
        ({"WATCHDOG_USEC": "0"}, None),
        ({"WATCHDOG_USEC": "soon"}, None),
        ({"WATCHDOG_USEC": "-5"}, None),
        ({"WATCHDOG_USEC": "²"}, None),
        ({"WATCHDOG_USEC": "9" * 5000}, None),
    ],
)
def test_the_watchdog_is_fed_twice_in_its_time_if_it_is_ours(
    listener: socket.socket, variables: dict[str, str], period: float | None
) -> None:
    assert notifier(listener, **variables).period == period


@for_each("address", ["", "nowhere", "/no/such/socket", "/" + "x" * 500, "/a\0b", "/\ud800"])
def test_nobody_there_is_no_fault(address: str) -> None:
    ours = Notifier.from_environment({"NOTIFY_SOCKET": address, "WATCHDOG_USEC": "10"}, PID)
    ours.ready("all is well")
    ours.alive()


def test_without_a_supervisor_nobody_waits_for_signs_of_life() -> None:
    assert Notifier.from_environment({"WATCHDOG_USEC": "1000000"}, PID).period is None


def test_a_supervisor_that_reads_nothing_holds_nobody_up(listener: socket.socket) -> None:
    ours = notifier(listener)
    for _ in range(2000):  # far more than the socket's queue holds
        ours.alive()
    assert heard(listener) == ["WATCHDOG=1"]
