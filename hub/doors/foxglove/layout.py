"""A layout for Foxglove and Lichtblick, with the topics of one robot; pure, except its template."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

from hub.gcm.body import Freedom, RobotBody
from hub.gcm.ranges import RANGES
from hub.gcm.vision import IMAGE
from hub.ros.standard_topics import standard_topics

LAYOUT: Final = Path(__file__).with_suffix(".json")
"""The layout for any robot; its picture is of a camera named "camera"."""


def layout_of(body: RobotBody) -> str:
    """The layout with the camera, the range sensors and the speeds of this robot."""
    layout: dict[str, Any] = json.loads(LAYOUT.read_text("utf-8"))
    panels = layout["configById"]
    topics = standard_topics(body)
    picture = next((each.name for each in topics if each.source is IMAGE), "")
    if picture:
        info = picture.removesuffix("/image/compressed") + "/camera_info"
        panels["Image!rune"]["imageMode"] |= {"imageTopic": picture, "calibrationTopic": info}
    space = panels["3D!rune"]["topics"]
    shown = space.pop("/scan")
    space |= {each.name: shown for each in topics if each.source is RANGES}
    limits = {motion.freedom: motion.limit for motion in body.motions}
    for button, freedom, sign in (
        ("upButton", Freedom.SURGE, 1.0),
        ("downButton", Freedom.SURGE, -1.0),
        ("leftButton", Freedom.YAW, 1.0),
        ("rightButton", Freedom.YAW, -1.0),
    ):
        # Half of what it can: a button is all or nothing.
        panels["Teleop!rune"][button]["value"] = sign * round(limits.get(freedom, 0.0) / 2.0, 3)
    return json.dumps(layout, indent=2) + "\n"
