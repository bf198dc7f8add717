"""The table of MAVLink messages, from the definitions in pymavlink's wheel."""

from pathlib import Path
from xml.etree import ElementTree

import pymavlink

DIALECTS = (
    "minimal",
    "standard",
    "common",
    "ardupilotmega",
    "uAvionix",
    "icarous",
    "loweheiser",
    "cubepilot",
    "csAirLink",
)
SIZES = {
    "char": (1, "s"),
    "uint8_t": (1, "B"),
    "int8_t": (1, "b"),
    "uint16_t": (2, "H"),
    "int16_t": (2, "h"),
    "uint32_t": (4, "I"),
    "int32_t": (4, "i"),
    "float": (4, "f"),
    "uint64_t": (8, "Q"),
    "int64_t": (8, "q"),
    "double": (8, "d"),
}
_READ = """
AHRS2 ATTITUDE AUTOPILOT_VERSION BATTERY_STATUS CAMERA_INFORMATION COMMAND_ACK COMMAND_INT
COMMAND_LONG DISTANCE_SENSOR EKF_STATUS_REPORT ESTIMATOR_STATUS EXTENDED_SYS_STATE FENCE_STATUS
GIMBAL_DEVICE_ATTITUDE_STATUS GIMBAL_MANAGER_INFORMATION GIMBAL_MANAGER_SET_PITCHYAW
GIMBAL_MANAGER_STATUS GLOBAL_POSITION_INT GPS_GLOBAL_ORIGIN GPS_RAW_INT HEARTBEAT HOME_POSITION
LOCAL_POSITION_NED MANUAL_CONTROL MESSAGE_INTERVAL MISSION_ACK MISSION_CLEAR_ALL MISSION_COUNT
MISSION_CURRENT MISSION_REQUEST MISSION_SET_CURRENT
MISSION_ITEM_INT MISSION_REQUEST_INT MISSION_REQUEST_LIST NAMED_VALUE_FLOAT OBSTACLE_DISTANCE
ODOMETRY PARAM_REQUEST_LIST PARAM_REQUEST_READ PARAM_SET PARAM_VALUE PING
POSITION_TARGET_LOCAL_NED RADIO_STATUS RANGEFINDER RAW_IMU RC_CHANNELS RC_CHANNELS_OVERRIDE
REQUEST_DATA_STREAM SCALED_IMU2 SCALED_PRESSURE SCALED_PRESSURE2 SERVO_OUTPUT_RAW SETUP_SIGNING
SET_GPS_GLOBAL_ORIGIN SET_MODE SET_POSITION_TARGET_LOCAL_NED SIM_STATE STATUSTEXT SYSTEM_TIME
SYS_STATUS TIMESYNC VFR_HUD VIBRATION VIDEO_STREAM_INFORMATION VISION_POSITION_ESTIMATE
WATER_DEPTH
"""
READ = frozenset(_READ.split())
"""Messages whose fields Rune reads or writes."""
HEAD = """\
# MAVLink messages: name, id, CRC extra, least length of the payload; wire format and fields.
# A test writes this file from the definitions in pymavlink's wheel (MIT licence).
"""


def table() -> str:
    """The whole file."""
    folder = Path(pymavlink.__file__).parent / "dialects" / "v20"
    lines: dict[int, str] = {}
    names = set()
    for dialect in DIALECTS:
        root = ElementTree.parse(folder / f"{dialect}.xml").getroot()
        for message in root.iter("message"):
            number, line = _line(message)
            names.add(message.get("name"))
            lines.setdefault(number, line)
    assert names >= READ, READ - names
    return HEAD + "\n".join(line for _, line in sorted(lines.items())) + "\n"


def _line(message: ElementTree.Element) -> tuple[int, str]:
    name, number = message.attrib["name"], int(message.attrib["id"])
    base, extensions = _fields(message)
    crc = _checksum(f"{name} ".encode())
    for field, kind, count in base:
        crc = _checksum(f"{kind} {field} ".encode() + (bytes([count]) if count else b""), crc)
    least = sum(SIZES[kind][0] * max(1, count) for _, kind, count in base)
    words = [name, str(number), str(crc & 0xFF ^ crc >> 8), str(least)]
    if name in READ:
        fields = base + extensions
        wire = "".join(f"{count or ''}{SIZES[kind][1]}" for _, kind, count in fields)
        words += [f"<{wire}", *(field for field, _, _ in fields)]
    return number, " ".join(words)


def _fields(
    message: ElementTree.Element,
) -> tuple[list[tuple[str, str, int]], list[tuple[str, str, int]]]:
    """The fields, the largest types first, and those added later in their own order."""
    base: list[tuple[str, str, int]] = []
    extensions: list[tuple[str, str, int]] = []
    into = base
    for child in message:
        if child.tag == "extensions":
            into = extensions
        elif child.tag == "field":
            kind, _, count = child.attrib["type"].partition("[")
            kind = kind.replace("_mavlink_version", "")
            into.append((child.attrib["name"], kind, int(count[:-1]) if count else 0))
    return sorted(base, key=lambda field: -SIZES[field[1]][0]), extensions


def _checksum(data: bytes, crc: int = 0xFFFF) -> int:
    for byte in data:
        low = (byte ^ crc) & 0xFF
        low = (low ^ low << 4) & 0xFF
        crc = (crc >> 8 ^ low << 8 ^ low << 3 ^ low >> 4) & 0xFFFF
    return crc
