"""A mission outlives whatever dies: mapping, the daemon, the last console."""

from __future__ import annotations

import os
import signal
from contextlib import ExitStack
from pathlib import Path

import pytest

from hub.gcm import mapping
from hub.gcm.mission import MissionAction
from tests.support.waiting import until
from tests.system.mission_site import Site, killed_often


@pytest.fixture
def site(tmp_path: Path) -> Site:
    with ExitStack() as stack:
        made = Site(tmp_path)
        stack.callback(made.close)
        yield made


def known(site: Site) -> int:
    found = site.watch.client.query_response(
        mapping.MAP_REQUEST, mapping.MapRequest(x=float("nan")), mapping.MAP, timeout=10.0
    )
    return found.data.size


def test_marks_and_map_outlive_mapping_and_daemon(site: Site) -> None:
    site.begin()
    site.mark(1.5)
    site.mark(2.5)
    site.watch.wait(lambda: known(site) > 200, 10.0, "nothing is mapped")
    site.watch.wait(lambda: site.state.map_age_s < 60.0, 10.0, "the map is not saved")
    before = site.points
    for again in range(2):
        pid = site.mapping_pid
        os.kill(pid, signal.SIGKILL)
        # Nobody wants mapping but the mission.
        site.watch.wait(lambda pid=pid: site.mapping_pid not in (0, pid), 20.0, "no new process")
        site.forget()
        site.ask()
        assert sorted(site.points) == sorted(before)
        assert known(site) > 200
        site.mark(3.5 + again)
        before = site.points
    site.kill()
    site.start()
    site.ask()
    assert site.points.keys() == before.keys() == {1, 2, 3, 4}
    assert all(point.kept for point in site.points.values())
    assert (site.state.name, site.state.running, site.state.sheet) == ("search one", 1, 1)
    assert known(site) > 200
    site.order(MissionAction.END)
    # Nobody wants mapping any more.
    until(
        lambda: site.mapping_pid == 0, 20.0, "mapping goes on",
        meanwhile=lambda: site.watch.client.listen(0.05),
    )  # fmt: skip


@pytest.mark.soak
def test_no_confirmed_mark_is_lost_when_processes_are_killed(site: Site) -> None:
    """A few kills; `make soak` has two hundred."""
    counts = killed_often(site, ["mapping", "console", "mapping", "daemon", "mapping"], seed=3)
    assert counts["lost"] == 0
    assert counts["confirmed"] > 0
