"""The batteries of a recording: which of them count to 100."""

from __future__ import annotations

import itertools
from typing import Final

from hub.recording.ros.topic_roles import RosRole
from hub.recording.ros.topic_values import TopicMessages, TopicValues
from hub.ros.battery import BatteryReader, counts_to_100

_FIRST: Final = 20


def battery_readers(bag: TopicMessages, values: TopicValues) -> dict[int, BatteryReader]:
    """A reader for each topic of a battery, by its number, the preferred one first.

    A battery is nearly full at one end of a recording at least, and shows there how it counts.
    """
    made = {}
    for each in values.of_role(RosRole.BATTERY):
        channel = {each.channel}
        first = itertools.islice(bag.messages(channels=channel), _FIRST)
        ends = (*first, *bag.newest(bag.end, channel).values())
        percent = any(values.converted(message, counts_to_100) for message in ends)
        made[each.channel] = BatteryReader(percent=percent)
    return made
