"""Drives the robot for panels, as a console does: with control, heartbeats, and neutral first.

| event | what is sent |
| --- | --- |
| a velocity, no console has control | a request for control; nothing moves until it is given |
| control is given | neutral, and velocities `NEUTRAL_S` later |
| a velocity of the panel that drives | this velocity |
| a velocity of another panel meanwhile | nothing |
| that panel is silent for `SILENCE_S`, or gone | neutral, then at the rate of a standing robot |
| no panel drives for `IDLE_S` | control is given up |
| a stop of any client while a panel drives | nothing, until the panel was silent |
| another console asks for control | nothing while a panel drives; else control is handed over |

Panels send no zero when a key is released, so silence means released.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from typing import Final

from hub.control_gate import follow_control
from hub.doors.panels.panel_twist import twist_of
from hub.doors.panels.wishes import Panel, PanelCommand, SenderKind
from hub.errors import CodecError, QueryError, RosMessageError
from hub.gcm.common import COMMON_RESULT, CommonResult
from hub.gcm.control import (
    CONSOLE_HEARTBEAT,
    CONTROL_REQUEST,
    HEARTBEAT_HZ,
    ConsoleHeartbeat,
    ControlAction,
    ControlRequest,
    ControlState,
)
from hub.gcm.geometry import Twist, TwistStamped
from hub.gcm.navigation import STOP, VELOCITY_COMMAND, Stop
from hub.ipc.client import Client
from hub.ipc.message_info import MessageInfo

SILENCE_S: Final = 0.25
"""Silence of a panel after which it counts as released [s]; navigation stops by itself at 0.3 s."""
NEUTRAL_S: Final = 0.1
"""Time between the first neutral command and the first velocity [s]."""
IDLE_S: Final = 10.0
"""Time without a velocity after which control is given up [s]."""
_MOST_LONE = 3
"""After this number of single velocities with silence around them, a panel is too slow."""
_NEUTRAL_EVERY_S = 0.2
_ANSWER_S = 2.0
_ASK_EVERY_S = 0.5
_SAY_EVERY_S = 0.2
"""Least times between two requests, and two sentences: a flood of one panel must not flood the hub
or the other panels [s]."""
_UNREADABLE_S = 60.0
"""Least time between two sentences about commands that cannot be read [s]."""


class PanelDrive:
    """Follows one panel at a time.

    Attributes:
        refused: Number of commands that were not followed, by reason.
    """

    def __init__(self, client: Client, sender: SenderKind, say: Callable[[str], None]) -> None:
        """Begin.

        Args:
            client: A client for this alone: control belongs to it.
            sender: What the panels are, for people.
            say: Shows a sentence to the people at the panels; empty: takes it away.
        """
        self.refused: Counter[str] = Counter()
        self._sender = sender
        self._client, self._say, self._clock = client, say, client.loop.clock
        self._state = ControlState()
        self._was_mine = False
        self._panel: Panel | None = None
        self._last = -math.inf
        self._ready = math.inf
        self._asked = False
        self._count = self._lone = 0
        self._asked_at = self._unreadable_due = -math.inf
        self._text = self._shown = self._fault = ""
        client.define(VELOCITY_COMMAND, CONSOLE_HEARTBEAT, CONTROL_REQUEST, COMMON_RESULT)
        follow_control(client, self._controlled)
        client.subscribe(STOP, self._stopped)
        client.every(1.0 / HEARTBEAT_HZ, self._send_heartbeat)
        client.every(_NEUTRAL_EVERY_S, self._rest)
        client.every(_SAY_EVERY_S, self._say_newest)
        self._silence = client.alarm(self._fell_silent)

    @property
    def mine(self) -> bool:
        """Whether the panels have control of the robot."""
        return self._client.connected and self._state.owner == self._client.number != 0

    def obey(self, command: PanelCommand) -> None:
        """Follow a panel's command, if it may drive now."""
        now = self._clock()
        if now - command.came >= SILENCE_S:
            self.refused["late"] += 1
            return
        try:
            twist = twist_of(command.encoding, command.schema_name, command.data)
        except (CodecError, RosMessageError) as error:
            self._unreadable(error, now)
            return
        if self._panel not in (None, command.panel):
            self.refused["another panel drives"] += not twist.neutral
            return
        if twist.neutral:
            if self._panel is not None:
                self._released()
            return
        self._drive(command.panel, twist, now)

    def follow(self, panels: frozenset[Panel]) -> None:
        """Stop at once if the panel that drives is gone."""
        if self._panel is not None and self._panel not in panels:
            self._released()

    def close(self) -> None:
        """Stop, and give up control."""
        if self.mine:
            self._send(Twist())
            self._request(ControlAction.RELEASE)

    def _unreadable(self, error: CodecError | RosMessageError, now: float) -> None:
        """Count it; say the first, and then one a minute, as panels may send many that differ."""
        self.refused["unreadable"] += 1
        if now >= self._unreadable_due:
            self._unreadable_due = now + _UNREADABLE_S
            number = self.refused["unreadable"]
            self._fault = (
                f"a command of a {self._sender.noun} cannot be read ({number} so far): {error}"
            )
        self._show(self._fault)

    def _drive(self, panel: Panel, twist: Twist, now: float) -> None:
        if self._panel is None:
            self._begin(panel)
        self._count += 1
        self._last, self._silence.due = now, now + SILENCE_S
        if self.mine and now >= self._ready:
            self._send(twist)
        else:
            self.refused["without control"] += not self.mine

    def _begin(self, panel: Panel) -> None:
        """Start with a panel that was silent, or whose command is the first."""
        self._panel, self._count = panel, 0
        too_slow = f"the {self._sender.noun} sends too slowly to drive: {self._sender.rate}"
        self._show(too_slow if self._lone >= _MOST_LONE else "")
        now = self._clock()
        if not self.mine and not self._asked and now - self._asked_at >= _ASK_EVERY_S:
            self._asked, self._asked_at = True, now
            self._request(ControlAction.TAKE)

    def _fell_silent(self) -> None:
        """The panel that drives has sent neither a velocity nor a zero."""
        self._lone = self._lone + 1 if self._count == 1 else 0
        self._released()

    def _released(self) -> None:
        """No panel drives any more."""
        self._panel, self._asked = None, False
        self._silence.due = math.inf
        if self.mine:
            self._send(Twist())
            self._ready = self._clock() + NEUTRAL_S
            self._hand_over()

    def _controlled(self, state: ControlState) -> None:
        self._state = state
        if self.mine and not self._was_mine:
            self._send(Twist())
            self._ready = self._clock() + NEUTRAL_S
        elif self._was_mine and not self.mine and self._panel is not None:
            self._show(f"the {self._sender.noun} drives no more: {state.why}")
        self._was_mine = self.mine
        if self.mine and self._panel is None:
            self._hand_over()

    def _stopped(self, stop: Stop, _info: MessageInfo) -> None:
        """Wait until the panel is released."""
        if self._panel is not None:
            self._ready = math.inf
            noun, release = self._sender.noun, self._sender.release
            self._show(f"the robot was stopped ({stop.reason}): to drive by this {noun}, {release}")

    def _show(self, text: str) -> None:
        self._text = text

    def _say_newest(self) -> None:
        if self._text != self._shown:
            self._shown = self._text
            self._say(self._text)

    def _hand_over(self) -> None:
        if self._state.asker:
            self._request(ControlAction.GRANT)

    def _rest(self) -> None:
        """Send neutral while no panel drives; after a while, give up control."""
        if not self.mine or self._panel is not None:
            return
        self._send(Twist())
        if self._clock() - self._last >= IDLE_S:
            self._request(ControlAction.RELEASE)

    def _send_heartbeat(self) -> None:
        if self.mine:
            self._client.publish(CONSOLE_HEARTBEAT, ConsoleHeartbeat(holds=1))

    def _send(self, twist: Twist) -> None:
        self._client.publish(VELOCITY_COMMAND, TwistStamped.of(twist))

    def _request(self, action: ControlAction) -> None:
        def answered(result: CommonResult, _info: MessageInfo) -> None:
            if not result.done and action is ControlAction.TAKE:
                self._show(f"the {self._sender.noun} cannot drive: {result.text}")

        def failed(error: QueryError) -> None:
            if action is ControlAction.TAKE:
                noun, release = self._sender.noun, self._sender.release
                self._show(f"the {noun} cannot drive; {release} and try again: {error}")

        self._client.query_notify(
            CONTROL_REQUEST,
            ControlRequest(action=action, operator=self._sender.owner),
            COMMON_RESULT,
            timeout=_ANSWER_S,
            answered=answered,
            failed=failed,
        )
