"""The commands that inspect a running hub; each returns the exit code."""

from __future__ import annotations

import contextlib
import itertools
import os
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

from hub.command_output import print_error, put, put_json
from hub.errors import (
    CentralUnreachableError,
    HubError,
    NoHandlerError,
    QueryError,
    UndefinedMessageError,
)
from hub.gcm.catalog import BY_NAME
from hub.gcm.common import CommonResult
from hub.gcm.control import CONTROL_STATE, is_restricted
from hub.inspection import value_text
from hub.inspection.halt_command import halt_facts
from hub.inspection.hub_watch import HubWatch
from hub.inspection.output import outcome
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo, decode
from hub.ipc.security.client_keys import read_client_keys
from hub.ipc.wire import control
from hub.ipc.wire.definition_listing import from_listing
from hub.nearest import did_you_mean
from hub.plain_text import plain
from hub.table_text import json_text

T = TypeVar("T")

_ANSWER_S = 2.0
_STOP_CONNECTS_S = 8.0
"""Longest time for the connection of a stop, which is tried on slow links too [s]."""
_STOP_SILENT_S = 1.0
"""Time without a hub's answer after which a stop says that the robot is not stopped yet [s]."""
_BETWEEN_S = 0.05
"""Time between two messages, so that a receiver sees both and not only the newer one [s]."""


def connect(endpoint: str, command: str, keys: Path | None) -> Client:
    """A connected client for one command.

    Raises:
        HubError: The endpoint is wrong, or no hub answers there.
    """
    name = f"rune-hub-{command}-{os.getpid()}"
    client = Client(name, endpoint, keys=read_client_keys(keys) if keys else None)
    try:
        if command == "halt":
            _connect_stop(client)
        else:
            client.wait_connected(_ANSWER_S)
    except HubError:
        client.close()
        raise
    return client


def _connect_stop(client: Client) -> None:
    """Connect for a stop, and say early that the robot may go on."""
    try:
        client.wait_connected(_STOP_SILENT_S)
    except CentralUnreachableError as error:
        print_error(f"the robot is NOT stopped yet; use its emergency stop: {error}")
        client.wait_connected(_STOP_CONNECTS_S - _STOP_SILENT_S)


@contextlib.contextmanager
def failures_explained(command: str, *, as_json: bool, hub: str = "") -> Iterator[None]:
    """Begin the error of a stop with what it means for the robot.

    Args:
        command: The command.
        as_json: Whether a stop also reports it as JSON.
        hub: Name of the hub there; empty: it is the only one.
    """
    begun = time.monotonic()
    try:
        yield
    except HubError as error:
        if command != "halt":
            raise
        text = f"the robot was NOT stopped; use its emergency stop: {error}"
        if as_json:
            put_json(halt_facts(None, hub=hub, seconds=time.monotonic() - begun, problem=text))
        raise type(error)(text) from error


def list_all(client: Client, *, as_json: bool) -> int:
    """Show modules, messages, and dropped messages of central."""
    listing = client.directory.listing(_ANSWER_S)
    peers = [peer for peer in listing.peers if peer.name != client.name]
    if as_json:
        put_json(value_text.plain(listing) | {"peers": [value_text.plain(peer) for peer in peers]})
        return 0
    put(f"{len(peers)} modules and consoles")
    for peer in peers:
        answers = f", answers {peer.handles}" if peer.handles else ""
        put(f"  {peer.name} (pid {peer.pid}, heard {peer.silent_s:.1f} s ago{answers})")
    put(f"{len(listing.definitions)} messages")
    for entry in sorted(listing.definitions, key=lambda entry: entry.name):
        length = "fixed" if from_listing(entry).fixed_length else "variable"
        seen = f"{entry.messages} seen, {entry.bytes} bytes"
        put(f"  {entry.name} ({length} length, by {entry.definer}; {seen})")
        put(f"    {entry.format}")
        put(f"    {entry.fields}")
    for count in listing.dropped:
        put(f"dropped: {count.reason}: {count.count}")
    return 0


def echo(client: Client, name: str, *, count: int, as_json: bool) -> int:
    """Show `count` messages as they arrive (0: until Ctrl-C)."""
    definition = find(client, name)
    shown = 0

    def show(value: Any, reception: MessageInfo) -> None:  # noqa: ANN401 - any message
        nonlocal shown
        shown += 1
        _show(definition, value, as_json=as_json, reception=reception)

    client.subscribe(definition, show)
    watch = HubWatch(client)
    while count == 0 or shown < count:
        watch.listen(0.2)
    return 0


def rate(client: Client, name: str, *, seconds: float, as_json: bool) -> int:
    """Show the rate of a message, each second, for `seconds` (0: until Ctrl-C)."""
    definition = find(client, name)
    arrivals: list[float] = []
    ages: list[float] = []
    missed = 0

    def note(value: object, reception: MessageInfo) -> None:
        nonlocal missed
        del value
        arrivals.append(time.monotonic())
        ages.append(reception.age)
        missed += reception.missed

    client.subscribe(definition, note)
    end = time.monotonic() + seconds if seconds else float("inf")
    watch = HubWatch(client)
    while time.monotonic() < end:
        _serve_for(watch, min(1.0, end - time.monotonic()))
        put(_rate_line(name, arrivals, ages, missed, as_json=as_json))
        del arrivals[:-1], ages[:-1]
    return 0


def send(
    client: Client, name: str, assignments: Sequence[str], *, rate_hz: float, zero_first: bool
) -> int:
    """Publish one message, or at `rate_hz` until Ctrl-C; on request, one of zeros before.

    Returns:
        The exit code: 1 if no module listens, or another client has control.
    """
    definition = find(client, name)
    value = value_text.value_from_text(definition, assignments, print_error)
    value_text.demand_within_ranges(definition, value)
    client.demand_right(definition)
    owner = _owner(client) if is_restricted(name, value) else ""
    if owner:
        text = f"{owner} has control, so the robot refuses this; `rune-hub control` says more"
        print_error(plain(text))
    client.define(definition)
    client.wait_defined(_ANSWER_S)
    if zero_first:
        client.publish(definition, value_text.value_from_text(definition, []))
        client.wait_published(_ANSWER_S)
        _serve_for(client, _BETWEEN_S)
    client.publish(definition, value)
    client.wait_published(_ANSWER_S)
    heard = client.has_subscribers(definition)
    if not heard:
        text = "`rune-hub modules` shows which modules run, `rune-hub start` starts one"
        sys.stderr.write(f"rune-hub: nobody listens to {name} at {client.endpoint}; {text}\n")
    if rate_hz > 0:
        client.every(1.0 / rate_hz, lambda: client.publish(definition, value))
        watch = HubWatch(client)
        while True:
            watch.listen(0.2)
    return 0 if heard and not owner else 1


def _owner(client: Client) -> str:
    """The owner of control; empty: none, or the hub does not report it."""
    try:
        return client.last_value(CONTROL_STATE, timeout=_ANSWER_S).operator
    except QueryError:
        return ""


def query(
    client: Client, name: str, assignments: Sequence[str], *, timeout: float, as_json: bool
) -> int:
    """Ask, and show the answer; returns 1 if it is a refusal."""
    definition = find(client, name)
    value = value_text.value_from_text(definition, assignments, print_error)
    value_text.demand_within_ranges(definition, value)
    try:
        frame = client.query_frame(definition, value, timeout=timeout)
    except NoHandlerError as error:
        text = f"{error}; `rune-hub modules` shows which run, `rune-hub start` starts one"
        raise NoHandlerError(text) from error
    answered = find(client, frame.name)
    answer = decode(answered, frame)
    _show(answered, answer, as_json=as_json, reception=None)
    return outcome(answer) if isinstance(answer, CommonResult) else 0


def find(client: Client, name: str) -> MessageDefinition[Any]:
    """The definition of a message, from GCM or from central's listing.

    Raises:
        UndefinedMessageError: It is in neither.
    """
    if name in BY_NAME:
        return BY_NAME[name]
    listed: dict[str, control.Define] = {
        entry.name: entry for entry in client.directory.listing(_ANSWER_S).definitions
    }
    if name not in listed:
        advice = did_you_mean(name, listed) or "; `rune-hub list` shows all"
        text = f"no message {name!r} is defined at {client.endpoint}{advice}"
        raise UndefinedMessageError(text)
    return from_listing(listed[name])


def _serve_for(client: Client | HubWatch, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        client.listen(0.05)


def _show(
    definition: MessageDefinition[T], value: T, *, as_json: bool, reception: MessageInfo | None
) -> None:
    if as_json:
        put_json(value_text.plain(value, definition.record))
        return
    for line in value_text.lines(value, definition.record):
        put(line)
    if reception is not None:
        put(f"--- {reception.sequence}")


def _rate_line(
    name: str, arrivals: Sequence[float], ages: Sequence[float], missed: int, *, as_json: bool
) -> str:
    gaps = [later - earlier for earlier, later in itertools.pairwise(arrivals)]
    hertz = len(gaps) / sum(gaps) if gaps else 0.0
    if as_json:
        oldest = max(ages, default=0.0)
        return json_text({"name": name, "hz": hertz, "missed": missed, "oldest_s": oldest})
    if not gaps:
        return f"{name}: nothing comes"
    spread = f"gaps {min(gaps) * 1e3:.1f} to {max(gaps) * 1e3:.1f} ms"
    return f"{name}: {hertz:.1f} Hz, {spread}, oldest {max(ages) * 1e3:.1f} ms, {missed} missed"
