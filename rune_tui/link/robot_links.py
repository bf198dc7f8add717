"""The connections to all robots of a layout, and their change with another layout."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from rune_tui.controls.remote_pad.far_pads import FarPads
from rune_tui.errors import HubChoiceError
from rune_tui.layout.spec import LayoutSpec, RobotSpec
from rune_tui.link.hub_tunnel import Tunnel
from rune_tui.link.robot_link import RobotLink
from rune_tui.link.way import FleetWays, Way
from rune_tui.model.robot_state import RobotState


class RobotLinks(Mapping[str, RobotLink]):
    """A connection for each robot, by its name.

    Attributes:
        pads: Gamepads at other machines, through the robots' hubs.
    """

    def __init__(
        self,
        layout: LayoutSpec,
        hubs: Sequence[str] = (),
        *,
        keys: Path | None = None,
        operator: str = "",
        tunnels: Sequence[Tunnel] = (),
        fleets: FleetWays | None = None,
    ) -> None:
        """Prepare them.

        Args:
            layout: Which robots.
            hubs: Endpoints instead of those in the layout, in the order of its robots; none or
                one for each.
            keys: File of the operator's key, for hubs on other machines.
            operator: The operator's name, as robots get it.
            tunnels: Open tunnels to the hubs, instead of `hubs`.
            fleets: The ways to robots that name a fleet.

        Raises:
            HubChoiceError: There are not as many endpoints as robots.
            EndpointError: An endpoint is not one, or on another machine and there are no keys.
            KeyFileError: The keys cannot be used.
        """
        self._tunnels: dict[str, Way] = {tunnel.endpoint: tunnel for tunnel in tunnels}
        self._fleets = fleets
        self._hubs = tuple(self._tunnels or hubs)
        self._keys = keys
        self._operator = operator
        self.pads = FarPads(operator)
        self._wanted: dict[str, str] = {}
        wanted = self._endpoints(layout)
        self._links = self._made(layout, wanted, {})
        self._wanted = wanted

    @property
    def operator(self) -> str:
        """The operator's name, as robots get it."""
        return self._operator

    @property
    def states(self) -> dict[str, RobotState]:
        """The present state of each robot, by its name."""
        return {name: link.state for name, link in self._links.items()}

    def __getitem__(self, name: str) -> RobotLink:
        return self._links[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._links)

    def __len__(self) -> int:
        return len(self._links)

    def follow(self, layout: LayoutSpec) -> list[RobotLink]:
        """Switch to another layout; a robot in both keeps its connection.

        Returns:
            The unused links, to be closed.

        Raises:
            HubChoiceError, EndpointError, KeyFileError: As above; then nothing has changed.
        """
        before, wanted = self._links, self._endpoints(layout)
        self._links = self._made(layout, wanted, before)
        self._wanted = wanted
        kept = set(self._links.values()) & set(before.values())
        for name, link in self._links.items():
            if link in kept:
                link.follow(layout.robot(name), self._pads_for(layout))
            else:
                link.start()
        return [link for link in before.values() if link not in kept]

    def _made(
        self, layout: LayoutSpec, wanted: Mapping[str, str], known: Mapping[str, RobotLink]
    ) -> dict[str, RobotLink]:
        return {
            robot.name: known[robot.name]
            if self._wanted.get(robot.name) == wanted[robot.name]
            and known[robot.name].spec.keys == robot.keys
            else self._link(robot, wanted[robot.name], self._pads_for(layout))
            for robot in layout.robots
        }

    def _pads_for(self, layout: LayoutSpec) -> FarPads | None:
        return self.pads if layout.joysticks else None

    def _link(self, robot: RobotSpec, hub: str, pads: FarPads | None) -> RobotLink:
        way = self._tunnels.get(hub)
        keys = self._keys or (Path(robot.keys) if robot.keys else None)
        if robot.fleet and not self._hubs and self._fleets is not None:
            way, keys = self._fleets.way(robot), None
        return RobotLink(
            robot,
            hub,
            keys=keys,
            operator=self._operator,
            near=way is None,
            way=way,
            pads=pads,
        )

    def _endpoints(self, layout: LayoutSpec) -> dict[str, str]:
        """Where the hub of each robot is, by the robot's name."""
        count = len(layout.robots)
        if len(self._hubs) not in {0, count}:
            option = "--ssh" if self._tunnels else "--hub"
            there = f"{layout.path} names {count} robots, and {option} names {len(self._hubs)}"
            text = f"{there}; give {option} once for each robot, in the order of the layout"
            raise HubChoiceError(text)
        hubs = self._hubs or tuple(self._endpoint(robot) for robot in layout.robots)
        return dict(zip((robot.name for robot in layout.robots), hubs, strict=True))

    def _endpoint(self, robot: RobotSpec) -> str:
        if robot.fleet and self._fleets is not None:
            return self._fleets.way(robot).endpoint
        return robot.hub
