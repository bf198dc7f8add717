"""The connection to one robot's hub: a thread of its own, newest values in, messages out.

It calls no other thread: the console reads `state` at any time, and hands in messages.
"""

from __future__ import annotations

import dataclasses
import logging
import os
import threading
import time
import traceback
from collections.abc import Callable, Set
from pathlib import Path
from typing import Any, TypeVar

from hub.errors import HubError
from hub.gcm import mapping, vision
from hub.gcm.body import ROBOT_DESCRIPTION
from hub.gcm.capability import Capability
from hub.gcm.catalog import BY_NAME
from hub.gcm.control import CONTROL_STATE, ControlAction, ControlState
from hub.gcm.diagnostics import DIAGNOSTICS
from hub.gcm.mission import MISSION_STATE, MissionAction
from hub.gcm.navigation import VELOCITY_COMMAND
from hub.gcm.occupancy_map import OccupancyMap
from hub.gcm.providers import PROVIDED_BY
from hub.gcm.recording import RECORD_STATE
from hub.gcm.supervision import (
    CAPABILITY_REPORTS,
    CapabilityReports,
)
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.security.publish_rights import may_publish
from rune_tui.controls.remote_pad.far_pads import FarPads
from rune_tui.layout.spec import RobotSpec
from rune_tui.link.camera_streams import CameraStreams, Needs
from rune_tui.link.control_line import ControlLine
from rune_tui.link.map_stream import MapStream
from rune_tui.link.mission_line import MissionLine
from rune_tui.link.module_line import begin_as_module
from rune_tui.link.pad_line import PadLine
from rune_tui.link.pictures import picture_of
from rune_tui.link.record_line import RecordLine
from rune_tui.link.streams import Streams
from rune_tui.link.traffic import Traffic
from rune_tui.link.wants_line import WantsLine
from rune_tui.link.way import Way
from rune_tui.model.console_state import PictureWish
from rune_tui.model.robot_state import (
    LinkPhase,
    LinkState,
    Received,
    RobotState,
)
from rune_tui.model.vehicle import with_message

_logger = logging.getLogger(__name__)

T = TypeVar("T")
Tap = Callable[[MessageDefinition[Any], object, float, int], None]
"""Gets a message, its value, when it was measured [s], and its received number; 0: it was sent."""

_LISTEN_S = 0.2
_REQUEST_CHECK_S = 0.01
_COUNT_S = 1.0
_MOST_LETTERS = 1000
_ALWAYS = frozenset(
    definition.name
    for definition in (
        ROBOT_DESCRIPTION,
        CAPABILITY_REPORTS,
        CONTROL_STATE,
        MISSION_STATE,
        DIAGNOSTICS,
        RECORD_STATE,
    )
)
"""Messages that are subscribed to with every layout."""
_ANSWERS = frozenset({vision.IMAGE.name, mapping.MAP.name})
"""Messages that come only on request."""


class RobotLink:
    """A thread that keeps a `RobotState` up to date, and reconnects by itself."""

    def __init__(
        self,
        spec: RobotSpec,
        hub: str = "",
        *,
        keys: Path | None = None,
        operator: str = "",
        near: bool = True,
        way: Way | None = None,
        pads: FarPads | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare the connection.

        Args:
            spec: The robot.
            hub: Endpoint instead of the one in the layout.
            keys: File of the operator's key, for a hub on another machine.
            operator: Operator of this console.
            near: Whether messages may pass the endpoint by, from modules of this machine.
            way: The way to the hub, if it is no plain address; then `hub` is its end.
            pads: Gets the states of gamepads at other machines.
            clock: Monotonic time [s].

        Raises:
            EndpointError: The endpoint is not one, or on another machine and there are no keys.
            KeyFileError: The keys cannot be used.
        """
        self._clock = clock
        self._spec = spec
        self._numbers = self._owner = 0
        self._traffic, self._counted = Traffic(clock()), clock()
        self._tap: Tap = _no_tap
        self._faults: set[tuple[type, object]] = set()
        self._control: ControlLine | None = None
        self._mission: MissionLine | None = None
        self.recorder: RecordLine | None = None  # a key that only watches has none
        self._way = way
        self._stopping = threading.Event()
        own_keys = read_client_keys(keys) if keys else None
        name = f"rune-{os.getpid()}-{spec.name}"
        endpoint = hub or spec.hub
        self._client = Client(name, endpoint, clock=clock, keys=own_keys, near=near)
        link = LinkState(
            phase=LinkPhase.CONNECTING,
            since=clock(),
            endpoint=way.shown if way else self._client.endpoint,
            may_command=(way is None or way.may_command)
            and (own_keys is None or may_publish(own_keys.role, VELOCITY_COMMAND.name)),
        )
        self._state = RobotState(name=spec.name, link=link)
        self._pictures = CameraStreams(
            self._client, self._take_picture, self._keep_pictures, self._no_picture, clock
        )
        self._maps = MapStream(self._client, self._take_map, clock)
        self._streams = Streams(self._client, self._store, clock)
        self._pads = PadLine(self._client, spec.name, publishes=link.may_command)
        self._pads.follow(pads)
        self._wants = WantsLine(self._client, clock)
        self._adopt(spec)
        if link.may_command:
            self._wants.begin()
            self._control = ControlLine(self._client, operator, lambda: self._state, self._say)
            self._mission = MissionLine(self._client, operator, self._say)
            self.recorder = RecordLine(self._client, operator, self._wants, self._say)
        begin_as_module(self._client, own_keys, self._say)
        self._client.every(_REQUEST_CHECK_S, self._pictures.step)
        self._client.every(_REQUEST_CHECK_S, self._maps.step)
        self._client.every(_REQUEST_CHECK_S, self._streams.step)
        self._client.every(_COUNT_S, self._count)
        self._thread = threading.Thread(target=self._run, name=f"link-{spec.name}", daemon=True)

    @property
    def state(self) -> RobotState:
        """The present state of the robot; any thread may read it."""
        return self._state

    @property
    def spec(self) -> RobotSpec:
        """The layout's values for the robot."""
        return self._spec

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self) -> None:
        """End the thread, after all sent messages have left."""
        self._stopping.set()
        self._client.post(lambda: None)
        self._thread.join()

    def follow(self, spec: RobotSpec, pads: FarPads | None = None) -> None:
        """Switch to another layout with the same robot, without a break in the connection."""
        self._client.post(lambda: self._adopt(spec))
        self._client.post(lambda: self._pads.follow(pads))

    def send(self, definition: MessageDefinition[T], value: T) -> None:
        """Publish a command to the robot, if the operator's key allows that.

        It is lost while there is no connection, so that nothing old arrives.
        """
        if self._state.link.may_send(definition.name):
            measured = self._clock()
            self._tap(definition, value, measured, 0)
            self._client.post(lambda: self._client.publish(definition, value, measured=measured))

    def control(self, action: ControlAction, *, by_driving: bool = False) -> None:
        """Take control of the robot, ask for it, hand it over or give it up.

        It is lost while there is no connection, as commands are.
        """
        if self._control is not None and self._state.link.phase is LinkPhase.CONNECTED:
            self._control.want(action, by_driving=by_driving)

    def mission(self, action: MissionAction, name: str) -> None:
        """Begin, name or end the robot's mission; lost while there is no connection."""
        if self._mission is not None and self._state.link.phase is LinkPhase.CONNECTED:
            self._mission.want(action, name)

    def attend(self) -> None:
        """Note a turn of the console: an owner keeps control for a second more."""
        if self._control is not None:
            self._control.attended = self._clock()

    def tap(self, tap: Tap | None) -> None:
        """Copy all messages, received and sent, to a tap; None: to none."""
        self._tap = tap or _no_tap

    def want_pictures(self, needs: Needs, wish: PictureWish | None = None) -> None:
        """Ask for the pictures that these cameras need, of the operator's kind."""
        self._pictures.want(needs, wish)

    def shown(self, number: int, camera: str = "") -> None:
        """The picture of this number, of this camera, is on the screen; see `Requester.handled`."""
        self._pictures.shown(number, camera)

    def _keep_pictures(self, cameras: Set[str]) -> None:
        self._state = self._state.with_pictures_of(cameras)

    def _adopt(self, spec: RobotSpec) -> None:
        """Set a layout's wants."""
        self._spec = spec
        wanted = {capability.name: capability for capability in spec.capabilities}
        self._wants.follow(spec)
        video = wanted.get(Capability.VIS_VID)
        self._pictures.follow(video.interval_s if video else None)
        self._maps.follow(spec)
        self._least_s = {
            message: wanted[capability].interval_s
            for message, capabilities in PROVIDED_BY.items()
            for capability in capabilities[:1]
            if capability in wanted
        }
        messages = (spec.messages | _ALWAYS) - _ANSWERS
        kept = {n: r for n, r in self._state.messages.items() if n in messages}
        self._state = self._state.with_(messages=kept)
        self._streams.follow(messages)
        # Defined before use, so that a stop leaves without delay.
        commands = filter(self._state.link.may_send, sorted(spec.commands))
        self._client.define(*(BY_NAME[name] for name in commands))

    def _store(self, name: str, value: object, reception: MessageInfo) -> None:
        self._traffic.add()
        if self._too_soon(name, reception.measured):
            return
        received = self.received(value, reception)
        self._tap(BY_NAME[name], value, received.measured, received.number)
        self._note_number()
        self._state = with_message(self._state, name, received, reception.publisher)
        if isinstance(value, CapabilityReports):
            self._note_lacking(value)
        elif isinstance(value, ControlState):
            self._note_owner(value)

    def _too_soon(self, name: str, measured: float) -> bool:
        """Whether it was measured too soon for the layout's rate; the same moment again is news."""
        newest = self._state.messages.get(name)
        return newest is not None and 0.0 < measured - newest.measured < self._least_s.get(name, 0)

    def received(self, value: T, reception: MessageInfo) -> Received[T]:
        """A message with its own number and its time of measurement."""
        self._numbers += 1
        return Received(value=value, measured=reception.measured, number=self._numbers)

    def _run(self) -> None:
        while not self._stopping.is_set():
            for work in (self._listen, self._note_phase):
                try:
                    work()
                except Exception as error:  # noqa: BLE001 - one bad message must not end the link
                    self._note_fault(error)
        try:
            self._client.listen(0.0)
        except HubError as error:
            _logger.warning("the last messages to %s were not sent: %s", self._state.name, error)
        self._client.close()

    def _listen(self) -> None:
        self._client.listen(_LISTEN_S)

    def _note_fault(self, error: Exception) -> None:
        """Log a fault and show it to the operator, once: it may occur with every message."""
        frames = list(traceback.walk_tb(error.__traceback__))
        where = (type(error), frames[-1][0].f_code if frames else None)
        if where not in self._faults:
            self._faults.add(where)
            _logger.error("the link to %s goes on after a fault", self._state.name, exc_info=error)
            self._say("a message could not be taken; the log says why")

    def _note_phase(self) -> None:
        link = self._state.link
        if self._client.connected:
            # The error of a request stays until one succeeds; that of a lost link ends here.
            known = link.detail if link.phase is LinkPhase.CONNECTED else ""
            phase, detail = LinkPhase.CONNECTED, known
            if link.phase is not LinkPhase.CONNECTED and link.may_command:
                self._wants.connected()
        elif link.phase is LinkPhase.CONNECTING:
            phase, detail = LinkPhase.CONNECTING, self._why_not()
        else:
            closed = f"closed by {self._client.closed_by}" if self._client.closed_by else ""
            phase, detail = LinkPhase.LOST, closed or self._why_not()
        if phase is not LinkPhase.CONNECTED and CONTROL_STATE.name in self._state.messages:
            # Control is unknown until the hub reports it: it may be another hub.
            kept = {n: r for n, r in self._state.messages.items() if n != CONTROL_STATE.name}
            self._state = self._state.with_(messages=kept)
        self._note_number()
        self._set_link(phase, detail)
        while self._way is not None and (notice := self._way.next_notice()):
            self._say(notice)

    def _note_number(self) -> None:
        if self._client.number != self._state.link.number:
            self._change_link(number=self._client.number)

    def _note_owner(self, control: ControlState) -> None:
        """Note since when there is another owner, by the clock on the wall here."""
        if control.owner != self._owner:
            self._owner = control.owner
            since = time.localtime(time.time() - control.held_s)
            self._change_link(owned_since=time.strftime("%H:%M", since) if self._owner else "")

    def _say(self, text: str) -> None:
        """Report a refusal to the operator."""
        link = self._state.link
        self._change_link(refusal=text[:_MOST_LETTERS], refusal_count=link.refusal_count + 1)

    def _why_not(self) -> str:
        """The reason for the missing connection, if known."""
        return (self._way.trouble if self._way else "") or str(self._client.refusal or "")

    def _set_link(self, phase: LinkPhase, detail: str) -> None:
        link, detail = self._state.link, detail[:_MOST_LETTERS]
        if (phase, detail) != (link.phase, link.detail):
            since = link.since if phase is link.phase else self._clock()
            self._change_link(phase=phase, since=since, detail=detail)

    def _change_link(self, **changes: Any) -> None:  # noqa: ANN401 - the fields have several types
        link = dataclasses.replace(self._state.link, **changes)
        self._state = self._state.with_(link=link)

    def _note_lacking(self, reports: CapabilityReports) -> None:
        lacking = self._wants.lacking(reports)
        if lacking != self._state.link.lacking:
            self._change_link(lacking=lacking)

    def _count(self) -> None:
        """Note the traffic since the last call."""
        now = self._clock()
        if now > self._counted:
            self._change_link(
                **self._traffic.rates(now),
                round_trip=self._pictures.round_trip,
                missed=self._client.lost,
                unfit=self._client.unfit,
                pictures=self._pictures.flow(now - self._counted),
            )
        self._counted = now

    def _take_picture(self, camera: str, image: vision.Image, reception: MessageInfo) -> int:
        self._traffic.add(image.data.size)
        received = self.received(picture_of(image, self._pictures.interval(camera)), reception)
        self._tap(vision.IMAGE, image, received.measured, received.number)
        self._state = self._state.with_picture(camera, received)
        return received.number

    def _no_picture(self, why: str) -> None:
        detail = "the robot sends no pictures" if why == "nobody answers" else why
        self._set_link(self._state.link.phase, detail)

    def _take_map(self, coded: mapping.Map, reception: MessageInfo) -> int:
        self._traffic.add(coded.data.size)
        received = self.received(OccupancyMap.of(coded), reception)
        self._tap(mapping.MAP, coded, received.measured, received.number)
        self._state = self._state.with_(map=received)
        return 0


def _no_tap(*_: object) -> None:
    """Take a message that is not copied."""
