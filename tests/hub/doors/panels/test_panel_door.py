"""A door between a hub and panels: what panels see of the hub itself."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing

from hub.doors.panels.hub_topics import PictureWishes
from hub.doors.panels.panel_door import PanelDoor
from hub.doors.panels.wishes import Wishes
from hub.ipc.broker.central import Central
from hub.ipc.client import Client
from hub.recording.topics import RecordedTopic
from tests.support.ports import free_port
from tests.support.waiting import until


class SilentPanels:
    """A server without programs, which keeps what it should show."""

    def __init__(self, _changed: Callable[[], None]) -> None:
        self.said: list[str] = []

    def open(self, _topic: RecordedTopic) -> int:
        return 1

    def take_wishes(self) -> Wishes:
        return Wishes(watched=frozenset(), fresh=frozenset(), commands=(), panels=frozenset())

    def say(self, text: str) -> None:
        self.said.append(text)

    def close(self) -> None:
        pass


def test_a_hub_that_ends_is_said_once_and_the_sentence_goes_when_it_is_back() -> None:
    opened: list[SilentPanels] = []

    def open_panels(changed: Callable[[], None]) -> SilentPanels:
        opened.append(SilentPanels(changed))
        return opened[0]

    hub = f"tcp://127.0.0.1:{free_port()}"
    pictures = PictureWishes(rate=10.0, width_px=640, height_px=480)
    with closing(Client("door", hub)) as client:
        with closing(Central([hub])):
            client.wait_connected(5.0)
            door = PanelDoor(client, open_panels, pictures)
            door.listen(0.05)
            assert opened[0].said == []
        until(lambda: opened[0].said, 20.0, meanwhile=lambda: door.listen(0.05))
        assert opened[0].said == [f"the hub at {hub} answers no more: what is shown is old"]
        with closing(Central([hub])):
            until(lambda: len(opened[0].said) > 1, 20.0, meanwhile=lambda: door.listen(0.05))
            assert opened[0].said[1:] == [""]
        door.close()
