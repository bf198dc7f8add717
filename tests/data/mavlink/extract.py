"""Makes the extract of a recorded session of a vehicle.

    python -m tests.data.mavlink.extract SESSION.tlog START OUT.json.gz

A .tlog has frames of both directions, each after 8 bytes: microseconds since the epoch, big-endian.
START is when the vehicle was started, on the same clock [s]. The extract is JSON, in gzip; times
count from START [s].

| key | content |
| --- | --- |
| commands | time, number, parameters 1 and 2 of each COMMAND_LONG |
| answers | time, number, result of each COMMAND_ACK |
| streams | first and last time, message, fields of messages that were repeated unchanged |
| heartbeats | time, base_mode, custom_mode, system_status, where any of them changed |
| texts | time, severity, text |
| truth | time, ahead, right, down [m/s], clockwise [rad/s], depth [m], ten times a second |
"""

import gzip
import json
import math
import struct
import sys
from pathlib import Path

from hub.robots.mavlink.wire.frames import FrameParser, MavlinkFrame

STATION = 255
REPEATED = ("HEARTBEAT", "MANUAL_CONTROL", "RC_CHANNELS_OVERRIDE", "SET_POSITION_TARGET_LOCAL_NED")
TIME = "time_boot_ms"
GAP_S = 1.5
"""A stream that is silent for so long has ended."""
KEYS = ("commands", "answers", "streams", "heartbeats", "texts", "truth")
LEFT_OUT = ("Field Elevation Set", "in-flight yaw alignment")


def frames_of(path: Path, start: float) -> list[tuple[float, MavlinkFrame]]:
    """The frames of a session with their times."""
    data, at, frames = path.read_bytes(), 0, []
    while at < len(data):
        time = struct.unpack_from(">Q", data, at)[0] / 1e6 - start
        size = 12 + data[at + 9] + (13 if data[at + 10] & 1 else 0)
        frames += [(time, frame) for frame in FrameParser().feed(data[at + 8 : at + 8 + size])]
        at += 8 + size
    return frames


def extract(path: Path, start: float) -> dict[str, list]:
    """The extract of a session."""
    made: dict[str, list] = {key: [] for key in KEYS}
    for time, frame in frames_of(path, start):
        if frame.system == STATION:
            take_sent(made, round(time, 3), frame)
        else:
            take_received(made, round(time, 3), frame)
    return made


def take_sent(made: dict[str, list], time: float, frame: MavlinkFrame) -> None:
    """Take what the station sent."""
    fields = frame.fields
    if frame.name == "COMMAND_LONG":
        made["commands"].append([time, fields["command"], fields["param1"], fields["param2"]])
    elif frame.name in REPEATED:
        kept = {name: value for name, value in fields.items() if value and name != TIME}
        same = [each for each in made["streams"] if each[2] == frame.name][-1:]
        if not same or same[0][3] != kept or time - same[0][1] > GAP_S:
            made["streams"].append([time, time, frame.name, kept])
        else:
            same[0][1] = time


def take_received(made: dict[str, list], time: float, frame: MavlinkFrame) -> None:
    """Take what the vehicle sent."""
    fields = frame.fields
    if frame.name == "COMMAND_ACK":
        made["answers"].append([time, fields["command"], fields["result"]])
    elif frame.name == "HEARTBEAT":
        shown = [fields["base_mode"], fields["custom_mode"], fields["system_status"]]
        if not made["heartbeats"] or made["heartbeats"][-1][1:] != shown:
            made["heartbeats"].append([time, *shown])
    elif frame.name == "STATUSTEXT" and not any(map(fields["text"].count, LEFT_OUT)):
        made["texts"].append([time, fields["severity"], fields["text"]])
    elif frame.name == "SIM_STATE":
        made["truth"].append([time, *(round(each, 3) for each in motion(fields))])


def motion(fields: dict[str, float]) -> tuple[float, ...]:
    """Velocities along the body's axes, and the depth."""
    cos, sin = math.cos(fields["yaw"]), math.sin(fields["yaw"])
    north, east = fields["vn"], fields["ve"]
    flat = north * cos + east * sin, east * cos - north * sin
    return *flat, fields["vd"], fields["zgyro"], -fields["alt"]


if __name__ == "__main__":
    session, start, out = Path(sys.argv[1]), float(sys.argv[2]), Path(sys.argv[3])
    text = json.dumps(extract(session, start), separators=(",", ":"))
    out.write_bytes(gzip.compress(text.encode(), mtime=0))
