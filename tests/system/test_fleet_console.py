"""A console in a fleet: real hub, gateway, router and mirror; who dies between stops the robot."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hub.doors.fleet.options import operator_of
from hub.gcm.control import CONTROL_STATE
from hub.ipc.roles import Role
from hub.zenoh.fleet_keys import FleetKey, KeyKind
from hub.zenoh.fleet_session import FleetWay, open_fleet_session
from hub.zenoh.settings import client_settings, parse_place
from tests.conftest import leaving_nothing
from tests.support.ports import free_port
from tests.support.waiting import until
from tests.system.fleet_site import Site, mirror_of, stopped_after
from tests.system.harness import ConsoleProcess, HubProcess, drive, gone, in_soak

STOPPED_S = 1.0
"""0.35 s, with room for a busy machine [s]."""


@pytest.fixture(scope="module", autouse=True)
def nothing_left_behind() -> Iterator[None]:
    """Processes of the site are started again in the middle of a test, and stay for the next."""
    with leaving_nothing():
        yield


@pytest.fixture(scope="module")
def site(nothing_left_behind: None, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    del nothing_left_behind
    with closing(Site(tmp_path_factory.mktemp("fleet"))) as made:
        yield made


@pytest.fixture
def console(site: Site) -> Iterator[ConsoleProcess]:
    with closing(site.console("--operator", "ann")) as made:
        yield made


def test_console_drives_and_has_control_as_at_a_hub(site: Site, console: ConsoleProcess) -> None:
    drive(console, site.observer)
    assert stopped_after(site.observer) < STOPPED_S + 1.0  # the key is released first
    state = site.newest(CONTROL_STATE.name)
    assert state.operator == "ann"
    console.wait(lambda: "you have control" in console.text, 10.0, console.text)
    mirror = mirror_of(console)
    _refuse(site, "that was 9 s old")
    console.wait(lambda: "gateway refused: that was 9 s old" in console.text, 10.0, console.text)
    assert console.quit() == 0
    site.observer.wait(lambda: site.newest(CONTROL_STATE.name).owner == 0, 10.0)
    until(lambda: gone([mirror]), 10.0, "the mirror is left")


def _refuse(site: Site, why: str) -> None:
    """Refuse a command as the robot's gateway does."""
    who = operator_of(argparse.Namespace(operator=None, tls=None), Role.OPERATE)
    key = FleetKey(kind=KeyKind.REFUSAL, robot="rover", operator=who).under("rune/lab")
    place = parse_place(site.place)
    with closing(open_fleet_session(place, client_settings(place))) as session:
        session.put(key, why.encode(), None, FleetWay.STATE)


@pytest.mark.parametrize("victim", ["mirror", *in_soak("console", "router", "paused mirror")])
def test_robot_stops_and_needs_neutral_when_one_between_is_killed_or_paused(
    site: Site, console: ConsoleProcess, victim: str
) -> None:
    observer, mirror = site.observer, mirror_of(console)
    drive(console, observer)
    with console.holding("w"):  # the operator does not notice, and keeps the key down
        if victim == "router":
            site.kill_router()
        elif victim == "paused mirror":
            mirror.suspend()
        else:
            os.kill(mirror.pid if victim == "mirror" else console.process.pid, signal.SIGKILL)
        took = stopped_after(observer)
        assert took < STOPPED_S
        print(f"{victim}: zero after {took:.3f} s")  # noqa: T201
        if victim == "router":
            site.start_router()
        if victim != "console":
            console.wait(lambda: "linked" not in console.text, 10.0, console.text)
            if victim == "paused mirror":  # commands of before are still in its sockets
                mirror.resume()
            # A narrow status line says what to do about the held key in place of "linked".
            words = ("linked", "LET GO")
            console.wait(lambda: any(word in console.text for word in words), 20.0, console.text)
        assert observer.truth.commanded_linear == 0.0
    if victim == "console":
        until(lambda: gone([mirror]), 10.0, "the mirror is left")
    else:
        drive(console, observer)  # from neutral
        stopped_after(observer)


@pytest.mark.soak
def test_robot_that_leaves_is_shown_as_lost_and_comes_back(
    site: Site, console: ConsoleProcess
) -> None:
    os.kill(site.hub.pids["fleet"], signal.SIGKILL)
    console.wait(lambda: "left the fleet" in console.text, 10.0, console.text)
    console.wait(lambda: "linked" in console.text, 20.0, console.text)


def test_auto_names_who_is_there_and_makes_a_layout(site: Site, tmp_path: Path) -> None:
    picture = tmp_path / "shot.txt"
    words = [sys.executable, "-m", "rune_tui", "shot", "auto", "--fleet", site.place]
    words += ["--fleet-name", "rune/lab", "--seconds", "3", "--output", str(picture)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, "in the fleet rune/lab: rover" in done.stderr) == (0, True), done
    assert "linked" in picture.read_text()


@pytest.mark.soak
def test_robot_that_joins_later_is_named_and_a_key_shows_it_beside_the_driven_one(
    site: Site, tmp_path: Path
) -> None:
    words = ["run", "auto", "--fleet", site.place, "--fleet-name", "rune/lab"]
    observer = site.observer
    with closing(ConsoleProcess([*words, "--operator", "ann"])) as console:
        console.wait_for_picture(40.0)
        with closing(HubProcess(tmp_path, tables=site.table("boat"))):
            console.wait(lambda: "boat joined the fleet" in console.text, 30.0, console.text)
            assert "2 boat" not in console.text, "the view waits for the key"
            # It turns in place, because the robot of all these tests may be at the wall.
            console.hold_until("a", lambda: observer.truth.angular > 0.2)
            with console.holding("a"):
                console.type("\x1bOS")  # F4
                console.wait(lambda: "2 boat" in console.text, 10.0, console.text)
                observer.wait(lambda: observer.truth.commanded_angular == 0.0, 5.0, "it turns on")
            # The robot of before is the chosen one still, and begins from neutral.
            console.hold_until("d", lambda: observer.truth.angular < -0.2)
            assert console.quit() == 0


@pytest.mark.soak
def test_what_is_not_in_the_fleet_is_said_in_a_sentence(site: Site) -> None:
    words = [sys.executable, "-m", "rune_tui", "shot", "auto", "-o", "x.txt", "--only", "nobody"]
    for code, place, why in (
        (3, site.place, "nobody is not in the fleet rune now"),
        (3, f"tcp/127.0.0.1:{free_port()}", "no router of a fleet answers at tcp/127.0.0.1:"),
        (2, "tls/localhost:1", "needs your certificate: give the folder with its files by --keys"),
        (2, "udp/here", "write tcp/HOST:PORT or tls/HOST:PORT"),
    ):
        done = subprocess.run(
            [*words, "--fleet", place], capture_output=True, text=True, check=False
        )
        assert (done.returncode, why in done.stderr) == (code, True), done
