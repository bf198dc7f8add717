"""What a running hub cannot keep: messages of its recording, marks and map of its mission."""

from __future__ import annotations

from collections.abc import Sequence

from hub.errors import QueryError
from hub.gcm.mission import MISSION_STATE
from hub.gcm.recording import RECORD_STATE
from hub.ipc.client import Client
from hub.ipc.wire import control
from hub.plain_text import counted

_ANSWER_S = 2.0


def not_kept(client: Client, peers: Sequence[control.ListedPeer]) -> list[str]:
    """What is lost or not on the disk, and what is not known of it, in sentences.

    Args:
        client: A client of the hub.
        peers: All that are connected to it.
    """
    published = {name for peer in peers for name in peer.publishes.split()}
    found: list[str] = []
    for what, definition, lacks in (
        ("recording", RECORD_STATE, _recording_lacks),
        ("mission", MISSION_STATE, _mission_lacks),
    ):
        if definition.name in published:
            try:
                sentences = lacks(client)
            except QueryError as error:
                sentences = [f"not known whether all is kept ({error})"]
            found += [f"{what}: {each}" for each in sentences]
    return found


def _recording_lacks(client: Client) -> list[str]:
    state = client.last_value(RECORD_STATE, timeout=_ANSWER_S)
    lost = f"{counted(state.lost, 'message')} of it are in no file"
    return [*filter(None, [state.fault]), *([lost] if state.lost else [])]


def _mission_lacks(client: Client) -> list[str]:
    state = client.last_value(MISSION_STATE, timeout=_ANSWER_S)
    unkept = f"{counted(state.unkept, 'change')} of marks in memory only"
    return [*filter(None, [state.fault]), *([unkept] if state.unkept else [])]
