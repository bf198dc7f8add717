"""Tunnels by ssh to the hubs of robots, by the hub's name or by the place of its sockets there."""

from __future__ import annotations

import contextlib
import shlex
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from hub.errors import EndpointError
from hub.hub_sockets import NAMED, SOCKET, SOCKETS
from hub.ipc.endpoints import DEFAULT_ENDPOINT, IpcEndpoint, parse_endpoint
from hub.plain_text import plain
from rune_tui.errors import HubChoiceError, TunnelError
from rune_tui.layout.spec import LayoutSpec
from rune_tui.link import far_hub
from rune_tui.link.tunnel import MOST_WORDS, SshTunnel, ssh_command

_ENDS: Final = tuple(each.removeprefix(SOCKET) for each in SOCKETS)
_ANSWER_S: Final = 15.0
"""Longest wait for the answer of a command on the robot [s]."""


class Tunnel(SshTunnel):
    """A tunnel to a robot's hub, whose sockets on the robot are known.

    Attributes:
        endpoint: Where the hub is found on this machine.
    """

    def __init__(self, destination: str, far: Sequence[str]) -> None:
        """Prepare.

        Args:
            destination: Destination of ssh, [USER@]HOST[:PORT].
            far: The hub's sockets on the robot, in the order of `SOCKETS`.

        Raises:
            TunnelError: This is no destination, or there is no ssh.
        """

        def ends(folder: Path) -> dict[str, str]:
            near = (f"{folder}/{name}" for name in SOCKETS)
            return dict(zip(near, far, strict=True))

        super().__init__(destination, ends)
        self.endpoint = f"ipc://{self._folder}/{SOCKET}"


class NamedHubTunnel(Tunnel):
    """A tunnel to a robot's hub of a name.

    It looks for the hub at each connection, through a second use of the same connection: the
    operator types a password once.
    """

    def __init__(self, destination: str, hub: str) -> None:
        """Prepare.

        Args:
            destination: Destination of ssh, [USER@]HOST[:PORT].
            hub: `hub://NAME`, `hub://?NAME` or `hub://`.

        Raises:
            TunnelError: This is no destination, or there is no ssh.
        """
        super().__init__(destination, [""] * len(SOCKETS))
        self._hub = hub
        self._found = False

    def _command(self, *options: str) -> list[str]:
        self._shared.unlink(missing_ok=True)
        self._found = False
        return ssh_command(self.destination, "-N", "-M", *options, shared=self._shared)

    @property
    def _shared(self) -> Path:
        return self._folder / "ssh"

    def _prepare(self) -> None:
        """Once the connection is there, find the hub and forward its sockets."""
        if self._found or not self._shared.exists():
            return
        answer = self._ask(["sh", "-c", shlex.quote(far_hub.SCRIPT)])
        path = far_hub.chosen(far_hub.paths_in(answer), self._hub)
        self._ends = dict(zip(self._ends, (f"{path}{end}" for end in _ENDS), strict=True))
        self._found = True
        forwards = [f"-L{near}:{far}" for near, far in self._ends.items()]
        self._ask([], "-O", "forward", *forwards)

    def _ask(self, words: list[str], *options: str) -> str:
        """What a command says that goes through the connection.

        Raises:
            TunnelError: It fails.
        """
        command = ssh_command(self.destination, *options, shared=self._shared)
        try:
            done = subprocess.run(
                [*command, *words],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=_ANSWER_S,
                check=False,
            )
        except subprocess.TimeoutExpired as error:
            text = f"ssh to {self.destination} failed: it gives no answer within {_ANSWER_S:.0f} s"
            raise TunnelError(text) from error
        if done.returncode and options:
            said = plain(done.stderr.decode(errors="replace").strip())[-MOST_WORDS:]
            text = f"ssh to {self.destination} forwards no sockets: {said}"
            raise TunnelError(text)
        return done.stdout.decode(errors="replace")


def tunnel_to(destination: str, hub: str = DEFAULT_ENDPOINT) -> Tunnel:
    """A tunnel to one robot's hub.

    Args:
        destination: Destination of ssh, [USER@]HOST[:PORT].
        hub: Name of the hub on the robot (`hub://NAME`), or its ipc:// endpoint there.

    Raises:
        TunnelError: This is no destination, or no such hub, or there is no ssh.
    """
    if hub.startswith(NAMED):
        return NamedHubTunnel(destination, hub)
    return Tunnel(destination, _far_ends(hub))


@contextlib.contextmanager
def open_tunnels(
    destinations: Sequence[str], layout: LayoutSpec, hubs: Sequence[str] = ()
) -> Iterator[list[Tunnel]]:
    """Tunnels to the robots of a layout, open inside the `with`.

    Args:
        destinations: Destinations of ssh, in the order of the robots; empty: no tunnels.
        layout: Which robots.
        hubs: Endpoints on the robots, instead of those in the layout.

    Raises:
        HubChoiceError: There are not as many destinations, or hubs, as robots.
        TunnelError: One cannot be opened.
    """
    count = len(layout.robots)
    if destinations and {len(destinations), len(hubs) or count} != {count}:
        given = f"--ssh is given {len(destinations)} times, --hub {len(hubs)} times"
        text = f"{layout.path} names {count} robots, and {given}; give each once for each robot"
        raise HubChoiceError(text)
    known = hubs or [robot.hub for robot in layout.robots]
    with contextlib.ExitStack() as stack:
        tunnels = []
        for destination, hub in zip(destinations, known, strict=False):
            tunnels.append(stack.enter_context(contextlib.closing(tunnel_to(destination, hub))))
            tunnels[-1].open()
        yield tunnels


def _far_ends(hub: str) -> list[str]:
    """Where a hub's sockets are on the robot: files.

    Raises:
        TunnelError: It is no endpoint of such sockets.
    """
    try:
        endpoint = parse_endpoint(hub)
    except EndpointError:
        endpoint = None
    if not isinstance(endpoint, IpcEndpoint):
        text = (
            f"{hub!r} leads to no hub through ssh; give --hub its name on the robot, or the "
            "ipc:// address of its socket there"
        )
        raise TunnelError(text)
    return [f"{endpoint.path}{end}" for end in _ENDS]
