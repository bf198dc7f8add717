"""`rune-hub status`, `log`, `close`, `log-level`: the state of central, and orders to it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from hub.command_output import put, put_json
from hub.errors import NotAllowedError, UnknownModuleError
from hub.inspection import value_text
from hub.inspection.hub_watch import HubWatch
from hub.inspection.kept import not_kept
from hub.inspection.message_commands import find
from hub.inspection.output import span, table
from hub.ipc.client import Client
from hub.ipc.definition import MessageDefinition
from hub.ipc.message_info import MessageInfo
from hub.ipc.roles import ON_THE_ROBOT
from hub.ipc.wire import control

_ANSWER_S = 2.0


def status(client: Client, *, as_json: bool) -> int:
    """Show modules, the recent rate and the faults of each message, and what is not kept.

    Returns:
        The exit code: 1 where something is not kept, or it is not known.
    """
    now = client.directory.listing(_ANSWER_S)
    unkept = not_kept(client, now.peers)
    flows = _flows(now)
    peers = [peer for peer in now.peers if peer.name != client.name]
    if as_json:
        answer = value_text.plain(now) | {"peers": [value_text.plain(peer) for peer in peers]}
        del answer["definitions"]
        put_json(answer | {"messages": flows, "not_kept": unkept})
        return 1 if unkept else 0
    put(f"central at {client.endpoint}, up {span(now.uptime_s)}, logs {now.level}")
    table(
        ("module", "pid", "role", "heard", "publishes", "subscribes", "answers"),
        [
            (
                peer.name,
                str(peer.pid),
                peer.role,
                f"{peer.silent_s:.1f} s ago",
                *(str(len(x.split())) for x in (peer.publishes, peer.subscribes, peer.handles)),
            )
            for peer in peers
        ],
    )
    counted = ("messages", "missed", "too old", "refused")
    table(
        ("message", "plane", "1/s", "kB/s", *counted, "oldest", "last"),
        [_row(flow) for flow in flows],
    )
    for count in now.dropped:
        put(f"dropped: {count.reason}: {count.count}")
    for sentence in unkept:
        put(sentence)
    return 1 if unkept else 0


def trace(client: Client, names: Sequence[str], *, with_data: bool, count: int) -> int:
    """Write one line for each message of these names, until `count` were written (0: no limit)."""
    publishers: dict[int, str] = {}
    written = 0

    def note(definition: MessageDefinition[Any]) -> Callable[[object, MessageInfo], None]:
        def write(value: object, how: MessageInfo) -> None:
            nonlocal written
            written += 1
            clock = time.strftime("%H:%M:%S", time.localtime())
            publisher = publishers.get(how.publisher, f"number {how.publisher}")
            put(
                f"{clock} {definition.name} {{{how.sequence}}} from {publisher}, "
                f"{how.age * 1e3:.1f} ms old, {how.missed} missed"
            )
            if with_data:
                for line in value_text.lines(value, definition.record):
                    put(f"    {line}")

        return write

    for name in names:
        definition = find(client, name)
        client.subscribe(definition, note(definition))

    def learn() -> None:
        listing = client.directory.listing(_ANSWER_S)
        publishers.update({peer.publisher: peer.name for peer in listing.peers})

    learn()
    client.directory.watch(lambda _: client.post(learn))
    watch = HubWatch(client)
    while count == 0 or written < count:
        watch.listen(0.2)
    return 0


def close(client: Client, name: str) -> int:
    """Have central disconnect a module."""
    try:
        client.directory.close_module(name, timeout=_ANSWER_S)
    except UnknownModuleError as error:
        text = f"{error}; `rune-hub list` shows all"
        raise UnknownModuleError(text) from error
    put(f"{name} is disconnected")
    return 0


def log_level(client: Client, level: str) -> int:
    """Set from which level on central logs.

    Raises:
        NotAllowedError: The client's key is not one of the robot's own modules.
    """
    client.directory.set_log_level(level)
    now = client.directory.listing(_ANSWER_S).level
    if now != level:
        text = f"the hub still logs from {now} on, as this key may not change it; {ON_THE_ROBOT}"
        raise NotAllowedError(text)
    put(f"central logs from {now} on")
    return 0


def _flows(now: control.Listing) -> list[dict[str, str | float]]:
    """For each message how it flows; those with the highest rate first."""
    flows: list[dict[str, str | float]] = [
        {
            "name": entry.name,
            "plane": entry.plane,
            "rate_hz": entry.messages_per_s,
            "bytes_per_s": entry.bytes_per_s,
            "messages": entry.messages,
            "bytes": entry.bytes,
            "missed": entry.lost,
            "expired": entry.expired,
            "refused": entry.refused,
            "oldest_s": entry.oldest_s,
            "silent_s": entry.silent_s if entry.messages else -1.0,
        }
        for entry in now.definitions
    ]
    return sorted(flows, key=lambda flow: (-float(flow["rate_hz"]), str(flow["name"])))


def _row(flow: dict[str, str | float]) -> tuple[str, ...]:
    silent = float(flow["silent_s"])
    return (
        str(flow["name"]),
        str(flow["plane"]),
        f"{float(flow['rate_hz']):.1f}",
        f"{float(flow['bytes_per_s']) / 1e3:.1f}",
        str(flow["messages"]),
        str(flow["missed"]),
        str(flow["expired"]),
        str(flow["refused"]),
        f"{float(flow['oldest_s']) * 1e3:.0f} ms",
        "never" if silent < 0.0 else f"{span(silent)} ago",
    )
