"""The quality of service of topics, as all releases of rosbag2 read it in MCAP files.

Since its version 9 rosbag2 writes words, before it wrote numbers: releases until Iron refuse words,
and later ones refuse numbers unless the file says that its version is older. Files of Rune have
numbers and say version 5.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

QOS: Final = "offered_qos_profiles"
"""The key of a topic's metadata that rosbag2 reads."""
TYPE_HASH: Final = "topic_type_hash"
"""The key of the hash of a topic's type, which rosbag2 reads and writes since Iron."""
VERSION: Final = 5
"""Version of the metadata, which all releases of rosbag2 since Galactic read."""
ROSBAG2: Final = "rosbag2"
"""Name of the metadata with what rosbag2 says of its file; nothing in it is of what is recorded."""
FACTS: Final[Mapping[str, str]] = {
    "serialized_metadata": (
        f"version: {VERSION}\nstorage_identifier: mcap\nduration: {{nanoseconds: 0}}\n"
        "starting_time: {nanoseconds_since_epoch: 0}\nmessage_count: 0\n"
        'topics_with_message_count: []\ncompression_format: ""\ncompression_mode: ""\n'
        "relative_file_paths: []\nfiles: []\n"
    )
}
"""That metadata in files of Rune: rosbag2 takes all but the version from the index."""

_NUMBERS: Final = {
    "history": ("system_default", "keep_last", "keep_all", "unknown"),
    "reliability": ("system_default", "reliable", "best_effort", "unknown", "best_available"),
    "durability": (
        "system_default", "transient_local", "volatile", "unknown", "best_available",
    ),
    "liveliness": (
        "system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown",
        "best_available",
    ),
}  # fmt: skip
_WORD = re.compile(rf"\b({'|'.join(_NUMBERS)}):([ \t]+)['\"]?([a-z_]+)['\"]?")


def numbered(profiles: str) -> str:
    """Profiles with numbers in place of words; other words stay."""
    return _WORD.sub(_number, profiles)


def _number(match: re.Match[str]) -> str:
    policy, space, word = match.groups()
    words = _NUMBERS[policy]
    return f"{policy}:{space}{words.index(word)}" if word in words else match[0]
