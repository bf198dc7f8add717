"""`rune-hub fleet router` while its certificates change: robots stop for a removal only."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hub.doors.fleet.certificates import Certificates, files_of
from hub.zenoh.fleet_session import open_fleet_session
from hub.zenoh.settings import RouterPlace, client_settings
from tests.support.ports import free_port
from tests.support.waiting import until


@pytest.fixture
def certificates(tmp_path: Path) -> Certificates:
    made = Certificates(tmp_path / "fleet")
    for name, role in (("localhost", "router"), ("ann", "operate"), ("bob", "operate")):
        made.make(name, role, days=2)
    return made


@pytest.fixture
def place() -> RouterPlace:
    return RouterPlace(scheme="tls", host="localhost", port=free_port())


@pytest.fixture
def router(certificates: Certificates, place: RouterPlace) -> Iterator[subprocess.Popen[str]]:
    words = ["--listen", str(place), "--tls", str(certificates.folder)]
    command = [sys.executable, "-m", "hub", "fleet", "router", *words]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    yield process
    process.terminate()
    process.communicate()


def said(router: subprocess.Popen[str]) -> str:
    assert router.stdout is not None
    return router.stdout.readline()


def test_new_certificate_waits_for_operators_and_a_removed_one_counts_at_once(
    certificates: Certificates, place: RouterPlace, router: subprocess.Popen[str]
) -> None:
    assert str(place) in said(router)
    settings = client_settings(place, certificates=files_of(certificates.folder, "operate:ann"))
    with closing(open_fleet_session(place, settings)) as ann:
        links: list[bool] = []
        kept = [ann.declare_token("rune/v1/a/operator/operate:ann/1"), ann.watch_link(links.append)]
        until(lambda: links, 5.0)
        certificates.make("carl", "operate", days=2)
        line = said(router)
        assert line.startswith("operate:carl waits until no operator is in the fleet (1 session")
        assert f"kill -USR1 {router.pid}" in line
        assert False not in links
        router.send_signal(signal.SIGUSR1)
        assert "counts now" in said(router)
        until(lambda: links[-2:] == [False, True], 10.0)
        certificates.remove("operate:bob")
        assert "counts now" in said(router)
        for each in kept:
            each.undeclare()
