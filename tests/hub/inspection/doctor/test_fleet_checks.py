"""What the doctor says of [fleet], with real certificates and a real router."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

import pytest

from hub.doors.fleet.access import access_table
from hub.doors.fleet.certificates import Certificates, files_of
from hub.errors import KeyFileError
from hub.inspection.doctor import fleet_checks
from hub.inspection.doctor.finding import Finding, Level
from hub.zenoh.certificate_facts import read_certificate
from hub.zenoh.fleet_session import FleetSession, open_fleet_session
from hub.zenoh.settings import RouterPlace, client_settings, router_settings
from tests.hub.inspection.robots import robot
from tests.support.command_line import rune_hub
from tests.support.ports import free_port


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys") / "fleet"
    made = Certificates(folder)
    for name, role in (("localhost", "router"), ("magellan", "robot"), ("ann", "operate")):
        made.make(name, role, days=90)
    made.make("short", "robot", days=3)
    return folder


def said(folder: Path, table: str) -> list[Finding]:
    return fleet_checks.fleet(robot(folder, f"[fleet]\n{table}"))


def only(found: list[Finding], level: Level) -> str:
    (one,) = [each.text for each in found if each.level is level]
    return one


def test_without_a_fleet_nothing_is_looked_at(tmp_path: Path) -> None:
    (found,) = fleet_checks.fleet(robot(tmp_path))
    assert found.level is Level.OK


def test_router_name_and_certificate_are_looked_at(keys: Path, tmp_path: Path) -> None:
    place = RouterPlace(scheme="tls", host="localhost", port=free_port())
    table = f'router = "{place}"\ncertificates = "{keys}"'
    assert f"answers at {place}, or it does not know" in only(said(tmp_path, table), Level.PROBLEM)
    certificates = Certificates(keys)
    access = access_table("rune", certificates.holders())
    settings = router_settings([place], certificates=certificates.of_router(), access=access)
    sessions: list[FleetSession] = [open_fleet_session(place, settings, mode="router")]
    try:
        found = said(tmp_path, table)
        assert {each.level for each in found} == {Level.OK}
        assert "for robot:magellan, until 20" in found[0].text
        assert "the name magellan is free in the fleet rune" in found[2].text
        short = said(tmp_path, f'{table}\nname = "short"')
        assert "the certificate of robot:short ends on 20" in only(short, Level.WARNING)
        own = client_settings(place, certificates=files_of(keys, "robot:magellan"))
        sessions.append(open_fleet_session(place, own))
        token = sessions[1].declare_token("rune/v1/magellan/alive")
        taken = only(said(tmp_path, table), Level.PROBLEM)
        assert taken == "another robot of the fleet rune has the name magellan now"
        token.undeclare()
    finally:
        for session in reversed(sessions):
            session.close()


def test_certificates_that_do_not_count_are_refused_in_words(keys: Path, tmp_path: Path) -> None:
    files = files_of(keys, "robot:magellan")
    facts = read_certificate(files)
    assert facts.name == "robot:magellan"
    assert facts.begins <= time.time() + 60.0
    assert 89.0 < facts.days_left <= 90.0
    copied = tmp_path / "copied"
    shutil.copytree(keys, copied)
    broken = files_of(copied, "robot:magellan")

    def why() -> str:
        with pytest.raises(KeyFileError) as refused:
            read_certificate(broken)
        return str(refused.value)

    broken.key.chmod(0o644)
    assert "say chmod 600" in why()
    broken.key.chmod(0o600)
    shutil.copy(copied / "operate-ann.key", broken.key)
    assert "does not fit its key" in why()
    shutil.copy(keys / "robot-magellan.key", broken.key)
    Certificates(tmp_path / "other").make("x", "robot", days=1)
    shutil.copy(tmp_path / "other" / "authority.pem", broken.authority)
    assert "has not made it" in why()
    broken.authority.write_text("no certificate")
    assert "authority.pem is damaged" in why()
    broken.certificate.unlink()
    assert "`rune-hub fleet keys make`, and copy" in why()
    shutil.copy(keys / "operate-ann.pem", copied / "robot-short.pem")
    shutil.copy(keys / "operate-ann.key", copied / "robot-short.key")
    shutil.copy(keys / "authority.pem", copied / "authority.pem")
    table = f'name = "short"\nrouter = "tls/localhost:1"\ncertificates = "{copied}"'
    assert "is for operate:ann" in only(said(tmp_path, table), Level.PROBLEM)


def test_check_shows_how_the_robot_joins_its_fleet(tmp_path: Path) -> None:
    path = robot(tmp_path, '[fleet]\nfleet = "rune/lab"').path
    done = rune_hub("check", str(path))
    assert "in rune/lab at tcp/127.0.0.1:7447, no certificate" in " ".join(done.stdout.split())
