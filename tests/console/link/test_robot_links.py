"""The links of a layout when another layout comes: who stays is not disturbed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.errors import HubError
from hub.ipc.broker.central import Central
from hub.ipc.roles import Role
from hub.ipc.security.keyring import Keyring
from rune_tui.errors import HubChoiceError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.robot_state import LinkPhase
from rune_tui.startup.opening import open_layout
from tests.support.waiting import until


@pytest.fixture
def central(tmp_path: Path) -> Iterator[Central]:
    with closing(Central([f"ipc://{tmp_path}/c"])) as running:
        yield running


def layout_of(folder: Path, **hubs: str) -> LayoutSpec:
    robots = "".join(
        f'<robot name="{name}" hub="{hub}"><capability name="NAV_STATE"/></robot>'
        for name, hub in hubs.items()
    )
    (folder / "layout.xml").write_text(f'<rune>{robots}<view xsize="9" ysize="9"/></rune>')
    return open_layout(folder / "layout.xml")


def begin(links: RobotLinks, stack: ExitStack) -> None:
    for link in links.values():
        link.start()
    stack.callback(lambda: [link.close() for link in links.values()])


def test_who_stays_keeps_the_connection_who_is_new_gets_one_and_who_is_gone_is_handed_back(
    tmp_path: Path, central: Central
) -> None:
    hub = central.endpoints[0]
    with ExitStack() as stack:
        links = RobotLinks(layout_of(tmp_path, a=hub, b=hub))
        begin(links, stack)
        a, b = links["a"], links["b"]
        until(lambda: a.state.link.phase is LinkPhase.CONNECTED, 10.0)
        since = a.state.link.since
        layout = layout_of(tmp_path, a=hub, c=hub)
        gone = links.follow(layout)
        assert (list(links), gone, links["a"]) == (["a", "c"], [b], a)
        b.close()
        until(lambda: links["c"].state.link.phase is LinkPhase.CONNECTED, 10.0)
        until(lambda: a.spec == layout.robot("a"), 10.0)
        assert a.state.link.since == since


def test_a_robot_whose_hub_is_another_gets_another_link(tmp_path: Path, central: Central) -> None:
    with ExitStack() as stack:
        links = RobotLinks(layout_of(tmp_path, a=f"ipc://{tmp_path}/nobody"))
        begin(links, stack)
        before = links["a"]
        assert links.follow(layout_of(tmp_path, a=central.endpoints[0])) == [before]
        before.close()
        until(lambda: links["a"].state.link.phase is LinkPhase.CONNECTED, 10.0)


def test_with_a_hub_of_the_command_line_what_layouts_say_of_hubs_is_nothing(
    tmp_path: Path, central: Central
) -> None:
    with ExitStack() as stack:
        links = RobotLinks(layout_of(tmp_path, a="ipc:///one"), [central.endpoints[0]])
        begin(links, stack)
        assert links.follow(layout_of(tmp_path, a="ipc:///two")) == []


@pytest.mark.parametrize("hub", ["", "own"])
def test_what_cannot_be_followed_changes_nothing(
    tmp_path: Path, central: Central, hub: str
) -> None:
    own = central.endpoints[0]
    with ExitStack() as stack:
        links = RobotLinks(layout_of(tmp_path, a=own), [own] if hub else ())
        begin(links, stack)
        before = dict(links)
        with pytest.raises(HubChoiceError if hub else HubError):
            links.follow(layout_of(tmp_path, a=own, b="tcp://192.0.2.1:1381"))
        assert dict(links) == before


def test_one_hub_cannot_be_for_two_robots(tmp_path: Path) -> None:
    with pytest.raises(HubChoiceError, match="names 2 robots, and --hub names 1; give --hub once"):
        RobotLinks(layout_of(tmp_path, a="ipc:///a", b="ipc:///b"), ["ipc:///c"])


def test_a_layout_may_name_the_key_for_a_robot_and_another_key_is_another_link(
    tmp_path: Path,
) -> None:
    keyring, path = Keyring(tmp_path / "keys"), tmp_path / "layout.xml"
    watches = keyring.make("anna", Role.OBSERVE).relative_to(tmp_path)
    drives = keyring.make("bert", Role.OPERATE)

    def layout(key: Path) -> LayoutSpec:
        robot = f'<robot name="a" hub="localhost:1381" keys="{key}"/>'
        path.write_text(f'<rune>{robot}<view xsize="9" ysize="9"/></rune>')
        return open_layout(path)

    spec = layout(watches)
    assert spec.robots[0].hub == "tcp://localhost:1381"
    links = RobotLinks(spec)
    first = links["a"]
    assert not first.state.link.may_command
    with ExitStack() as stack:
        begin(links, stack)
        assert links.follow(layout(drives)) == [first]
        first.close()
        assert links["a"].state.link.may_command
