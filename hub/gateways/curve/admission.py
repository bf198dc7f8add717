"""Decides whether a control message from another machine is served: its key, and its quota."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.errors import CodecError, FrameError, NotAllowedError
from hub.gateways.accounts import Account, Accounts, QuotaVerdict
from hub.ipc.roles import Principal, parse_principal
from hub.ipc.security import permissions
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control_codec


class Admission:
    """Asks the accounts of the keys about each control message."""

    def __init__(
        self,
        accounts: Accounts,
        *,
        clock: Callable[[], float],
        faults: FaultCounter,
        answer: Callable[[bytes, Any], None],
        hang_up: Callable[[zmq.Frame], None],
        holds: Callable[[Principal], bool],
    ) -> None:
        """Begin.

        Args:
            accounts: What the keys have used.
            clock: Monotonic time [s].
            faults: Counts what is refused.
            answer: Sends a control message to a connection.
            hang_up: Ends the connection that a frame came in on.
            holds: Whether this key was not removed.
        """
        self._accounts = accounts
        self._clock = clock
        self._faults = faults
        self._answer = answer
        self._hang_up = hang_up
        self._holds = holds

    def principal_of(self, frame: zmq.Frame) -> Principal:
        """The key of the connection on which a frame came.

        Raises:
            NotAllowedError: It has none, or one that was removed.
        """
        known = parse_principal(str(frame.get("User-Id")))
        if not self._holds(known):
            text = f"the key of {known} was removed"
            raise NotAllowedError(text)
        return known

    def admits(self, principal: Principal, identity: bytes, body: Sequence[zmq.Frame]) -> bool:
        """Whether central serves a message; too many are refused, then the connection is ended.

        Args:
            principal: Whose key it came with.
            identity: Of its connection.
            body: Its parts.
        """
        account, now = self._accounts.of(principal), self._clock()
        kind = control_codec.peek(body[0].buffer)
        verdict = account.ask(identity, kind, sum(map(len, body)), now)
        if verdict is QuotaVerdict.SERVED:
            return True
        self._faults.count("over quota", account.text)
        if verdict is QuotaVerdict.ENDED:
            self._faults.count("disconnected for asking too much", account.text)
            self._hang_up(body[0])
        elif account.may_answer(now):
            self._refuse(account, identity, body[0])
        return False

    def _refuse(self, account: Account, identity: bytes, frame: zmq.Frame) -> None:
        """Say why not, if what was asked has an answer."""
        with contextlib.suppress(FrameError, CodecError):
            answer = permissions.refusal(control_codec.unpack(frame.buffer), account.text)
            if answer is not None:
                self._answer(identity, answer)
