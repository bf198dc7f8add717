"""The five bodies of the tests: the four that Rune ships, and one that only the tests describe."""

from __future__ import annotations

import functools
import re
import tomllib
from pathlib import Path
from typing import Any

from hub.robots.description import RobotDescription
from hub.robots.robot_file import find_robot_file, read_description, shipped_bodies

CARRIER = "carrier"
_CARRIER_FILE = Path(__file__).parents[1] / "data" / "carrier.toml"
SHIPPED = "magellan", "tracked", "blimp", "rov"
BODIES = (*SHIPPED, CARRIER)
REST_S = {"magellan": 0.7, "tracked": 0.7, "carrier": 0.7, "rov": 1.5, "blimp": 4.0}
"""Longest time from a command to stop to rest [s], after docs/safety.md."""
STILL = {"blimp": 0.1, "rov": 0.05}
"""Speed below which a body that drafts or currents carry is at rest; wheels stand [m/s]."""
STANDING = 1e-3
"""Wheels that are slower stand [m/s, rad/s]."""


@functools.cache
def robot_of(name: str) -> RobotDescription:
    """The robot with this body, in its own arena."""
    path = _CARRIER_FILE if name == CARRIER else find_robot_file(name)
    robot, problems = read_description(path)
    assert not problems
    return robot


def hub_with(name: str, kind: str = "simulated-wheels") -> dict[str, Any]:
    """The keys of a `HubProcess` whose robot has this body, as a robot of another kind."""
    file = _CARRIER_FILE if name == CARRIER else shipped_bodies()[f"simulated-{name}"]
    text = file.read_text()
    base = tomllib.loads(text).get("simulation", {}).get("base", "wheels")
    flags = re.DOTALL | re.MULTILINE
    return {
        "kind": kind,
        "arena": "pool" if base == "rov" else "empty",
        "options": ("--set", f"simulation.base={base}"),
        "tables": re.sub(r"\A.*?(?=^\[(?:limits|body)\])", "", text, flags=flags),
    }
