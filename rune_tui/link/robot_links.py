"""The connections to all robots of a layout, and what becomes of them with another layout."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from rune_tui.errors import HubChoiceError
from rune_tui.layout.spec import LayoutSpec, RobotSpec
from rune_tui.link.robot_link import RobotLink


class RobotLinks(Mapping[str, RobotLink]):
    """A connection for each robot, by its name."""

    def __init__(self, layout: LayoutSpec, hub: str = "", *, keys: Path | None = None) -> None:
        """Prepare them.

        Args:
            layout: Which robots.
            hub: Endpoint instead of the one in the layout.
            keys: File of the operator's key, for hubs on other machines.

        Raises:
            HubChoiceError: There is one endpoint for several robots.
            EndpointError: An endpoint is not one, or on another machine and there are no keys.
            KeyFileError: The keys cannot be used.
        """
        self._hub = hub
        self._keys = keys
        self._links = self._made(layout, {})

    def __getitem__(self, name: str) -> RobotLink:
        return self._links[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._links)

    def __len__(self) -> int:
        return len(self._links)

    def follow(self, layout: LayoutSpec) -> list[RobotLink]:
        """Take up what another layout wants; who is in both keeps the connection.

        Returns:
            The links that nobody wants any more, to be closed.

        Raises:
            HubChoiceError, EndpointError, KeyFileError: As above; then nothing has changed.
        """
        before = self._links
        self._links = self._made(layout, before)
        kept = set(self._links.values()) & set(before.values())
        for name, link in self._links.items():
            if link in kept:
                link.follow(layout.robot(name))
            else:
                link.start()
        return [link for link in before.values() if link not in kept]

    def _made(self, layout: LayoutSpec, known: Mapping[str, RobotLink]) -> dict[str, RobotLink]:
        if self._hub and len(layout.robots) > 1:
            text = f"{layout.path} names {len(layout.robots)} robots; one --hub cannot be for all"
            raise HubChoiceError(text)
        return {
            robot.name: known[robot.name]
            if robot.name in known and self._same_hub(known[robot.name].spec, robot)
            else RobotLink(robot, self._hub, keys=self._keys)
            for robot in layout.robots
        }

    def _same_hub(self, before: RobotSpec, now: RobotSpec) -> bool:
        return bool(self._hub) or before.hub == now.hub
