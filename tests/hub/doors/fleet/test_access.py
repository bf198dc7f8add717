"""Certificates by role at a real router: who may not, does not get through."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from hub.doors.fleet.access import access_table
from hub.doors.fleet.certificates import Certificates, files_of
from hub.errors import FleetKeyError, KeyFileError, KeyNameError, RouterUnreachableError
from hub.zenoh.fleet_session import FleetSession, FleetWay, open_fleet_session
from hub.zenoh.session import connect
from hub.zenoh.settings import RouterPlace, client_settings, router_settings
from tests.support.command_line import rune_hub
from tests.support.ports import free_port
from tests.support.waiting import until

STOP, DRIVE = "GCM_Stop", "GCM_Velocity_Command"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("keys") / "fleet"
    made = Certificates(path)
    for name, role in (
        ("localhost", "router"),
        ("a", "robot"),
        ("b", "robot"),
        ("alice", "operate"),
        ("wall", "observe"),
        ("gone", "operate"),
    ):
        made.make(name, role, days=2)
    made.remove("operate:gone")
    return path


class GuardedFleet:
    """A router with TLS, and sessions with certificates."""

    def __init__(self, folder: Path, others: Sequence[RouterPlace] = ()) -> None:
        self.folder = folder
        self.place = RouterPlace(scheme="tls", host="localhost", port=free_port())
        certificates = Certificates(folder)
        self._settings = router_settings(
            [self.place],
            certificates=certificates.of_router(),
            access=access_table("rune", certificates.holders()),
            others=others,
        )
        self.sessions = [self._router()]

    def _router(self) -> FleetSession:
        return open_fleet_session(self.place, self._settings, mode="router")

    def restart(self) -> None:
        self.sessions[0].close()
        self.sessions[0] = self._router()

    def close(self) -> None:
        for session in reversed(self.sessions):
            session.close()

    def join(self, name: str) -> FleetSession:
        settings = client_settings(self.place, certificates=files_of(self.folder, name))
        self.sessions.append(open_fleet_session(self.place, settings))
        return self.sessions[-1]


@pytest.fixture
def fleet(folder: Path) -> Iterator[GuardedFleet]:
    made = GuardedFleet(folder)
    yield made
    made.close()


def test_each_certificate_may_do_what_its_role_says_and_no_more(fleet: GuardedFleet) -> None:
    a, b, alice, wall, gone = (
        fleet.join(name)
        for name in ("robot:a", "robot:b", "operate:alice", "observe:wall", "operate:gone")
    )
    at_a, at_b, at_wall = [], [], []
    keep = [
        a.subscribe("rune/v1/a/command/*/*", lambda each: at_a.append(each.key.split("/", 4)[4])),
        b.subscribe("rune/v1/*/command/*/*", lambda each: at_b.append(each.key)),
        wall.subscribe("rune/v1/*/state/*", lambda each: at_wall.append(each.key)),
        wall.subscribe("rune/v1/*/command/*/*", lambda each: at_wall.append(each.key)),
        a.declare_token("rune/v1/a/alive"),
        b.declare_token("rune/v1/c/alive"),
        a.respond("rune/v1/a/last/*", lambda query: query.answer(b"1")),
        a.respond("rune/v1/a/ask/*/*", lambda query: query.answer(b"2")),
    ]

    def command(session: FleetSession, who: str, message: str) -> None:
        session.put(f"rune/v1/a/command/{who}/{message}", b"x", None, FleetWay.COMMAND)

    def go() -> bool:
        command(wall, "observe:wall", STOP)
        command(wall, "observe:wall", DRIVE)
        command(wall, "operate:alice", DRIVE)
        command(gone, "operate:gone", DRIVE)
        command(b, "operate:alice", DRIVE)
        command(alice, "supervise:alice", DRIVE)
        b.put("rune/v1/a/state/X", b"b says that it is a", None, FleetWay.STATE)
        a.put("rune/v1/a/state/X", b"a", None, FleetWay.STATE)
        command(alice, "operate:alice", DRIVE)
        time.sleep(0.05)  # between two tries; the test waits for the condition
        return bool(at_wall and f"operate:alice/{DRIVE}" in at_a and f"observe:wall/{STOP}" in at_a)

    until(go, 15.0)
    assert set(at_a) == {f"observe:wall/{STOP}", f"operate:alice/{DRIVE}"}
    assert at_b == []
    assert set(at_wall) == {"rune/v1/a/state/X"}
    ask = {"way": FleetWay.COMMAND, "timeout": 1.0}
    assert alice.tokens("rune/v1/*/alive", timeout=1.0) == ["rune/v1/a/alive"]
    assert [each.payload for each in wall.answers("rune/v1/a/last/X", **ask)] == [b"1"]
    assert alice.answers("rune/v1/a/ask/operate:alice/X", **ask)[0].payload == b"2"
    assert wall.answers("rune/v1/a/ask/operate:alice/X", **ask) == []
    for each in keep:
        each.undeclare()


def test_joined_routers_carry_what_each_allows_and_find_each_other_again(
    fleet: GuardedFleet, folder: Path
) -> None:
    far = GuardedFleet(folder, others=[fleet.place])
    try:
        a = fleet.join("robot:a")
        alice, wall = far.join("operate:alice"), far.join("observe:wall")
        there: list[str] = []
        keep = [
            a.subscribe("rune/v1/a/command/*/*", lambda each: there.append(each.key)),
            a.declare_token("rune/v1/a/alive"),
        ]

        def go() -> bool:
            for who, message in (("observe:wall", DRIVE), ("operate:alice", DRIVE)):
                key = f"rune/v1/a/command/{who}/{message}"
                wall.put(key, b"x", None, FleetWay.COMMAND)
            key = f"rune/v1/a/command/operate:alice/{STOP}"
            alice.put(key, b"x", None, FleetWay.COMMAND)
            return bool(there)

        until(go, 15.0)
        assert alice.tokens("rune/v1/*/alive", timeout=2.0) == ["rune/v1/a/alive"]
        fleet.restart()
        there.clear()
        until(go, 15.0)
        assert {key.split("/", 4)[4] for key in there} == {f"operate:alice/{STOP}"}
        for each in keep:
            each.undeclare()
    finally:
        far.close()


def test_program_without_a_certificate_of_the_fleet_does_not_come_in(
    fleet: GuardedFleet, folder: Path, tmp_path: Path
) -> None:
    other = Certificates(tmp_path / "other")
    other.make("alice", "operate", days=2)
    shutil.copy(folder / "authority.pem", tmp_path / "other" / "authority.pem")
    settings = client_settings(
        fleet.place, certificates=files_of(tmp_path / "other", "operate:alice")
    )
    with pytest.raises(RouterUnreachableError):  # the router refuses
        connect(str(fleet.place), mode="client", settings=settings).close()
    with pytest.raises(KeyFileError, match="has not made it"):  # a person reads why
        open_fleet_session(fleet.place, settings).close()


def test_names_that_make_no_certificate_are_refused_in_words(folder: Path, tmp_path: Path) -> None:
    made = Certificates(folder)
    for name in ("", "../x", "a/b", "x" * 51, "ä"):
        with pytest.raises(KeyNameError, match="is no name"):
            made.make(name, "operate", days=1)
    with pytest.raises(KeyNameError, match="has a certificate"):
        made.make("alice", "operate", days=1)
    with pytest.raises(KeyNameError, match="there is no certificate"):
        made.remove("operate:bob")
    with pytest.raises(KeyFileError, match="--role router"):
        Certificates(tmp_path).of_router()
    place = RouterPlace(scheme="tls", host="localhost", port=1)
    bob = client_settings(place, certificates=files_of(folder, "operate:bob"))
    with pytest.raises(KeyFileError, match="rune-hub fleet keys make"):
        open_fleet_session(place, bob)
    with pytest.raises(FleetKeyError, match="ROLE:NAME"):
        files_of(folder, "alice")
    (folder / "list.toml").chmod(0o644)
    with pytest.raises(KeyFileError, match="chmod 600"):
        made.holders()
    (folder / "list.toml").chmod(0o600)


def test_commands_say_what_they_made_and_what_is_wrong(tmp_path: Path) -> None:
    keys = ("fleet", "keys")
    where = ("--folder", str(tmp_path / "fleet"))
    done = rune_hub(*keys, "make", "alice", "--role", "operate", *where)
    assert (done.returncode, "operate-alice.pem" in done.stdout) == (0, True)
    assert "--as operate:alice --keys FOLDER" in done.stderr
    place = rune_hub("fleet", "list", "--fleet", "tls/robot:7447")
    assert (place.returncode, "--connect tls/robot:7447" in place.stderr) == (2, True)
    for host, files in (("a.example", "router"), ("b.example", "router-b.example")) * 2:
        made = rune_hub(*keys, "make", host, "--role", "router", *where)
        assert made.stdout.startswith(f"{tmp_path / 'fleet' / files}.pem")
        assert ("list.toml" in made.stderr) == (host == "b.example")
    refused = rune_hub("fleet", "router", "--listen", "tcp/0.0.0.0:7447")
    assert (refused.returncode, "this machine only" in refused.stderr) == (2, True)
    silent = rune_hub("fleet", "list", "--connect", f"tcp/127.0.0.1:{free_port()}")
    assert (silent.returncode, "start one there: `rune-hub fleet router`" in silent.stderr) == (
        3,
        True,
    )
