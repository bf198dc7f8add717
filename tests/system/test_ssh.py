"""`rune run --ssh`: a console whose way to the hub is a real ssh to a real sshd."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from hub.hub_sockets import HubFolder
from hub.ipc.broker.central import Central
from rune_tui.errors import HubChoiceError, TunnelError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link.hub_tunnel import open_tunnels, tunnel_to
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.robot_state import LinkPhase
from rune_tui.startup.opening import open_layout
from tests.support.waiting import until
from tests.system.conftest import LAYOUT
from tests.system.harness import ConsoleProcess, HubProcess, Observer, drive
from tests.system.ssh_server import SshServer, missing


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[SshServer]:
    if why := missing():
        pytest.skip(f"NOT TESTED: {why}")
    with closing(SshServer(tmp_path / "ssh")) as running:
        monkeypatch.setenv("PATH", f"{running.path}:{os.environ['PATH']}")
        yield running


def layout_of(folder: Path, hub: str, *names: str) -> LayoutSpec:
    robots = "".join(
        f'<robot name="{name}" hub="{hub}"><capability name="NAV_STATE"/></robot>' for name in names
    )
    (folder / "robots.xml").write_text(f'<rune>{robots}<view xsize="9" ysize="9"/></rune>')
    return open_layout(folder / "robots.xml")


@pytest.fixture(params=["by name", "by socket"])
def central(request: pytest.FixtureRequest) -> Iterator[Central]:
    """Its first endpoint is what a console is told."""
    with closing(HubFolder("a")) as folder, closing(Central([folder.endpoint])) as running:
        running.endpoints[:0] = ["hub://?a"] * (request.param == "by name")
        yield running


def test_a_console_drives_and_sees_through_ssh_and_ends_it(
    server: SshServer,
    start_hub: Callable[..., HubProcess],
    tmp_path: Path,
    stack: ExitStack,
) -> None:
    hub = start_hub()
    layout = tmp_path / "layout.xml"
    layout.write_text(LAYOUT.format(hub=hub.endpoint))
    arguments = ["run", "--ssh", server.target, str(layout)]
    console = stack.enter_context(closing(ConsoleProcess(arguments)))
    console.wait_for_picture()
    observer = stack.enter_context(closing(Observer(hub.endpoint)))
    drive(console, observer)
    assert len(server.running()) == 1
    assert console.quit() == 0
    until(lambda: not server.running(), 10.0, "ssh is left")


def test_ssh_ends_with_a_console_that_is_killed(server: SshServer, tmp_path: Path) -> None:
    layout = layout_of(tmp_path, f"ipc://{tmp_path}/nobody", "a")
    arguments = ["run", "--ssh", server.target, layout.path]
    console = ConsoleProcess(arguments)
    with closing(console):
        console.wait(lambda: folders(server), 20.0)
        console.wait(folders(server)[0].exists, 20.0)
        console.wait(server.running, 20.0)
        console.process.send_signal(signal.SIGKILL)
        console.wait_ended()
        until(lambda: not server.running(), 10.0, "ssh is left")
        assert not folders(server)[0].exists()


def folders(server: SshServer) -> list[Path]:
    """The folders of forwarded sockets, as ssh was told them."""
    calls = server.folder / "calls"
    words = calls.read_text().split() if calls.exists() else []
    return [Path(word[2:].partition(":")[0]).parent for word in words if word.startswith("-L")]


def test_the_way_is_made_again_when_ssh_ends_and_meanwhile_is_told_why(
    server: SshServer, central: Central, tmp_path: Path, stack: ExitStack
) -> None:
    layout = layout_of(tmp_path, central.endpoints[0], "a")
    tunnels = stack.enter_context(open_tunnels([server.target], layout))
    links = RobotLinks(layout, tunnels=tunnels)
    link = links["a"]
    link.start()
    stack.callback(link.close)
    until(lambda: link.state.link.phase is LinkPhase.CONNECTED, 15.0)
    assert link.state.link.endpoint == f"ssh {server.target}"
    server.close()
    until(lambda: link.state.link.phase is LinkPhase.LOST, 15.0)
    until(lambda: "Connection refused" in link.state.link.detail, 15.0)
    server.start()
    until(
        lambda: link.state.link.phase is LinkPhase.CONNECTED, 30.0, lambda: link.state.link.detail
    )
    until(lambda: not tunnels[0].trouble, 10.0)


def test_the_way_is_made_again_also_by_who_has_signals_blocked(
    server: SshServer, tmp_path: Path
) -> None:
    def opened_and_killed() -> None:
        signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        with closing(tunnel_to(server.target, f"ipc://{tmp_path}/nobody")) as tunnel:
            tunnel.open()
            (first,) = server.running()
            os.kill(first, signal.SIGKILL)
            until(lambda: [pid for pid in server.running() if pid != first], 15.0)
            until(lambda: not tunnel.trouble, 15.0)
            made.append(first)

    made: list[int] = []
    blocked = threading.Thread(target=opened_and_killed)
    blocked.start()
    blocked.join()
    assert made


def test_two_robots_have_a_way_each(server: SshServer, tmp_path: Path, stack: ExitStack) -> None:
    here = stack.enter_context(closing(Central([f"ipc://{tmp_path}/c"]))).endpoints[0]
    layout = layout_of(tmp_path, here, "a", "b")
    tunnels = stack.enter_context(open_tunnels([server.target] * 2, layout))
    links = RobotLinks(layout, tunnels=tunnels)
    for link in links.values():
        link.start()
        stack.callback(link.close)
    linked = LinkPhase.CONNECTED
    until(lambda: {link.state.link.phase for link in links.values()} == {linked}, 15.0)
    assert len(server.running()) == 2
    with pytest.raises(HubChoiceError, match="--ssh is given 1 times"), open_tunnels(["x"], layout):
        pass


def test_what_ssh_says_is_told_in_one_sentence(server: SshServer) -> None:
    server.use_key("other")
    with (
        closing(tunnel_to(server.target)) as refused,
        pytest.raises(TunnelError, match=r"^ssh to .* failed: .*Permission denied \(publickey\)$"),
    ):
        refused.open()
    server.use_key("key")
    server.close()
    with (
        closing(tunnel_to(server.target)) as closed,
        pytest.raises(TunnelError, match=r"failed: .*Connection refused$"),
    ):
        closed.open()
    assert not server.running()


def test_the_command_line_tells_it_and_ends_with_3(server: SshServer, tmp_path: Path) -> None:
    server.use_key("other")
    layout = layout_of(tmp_path, "localhost", "a")
    shot = ["shot", layout.path, "-o", str(tmp_path / "x.txt"), "--ssh", server.target]
    done = subprocess.run(
        [sys.executable, "-m", "rune_tui", *shot], capture_output=True, text=True, check=False
    )
    assert done.returncode == 3
    assert done.stderr.startswith(f"rune: ssh to {server.target} failed: ")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("wrong", ["", "-oProxyCommand=x", "a b", "robot:port", "me@robot:1:2"])
def test_what_is_no_destination_is_refused(wrong: str) -> None:
    with pytest.raises(TunnelError, match="is no USER@HOST"):
        tunnel_to(wrong)


def test_a_hub_that_the_robot_has_elsewhere_is_refused() -> None:
    with pytest.raises(TunnelError, match="give --hub its name on the robot"):
        tunnel_to("robot", "tcp://192.0.2.1:1481")
