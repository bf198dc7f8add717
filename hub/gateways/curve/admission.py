"""Admits control messages from other machines, by their keys and quotas."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from typing import Any

import zmq

from hub.errors import CodecError, FrameError, NotAllowedError
from hub.gateways.accounts import Account, Accounts, QuotaVerdict
from hub.ipc.roles import Principal, Role, parse_principal
from hub.ipc.security import permissions
from hub.ipc.transport.fault_counter import FaultCounter
from hub.ipc.wire import control_codec


class Admission:
    """Charges each control message to the account of its key."""

    def __init__(
        self,
        accounts: Accounts,
        *,
        clock: Callable[[], float],
        faults: FaultCounter,
        answer: Callable[[bytes, Any], None],
        hang_up: Callable[[zmq.Frame], None],
        identified: Callable[[zmq.Frame, Role], None],
        holds: Callable[[Principal], bool],
    ) -> None:
        """Start to admit.

        Args:
            accounts: The accounts of the keys.
            clock: Monotonic time [s].
            faults: Counts refused messages.
            answer: Sends a control message to a connection.
            hang_up: Ends the connection of a frame.
            identified: Gets the role of the key of each frame's connection.
            holds: Whether a key is still on the list.
        """
        self._accounts = accounts
        self._clock = clock
        self._faults = faults
        self._answer = answer
        self._hang_up = hang_up
        self._identified = identified
        self._holds = holds

    def principal_of(self, frame: zmq.Frame) -> Principal:
        """The key of the connection that a frame came on.

        Raises:
            NotAllowedError: It has none, or one that was removed.
        """
        known = parse_principal(str(frame.get("User-Id")))
        if not self._holds(known):
            text = f"the key of {known} was removed"
            raise NotAllowedError(text)
        return known

    def admits(self, principal: Principal, identity: bytes, body: Sequence[zmq.Frame]) -> bool:
        """Whether central serves a message; too many refusals end the connection.

        Args:
            principal: Holder of the connection's key.
            identity: Of its connection.
            body: Its parts.
        """
        account, now = self._accounts.of(principal), self._clock()
        self._identified(body[0], principal.role)
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
        """Answer with the reason, if the message has an answer."""
        with contextlib.suppress(FrameError, CodecError):
            answer = permissions.refusal(control_codec.unpack(frame.buffer), account.text)
            if answer is not None:
                self._answer(identity, answer)
