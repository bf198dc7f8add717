"""An operator by script: a console with the layout land-sea-air, and the hubs of three robots."""

from __future__ import annotations

import asyncio
import contextlib
import math
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any, Final

import numpy as np
from textual import events

from hub.gcm.body import BodyFrame
from hub.gcm.mapping import INTEREST_POINTS, POINT_COMMAND, InterestPoint, InterestPoints
from hub.gcm.navigation import GROUND_TRUTH, STOP, VELOCITY_COMMAND, GroundTruth
from hub.gcm.vision import CAMERA_COMMAND
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo
from hub.sim.arena import SHIPPED
from hub.sim.camera.mount import mounted_view
from hub.sim.spatial_pose import SpatialPose
from hub.values import dataclass
from rune_tui.app import Console
from rune_tui.layout.watching import LayoutSource
from rune_tui.link.robot_links import RobotLinks
from rune_tui.model.robot_state import Picture
from rune_tui.startup.opening import open_layout
from rune_tui.terminal.input_stream import KeyMove
from rune_tui.terminal.questions import Answers
from rune_tui.terminal.traits import traits_of
from rune_tui.ui.driver_reports import KeyMoved, ReleasesReported
from rune_tui.visualizers.video.picture_frame import FIT, PictureFrame
from tests.support.waiting import Limit
from tests.system.harness import HubProcess

COMMANDS: Final = (VELOCITY_COMMAND, CAMERA_COMMAND, POINT_COMMAND, STOP)
_SIZE: Final = (200, 60)
"""Size of the terminal [cells]."""
_TIMEOUT_S: Final = 20.0
_HELD_S = 3.0
"""A key that does nothing is held for this time [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A robot of the team.

    Attributes:
        role: Its role in the layout.
        key: The key that chooses it.
        kind: Its kind.
        mount: Where its camera sits.
        degrees: Widest field of view of its camera.
        victim: The place of the victim before it in the arena [m].
    """

    role: str
    key: str
    kind: str
    mount: BodyFrame
    degrees: int
    victim: tuple[float, float]


TEAM: Final = (
    Member(
        role="rover",
        key="1",
        kind="simulated-magellan",
        mount=BodyFrame(name="camera", x=0.05, z=0.37),
        degrees=49,
        victim=(1.4, 7.6),
    ),
    Member(
        role="blimp",
        key="2",
        kind="simulated-blimp",
        mount=BodyFrame(name="camera", x=0.15),
        degrees=60,
        victim=(5.9, 8.0),
    ),
    Member(
        role="submarine",
        key="3",
        kind="simulated-rov",
        mount=BodyFrame(name="camera", x=0.2),
        degrees=80,
        victim=(10.2, 7.4),
    ),
)
_STARTS: Final = {
    "at = [1.2, 1.2]\nheading_deg = 45": "at = [2.4, 5.9]\nheading_deg = 120",
    "at = [3.5, 3.0]\nheight = 1.6\nheading_deg = 60": (
        "at = [6.1, 4.8]\nheight = 1.0\nheading_deg = 95"
    ),
    "at = [8.2, 2.0]\nheight = 0.8\nheading_deg = 60": (
        "at = [9.0, 5.6]\nheight = 0.8\nheading_deg = 55"
    ),
}
"""Each robot starts in sight of a victim of the hall."""


def arena_file(folder: Path) -> Path:
    """The arena `hall` with these starts."""
    text = (SHIPPED / "hall.toml").read_text()
    for usual, start in _STARTS.items():
        assert usual in text
        text = text.replace(usual, start)
    path = folder / "hall.toml"
    path.write_text(text)
    return path


class Witness:
    """Notes what one hub receives, and where its robot is, in a thread of its own."""

    def __init__(self, hub: HubProcess) -> None:
        self.client = Client("witness", hub.endpoint)
        self.commands: list[tuple[str, Any]] = []
        self.truth: GroundTruth | None = None
        self.marks: tuple[InterestPoint, ...] = ()
        self.client.wait_connected(10.0)
        for definition in COMMANDS:
            self.client.subscribe(definition, self._noter(definition.name))
        self.client.subscribe(GROUND_TRUTH, self._place)
        self.client.subscribe(INTEREST_POINTS, self._mark, last=True)
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._listen, name="witness")
        self._thread.start()

    def _listen(self) -> None:
        while not self._ends.is_set():
            self.client.listen(0.05)

    def close(self) -> None:
        """End the thread."""
        self._ends.set()
        self._thread.join()
        self.client.close()

    def _noter(self, name: str) -> Callable[[Any, MessageInfo], None]:
        def note(value: Any, _: MessageInfo) -> None:
            if name != VELOCITY_COMMAND.name or not value.twist.neutral:
                self.commands.append((name, value))

        return note

    def _place(self, truth: GroundTruth, _: MessageInfo) -> None:
        self.truth = truth

    def _mark(self, points: InterestPoints, _: MessageInfo) -> None:
        self.marks = points.points

    def received(self) -> set[str]:
        """Names of the commands since the last call; neutral velocities do not count."""
        known, self.commands = self.commands, []
        return {name for name, _ in known}


class Operator:
    """Hands and eyes at the console."""

    def __init__(self, console: Console, witnesses: Mapping[str, Witness]) -> None:
        self.console, self.witnesses = console, witnesses
        self.seen: dict[str, set[int]] = defaultdict(set)
        """Fields of view of all pictures that the console had of each robot [degrees]."""

    async def until(self, condition: Callable[[], object], why: str = "") -> None:
        limit = Limit(_TIMEOUT_S)
        while not condition():
            assert not limit.over, f"{why}: {self.notices}"
            await self.look()

    async def look(self) -> None:
        """Let the console work for a moment."""
        await asyncio.sleep(0.03)
        for name, robot in self.console.state.robots.items():
            for picture in robot.all_pictures.values():
                fov = math.degrees(picture.value.camera.horizontal_fov)
                self.seen[name].add(round(fov))

    @property
    def notices(self) -> list[str]:
        return [notice.text for notice in self.console.state.notices]

    async def press(self, key: str) -> None:
        """Press a key and let go of it."""
        self.move(key, KeyMove.PRESS)
        await self.look()
        self.move(key, KeyMove.RELEASE)

    async def hold_until(self, key: str, condition: Callable[[], object]) -> None:
        """Hold a key; press it again where that does nothing, as a person does."""
        limit = Limit(_TIMEOUT_S)
        while not condition():
            assert not limit.over, f"{key} does nothing: {self.notices}"
            let_go = time.monotonic() + _HELD_S
            self.move(key, KeyMove.PRESS)
            while not condition() and time.monotonic() < let_go:
                await self.look()
            self.move(key, KeyMove.RELEASE)
            await self.until(lambda: not self.console.state.held)

    def move(self, key: str, move: KeyMove) -> None:
        """Move a key, as a terminal reports it.

        Textual's pilot waits until the console rests, which it never does with pictures.
        """
        self.console.post_message(KeyMoved(key, key, move))

    def picture(self, robot: str) -> Picture | None:
        """The newest picture of a robot."""
        received = self.console.state.robots[robot].picture
        return received.value if received is not None else None

    def picture_width(self, robot: str) -> int:
        """Width of the newest picture of a robot [pixels]; 0: there is none."""
        picture = self.picture(robot)
        return picture.pixels.shape[1] if picture is not None else 0

    def truth_known(self, robot: str) -> bool:
        """Whether its place has arrived."""
        return self.witnesses[robot].truth is not None

    def truth(self, robot: str) -> GroundTruth:
        """Where a robot is in the arena."""
        truth = self.witnesses[robot].truth
        assert truth is not None
        return truth

    def shares(self, member: Member) -> tuple[float, float]:
        """Where the foot of a victim is in the picture, as shares of its width and height.

        By the simulator's truth, not by what the console knows.
        """
        truth, picture = self.truth(member.role), self.picture(member.role)
        assert picture is not None
        pose = SpatialPose(
            x=truth.x, y=truth.y, z=truth.z, roll=truth.roll, pitch=truth.pitch, yaw=truth.theta
        )
        view = mounted_view(
            pose,
            member.mount,
            pan=picture.camera.pan,
            tilt=picture.camera.tilt,
            horizontal_fov=picture.camera.horizontal_fov,
        )
        right, up, ahead = view.basis() @ (np.array((*member.victim, 0.0)) - view.eye)
        wide = math.tan(view.horizontal_fov / 2.0)
        high = wide * picture.pixels.shape[0] / picture.pixels.shape[1]
        return 0.5 + right / ahead / wide / 2.0, 0.5 - up / ahead / high / 2.0

    def in_picture(self, member: Member) -> bool:
        """Whether that foot is well inside the picture."""
        return all(0.05 < share < 0.95 for share in self.shares(member))

    def click_on_victim(self, member: Member) -> None:
        """Click on the foot of the victim in the large picture."""
        pane = next(each for each in self.console.current.view.panes if each.spec.name == "camera")
        picture = self.picture(member.role)
        assert picture is not None
        height, width = picture.pixels.shape[:2]
        size = pane.place.width, pane.place.height
        tall = self.console.state.pixel_height
        frame = PictureFrame.of(FIT, width, height, size, tall=tall)
        across, down = self.shares(member)
        x = pane.place.x + frame.left + across * frame.width
        y = pane.place.y + frame.top + down * frame.height
        place = int(x), int(y) // 2
        click = events.MouseDown(
            None,
            *place,
            0,
            0,
            1,
            shift=False,
            meta=False,
            ctrl=False,
            screen_x=place[0],
            screen_y=place[1],
        )
        for pressed in (True, False):
            self.console.mouse(click, "left", pressed=pressed)

    def place_in_arena(self, robot: str, point: InterestPoint) -> tuple[float, float]:
        """A place of a robot's map in the arena, by what the robot believes and what is true."""
        truth, known = self.truth(robot), self.console.state.robots[robot].navigation
        assert known is not None
        turn = truth.theta - known.value.theta
        x, y = point.x - known.value.x, point.y - known.value.y
        cos, sin = math.cos(turn), math.sin(turn)
        return truth.x + x * cos - y * sin, truth.y + x * sin + y * cos


@contextlib.contextmanager
def team_hubs(folder: Path) -> Iterator[list[HubProcess]]:
    """The hubs of the three robots in one hall."""
    arena = arena_file(folder)

    def start(member: Member) -> HubProcess:
        own = folder / member.role
        own.mkdir()
        modules = ("driver", "navigation", "vision", "mapping")
        return HubProcess(own, kind=member.kind, arena=str(arena), modules=modules)

    with ExitStack() as stack:
        with ThreadPoolExecutor(len(TEAM)) as pool:
            hubs = [*pool.map(start, TEAM)]
        for hub in hubs:
            stack.enter_context(closing(hub))
        yield hubs


def run_team(folder: Path, script: Callable[[Operator], Any]) -> None:
    """Start three robots in one hall, and a console; run a script at it."""
    with ExitStack() as stack:
        hubs = stack.enter_context(team_hubs(folder))
        witnesses = {member.role: Witness(hub) for member, hub in zip(TEAM, hubs, strict=True)}
        for witness in witnesses.values():
            stack.enter_context(closing(witness))
        stack.callback(sys.setswitchinterval, sys.getswitchinterval())  # a console shortens it
        asyncio.run(_run(hubs, witnesses, script))


async def _run(
    hubs: Sequence[HubProcess],
    witnesses: Mapping[str, Witness],
    script: Callable[[Operator], Any],
) -> None:
    layout = open_layout("land-sea-air")
    source = LayoutSource([layout.path], open_layout, layout, watched=False)
    links = RobotLinks(layout, [hub.endpoint for hub in hubs], operator="jane")
    console = Console(source, links, traits_of(Answers(truecolour=True), {}, _SIZE))
    with ExitStack() as stack:
        stack.callback(console.inputs.joysticks.close)
        for link in links.values():
            link.start()
            stack.enter_context(closing(link))
        async with console.run_test(size=_SIZE):
            operator = Operator(console, witnesses)
            robots = operator.console.state.robots
            await operator.until(
                lambda: all(
                    operator.truth_known(name) and operator.picture(name) is not None
                    for name in robots
                ),
                "the robots do not come",
            )
            console.post_message(ReleasesReported(reported=True))
            await operator.until(lambda: console.state.releases_reported)
            await script(operator)
