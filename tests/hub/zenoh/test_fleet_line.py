"""Lines of two programs through a real router."""

from __future__ import annotations

import math
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hub.errors import EndpointError
from hub.ipc.definition import Plane
from hub.zenoh.fleet_line import LONGEST
from hub.zenoh.fleet_session import FleetSession, FleetWay
from hub.zenoh.handover import MOST_BYTES, Handover, Sender
from hub.zenoh.settings import (
    CertificateFiles,
    RouterPlace,
    client_settings,
    parse_place,
    router_settings,
)
from tests.hub.zenoh.conftest import FleetSide, start_router
from tests.support.waiting import until
from tests.support.zenoh_router import ROOT

Sides = tuple[FleetSide, FleetSide]


def test_line_declares_all_when_its_router_comes_and_again_when_it_is_back(
    place: RouterPlace, sides: Sides
) -> None:
    robot, operator = sides
    wanted: list[bool] = []
    there: list[tuple[str, bool]] = []
    came: list[bytes] = []
    robot.line.declare_token("f/alive")
    robot.line.watch_subscribers("f/state", wanted.append)
    operator.line.watch("f/*", lambda key, is_there: there.append((key, is_there)))
    operator.line.subscribe("f/state", lambda _, payload, __: came.append(payload))
    for run in range(2):
        router = start_router(place)
        robot.wait(lambda: wanted[-1:] == [True])
        operator.wait(lambda: there[-1:] == [("f/alive", True)])
        robot.line.put("f/state", b"%d" % run, b"", Plane.STATE)
        operator.wait(lambda run=run: came[-1:] == [b"%d" % run])
        router.close()
        robot.wait(lambda: wanted[-1:] == [False])
        operator.wait(lambda: there[-1:] == [("f/alive", False)])
        assert not robot.line.connected


@pytest.mark.usefixtures("router")
def test_query_ends_once_with_an_answer_a_reason_or_the_end_of_its_time(sides: Sides) -> None:
    robot, operator = sides
    robot.line.respond("f/last/*", lambda query: robot.line.reply(query, b"5", b"a", FleetWay.BULK))
    robot.line.respond("f/ask", lambda query: query.refuse("NotAllowedError", "no, of course"))
    robot.line.respond_at_once("f/clock", lambda: b"now")
    both = [robot.line, operator.line]
    operator.wait(lambda: all(line.connected for line in both))
    ends: list[tuple[object, ...]] = []
    for key in ("f/last/x", "f/ask", "f/clock", "f/other"):
        operator.line.ask(
            key,
            b"",
            b"",
            timeout=1.0,
            answered=lambda payload, header, key=key: ends.append((key, payload, header)),
            failed=lambda error, why, key=key: ends.append((key, error, why)),
        )
    operator.wait(lambda: len(ends) == 4)
    assert sorted(map(repr, ends)) == [
        "('f/ask', 'NotAllowedError', 'no, of course')",
        "('f/clock', b'now', None)",
        "('f/last/x', b'5', b'a')",
        "('f/other', 'QueryTimeoutError', 'nothing in the fleet answers at f/other within 1 s')",
    ]


@pytest.mark.usefixtures("router")
def test_answer_that_is_too_long_is_a_failure(
    sides: Sides, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hub.zenoh.fleet_line.LONGEST", 100)  # Zenoh drops many that are longer
    robot, operator = sides
    robot.line.respond_at_once("f/long", lambda: bytes(101))
    operator.wait(lambda: robot.line.connected and operator.line.connected)
    ends: list[object] = []
    operator.line.ask(
        "f/long",
        b"",
        b"",
        timeout=5.0,
        answered=lambda payload, _: ends.append(len(payload)),
        failed=lambda error, why: ends.append((error, why)),
    )
    operator.wait(lambda: ends)
    assert ends == [("QueryError", "the answer at f/long has 101 bytes, which is more than 100")]


@pytest.mark.usefixtures("router")
def test_line_has_a_link_of_its_own_for_commands_and_states(
    place: RouterPlace, router: FleetSession, sides: Sides
) -> None:
    operator = sides[0]
    operator.wait(lambda: operator.line.connected)
    until(lambda: len(router.links()) == 4, 5.0)  # of two programs
    assert place.on_loopback


@pytest.mark.usefixtures("router")
def test_payloads_that_are_too_long_do_not_wait_but_stops_count(sides: Sides) -> None:
    robot, operator = sides
    came: list[tuple[str, int]] = []
    robot.line.subscribe(
        "f/command/*",
        lambda key, payload, _: came.append((key, len(payload))),
        keep=lambda key: key.endswith("stop"),
    )
    operator.wait(lambda: robot.line.connected and operator.line.connected)

    def stopped() -> bool:
        for name in ("velocity", "stop"):
            operator.line.put(f"f/command/{name}", bytes(LONGEST + 1), b"", Plane.COMMAND)
        return ("f/command/stop", 0) in came

    operator.wait(stopped)
    assert {key for key, _ in came} == {"f/command/stop"}
    assert robot.line.dropped >= 1


_PROGRAM = """
import signal, sys
from hub.ipc.transport.loop import Loop
from hub.zenoh.fleet_line import ZenohFleetLine
from hub.zenoh.settings import client_settings, parse_place

def end(*_):
    raise SystemExit(7)

signal.signal(signal.SIGTERM, end)
place, seen, kept = parse_place("PLACE"), [], []
loop = Loop()
line = ZenohFleetLine(place, client_settings(place), loop)
line.watch("f/alive", lambda key, _: seen.append(key))
line.declare_token("f/alive")
line.subscribe("f/command/*", lambda *_: None)
line.respond("f/ask", kept.append)
line.respond_at_once("f/clock", lambda: b"now")
line.watch_subscribers("f/state", seen.append)
while not seen:
    loop.listen(0.01)
line.ask("f/ask", b"", b"", timeout=60.0, answered=print, failed=print)
while not kept:
    loop.listen(0.01)
EVENT
"""


@pytest.mark.usefixtures("router")
def test_program_ends_by_an_error_or_a_signal_while_its_line_is_open(place: RouterPlace) -> None:
    ends = {"1 / 0": 1, "signal.raise_signal(signal.SIGTERM)": 7}
    programs = [
        subprocess.Popen(
            [sys.executable, "-c", _PROGRAM.replace("PLACE", str(place)).replace("EVENT", event)],
            cwd=ROOT,
            stderr=subprocess.PIPE,
        )
        for event in ends
    ]
    try:
        for program, code in zip(programs, ends.values(), strict=True):
            said = program.communicate(timeout=30.0)[1]
            assert program.returncode == code, said
    finally:
        for program in programs:
            program.kill()
            program.communicate()


def test_handover_is_bounded_keeps_the_newest_of_a_name_and_goes_on_after_a_fault(
    caplog: pytest.LogCaptureFixture,
) -> None:
    posted: list[object] = []
    done: list[object] = []
    handover = Handover(posted.append, most=3)
    handover.add(lambda: done.append("stop"), keep=True)
    handover.add(lambda: 1 / 0)
    handover.add(lambda: done.append("old"), name="v")
    handover.add(lambda: done.append("new"), name="v")
    handover.add(lambda: done.append("last"))
    assert len(posted) == 1
    assert handover.dropped == 1
    posted[0]()
    assert done == ["stop", "new", "last"]
    handover.add(lambda: 1 / 0)
    posted[1]()
    assert "a call from a fleet failed" in caplog.text


def test_handover_keeps_few_bytes_waiting() -> None:
    posted: list[object] = []
    done: list[object] = []
    handover = Handover(posted.append)
    handover.add(lambda: done.append("stop"), keep=True, name="stop")
    for number in range(100):
        handover.add(lambda number=number: done.append(number), size=MOST_BYTES // 4)
    handover.add(lambda: done.append("same"), name="v", size=MOST_BYTES // 4)
    handover.add(lambda: done.append("new"), name="v", size=MOST_BYTES // 4)
    handover.add(lambda: done.append("too large"), size=MOST_BYTES + 1)
    handover.add(lambda: done.append("halt"), keep=True, size=MOST_BYTES)
    posted[0]()
    assert done == ["stop", 97, 98, 99, "new", "halt"]
    assert handover.dropped == 98
    done.clear()
    for number in range(5):
        handover.add(lambda number=number: done.append(number), size=MOST_BYTES // 4)
    posted[1]()
    assert done == [1, 2, 3, 4]


def test_sender_makes_no_call_that_is_too_late() -> None:
    sender, done = Sender("trial"), []
    sender.add(lambda: done.append("late"), until=time.monotonic() - 1.0)
    sender.add(lambda: done.append("in time"), until=math.inf)
    until(lambda: done, 5.0)
    assert (done, sender.dropped) == (["in time"], 1)
    sender.close()


@pytest.mark.parametrize(
    "text", ["tcp/127.0.0.1", "udp/a:1", "tcp/:7447", "tls/h:0", "tcp/h:99999"]
)
def test_text_that_is_no_place_of_a_router_is_refused(text: str) -> None:
    with pytest.raises(EndpointError, match="cannot be a place of a router"):
        parse_place(text)


def test_router_is_open_to_this_machine_only_without_certificates() -> None:
    assert str(parse_place("tcp/[::1]:7447")) == "tcp/[::1]:7447"
    for place in ("tcp/0.0.0.0:7447", "tls/0.0.0.0:7447", "tcp/robot.example:7447"):
        with pytest.raises(EndpointError, match="rune-hub fleet keys"):
            router_settings([parse_place(place)])
    with pytest.raises(EndpointError, match="needs certificates"):
        client_settings(parse_place("tls/localhost:7447"))


def test_only_certificate_of_an_operator_in_a_folder_says_who_it_is(tmp_path: Path) -> None:
    for name, only in (
        ("authority", ""),
        ("robot-rover", ""),
        ("observe-the-wall", "observe:the-wall"),
        ("operate-ann", ""),
    ):
        (tmp_path / f"{name}.pem").touch()
        assert CertificateFiles.only_operator(tmp_path) == only
