"""A Zenoh router with an authority of its own: robots behind it need certificates of a folder."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from hub.command_line import ExitCode
from hub.doors.fleet.certificates import Certificates
from hub.errors import KeyFileError
from hub.inspection.doctor.finding import Level
from hub.inspection.doctor.ros_checks import ros
from hub.robots.robot_file import read_description
from hub.zenoh.router_tls import tls_settings
from tests.support.command_line import rune_hub
from tests.support.ros_node import STORE, Paced, RosNode, encoded
from tests.support.zenoh_router import ZenohRouter, zenoh_router

ODOMETRY, TWIST = "nav_msgs/msg/Odometry", "geometry_msgs/msg/Twist"


@pytest.fixture(scope="module")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Certificates:
    made = Certificates(tmp_path_factory.mktemp("tls") / "authority")
    for name, role in (("localhost", "router"), ("rune", "operate"), ("other", "operate")):
        made.make(name, role, days=2)
    return made


@pytest.fixture
def folder(authority: Certificates, tmp_path: Path) -> Path:
    """What a machine of the network has."""
    own = tmp_path / "own"
    own.mkdir()
    for name in ("authority.pem", "operate-rune.pem", "operate-rune.key"):
        shutil.copy(authority.folder / name, own)
    return own


@pytest.fixture
def router(authority: Certificates) -> Iterator[ZenohRouter]:
    with zenoh_router(authority.of_router()) as running:
        yield running


@pytest.fixture
def robot(router: ZenohRouter) -> Iterator[RosNode]:
    node = RosNode(router.endpoint)
    node.subscribe("/cmd_vel", TWIST, lambda _, __: None)
    publish = node.publisher("/odom", ODOMETRY)
    odometry = encoded(ODOMETRY, zeros(ODOMETRY))
    paced = Paced(lambda: publish(odometry), 20.0)
    yield node
    paced.leave()
    node.leave()


def zeros(kind: str) -> object:
    """A message in which all is zero."""
    types = STORE.types
    vector = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
    pose = types["geometry_msgs/msg/Pose"](
        position=types["geometry_msgs/msg/Point"](x=0.0, y=0.0, z=0.0),
        orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
    )
    return types[kind](
        header=types["std_msgs/msg/Header"](
            stamp=types["builtin_interfaces/msg/Time"](sec=1, nanosec=0), frame_id="odom"
        ),
        child_frame_id="base_link",
        pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](
            twist=types[TWIST](linear=vector, angular=vector), covariance=np.zeros(36)
        ),
    )


@pytest.mark.usefixtures("robot")
def test_a_robot_behind_a_router_with_tls_is_adopted_and_looked_at(
    router: ZenohRouter, folder: Path, tmp_path: Path
) -> None:
    address, path = f"zenoh+{router.secure.replace('/', '://')}", tmp_path / "robot.toml"
    without = rune_hub("adopt", address, "--seconds", "1")
    assert without.returncode == ExitCode.NO_HUB
    done = rune_hub("adopt", address, "--tls", str(folder), "--seconds", "2", "-o", str(path))
    assert done.returncode == ExitCode.OK, done.stderr
    table = tomllib.loads(path.read_text())["ros"]
    assert (table["address"], table["certificates"]) == (address, str(folder))
    first = ros(read_description(path)[0])[0]
    assert (first.level, address in first.text) == (Level.OK, True)
    refused = rune_hub("adopt", "zenoh+tcp://localhost:7447", "--tls", str(folder))
    assert refused.returncode == ExitCode.USAGE
    assert "--tls is for a Zenoh router, such as zenoh+tls://" in refused.stderr
    path.write_text(path.read_text().replace("zenoh+tls", "zenoh+tcp"))
    assert "for an address with zenoh+tls:// only" in rune_hub("check", str(path)).stderr


def test_the_folder_has_an_authority_and_one_certificate_at_most(
    authority: Certificates, folder: Path
) -> None:
    own = tls_settings(folder)["transport/link/tls"]
    assert own["connect_certificate"] == str(folder / "operate-rune.pem")
    with pytest.raises(KeyFileError, match=r"operate-other, operate-rune; leave one"):
        tls_settings(authority.folder)
    (folder / "operate-rune.key").chmod(0o644)
    with pytest.raises(KeyFileError, match="chmod 600"):
        tls_settings(folder)
    (folder / "operate-rune.key").unlink()
    alone = {"root_ca_certificate": str(folder / "authority.pem")}
    assert tls_settings(folder) == {"transport/link/tls": alone}
    (folder / "authority.pem").unlink()
    with pytest.raises(KeyFileError, match="cannot be read"):
        tls_settings(folder)
