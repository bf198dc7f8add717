"""The page of the replay has the tables of what there is."""

from __future__ import annotations

import os
from pathlib import Path

from hub.recording.ros.topic_roles import ROLES, SHOWN_BY, RosRole
from hub.ros.decoding import READABLE
from hub.ros.foxglove import foxglove_names
from hub.ros.images import ENCODINGS
from rune_tui.replay.review_keys import ReviewTask

PAGE = Path(__file__).parents[3] / "docs" / "replay.md"


def key_rows() -> list[str]:
    keys = [task.value for task in ReviewTask if task.value.written]
    return [f"| {key.written.replace('|', chr(92) + '|')} | {key.does} |" for key in keys]


def role_rows() -> list[str]:
    by_role: dict[str, list[str]] = {}
    for name, role in ROLES.items():
        package, _, kind = name.split("/")
        types = by_role.setdefault(SHOWN_BY[role], [])
        types += [f"{package}/{kind}", *foxglove_names(name)]
    frames = SHOWN_BY[RosRole.FIXED_FRAMES]
    by_role[frames] = ["tf2_msgs/TFMessage in a topic tf_static"]
    return [f"| {', '.join(types)} | {shown} |" for shown, types in by_role.items()]


TABLES = {
    "roles": ["| type | shown by |", "| --- | --- |", *role_rows()],
    "messages": [
        "| encoding of messages | of their definitions |",
        "| --- | --- |",
        *(
            f"| `{encoding}` | {', '.join(f'`{each}`' if each else 'none' for each in schemas)} |"
            for encoding, schemas in READABLE.items()
        ),
    ],
    "keys": ["| key | does |", "| --- | --- |", *key_rows()],
    "encodings": [
        "| encodings of sensor_msgs/Image |",
        "| --- |",
        f"| {', '.join(f'`{each}`' for each in ENCODINGS)} |",
    ],
}


def test_the_page_has_each_type_and_encoding() -> None:
    """RUNE_WRITE_SNAPSHOTS=1 writes them anew."""
    whole = PAGE.read_text()
    for name, lines in TABLES.items():
        mark = f"<!-- {name} -->\n"
        before, _, behind = whole.partition(mark)
        _, _, rest = behind.partition("\n\n")
        whole = f"{before}{mark}{chr(10).join(lines)}\n\n{rest}"
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        PAGE.write_text(whole)
    assert PAGE.read_text() == whole
