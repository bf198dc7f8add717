"""A console in a fleet with certificates, as the page has it: it drives until one is removed."""

from __future__ import annotations

import shutil
from contextlib import closing
from pathlib import Path

import pytest

from hub.doors.fleet.certificates import Certificates
from hub.gcm.control import CONTROL_STATE
from tests.system.fleet_site import Site, stopped_after
from tests.system.harness import drive

_STOPPED_S = 3.0
"""The router looks at its list once a second; 0.3 s later the robot stops [s]."""


@pytest.mark.soak
def test_console_with_a_certificate_drives_until_it_is_removed(tmp_path: Path) -> None:
    certificates = Certificates(tmp_path / "authority")
    for name, role in (("localhost", "router"), ("rover", "robot"), ("alice", "operate")):
        certificates.make(name, role, days=2)
    alices = tmp_path / "alice"
    alices.mkdir()
    for name in ("operate-alice.pem", "operate-alice.key", "authority.pem"):
        shutil.copy(certificates.folder / name, alices)
    folder = tmp_path / "site"
    folder.mkdir()
    with (
        closing(Site(folder, certificates.folder)) as site,
        closing(site.console("--keys", str(alices))) as console,
    ):
        drive(console, site.observer)
        state = lambda: site.newest(CONTROL_STATE.name)  # noqa: E731
        site.observer.wait(lambda: state().operator, 10.0)
        assert state().operator == "alice", "the certificate names the operator"
        stopped_after(site.observer)
        certificates.make("bob", "operate", days=2)
        drive(console, site.observer)
        assert "linked" in console.text, "a new certificate ends no session"
        with console.holding("w"):
            certificates.remove("operate:alice")
            assert stopped_after(site.observer) < _STOPPED_S
            console.wait(lambda: "LINK LOST" in console.text, 10.0)
        site.observer.wait(lambda: state().owner == 0, 10.0)
