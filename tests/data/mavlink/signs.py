"""Makes the extract with which signs of telemetry are compared with the simulator's own state.

    python -m tests.data.mavlink.signs SESSION.tlog START SIGNS.json

The extract is a list: ATTITUDE, LOCAL_POSITION_NED and SIM_STATE, each with its fields, as they
came together; one such set every eight seconds.
"""

import json
import sys
from pathlib import Path

from tests.data.mavlink.extract import STATION, frames_of

NAMES = ("ATTITUDE", "LOCAL_POSITION_NED", "SIM_STATE")
EVERY_S = 8.0


def signs(path: Path, start: float) -> list[dict[str, dict]]:
    """The sets of a session."""
    newest: dict[str, dict] = {}
    sets: list[dict[str, dict]] = []
    due = 50.0  # all of them are armed then
    for time, frame in frames_of(path, start):
        if frame.system != STATION and frame.name in NAMES:
            newest[frame.name] = rounded(frame.fields)
        if time >= due and frame.name == "SIM_STATE" and len(newest) == len(NAMES):
            due = time + EVERY_S
            sets.append(dict(newest))
    return sets


def rounded(fields):
    """Fields with short numbers."""
    return {
        name: round(value, 5) if isinstance(value, float) else value
        for name, value in fields.items()
    }


if __name__ == "__main__":
    session, start, out = Path(sys.argv[1]), float(sys.argv[2]), Path(sys.argv[3])
    out.write_text(json.dumps(signs(session, start), separators=(",", ":")) + "\n")
