"""MAVLink frames: equal to those of pymavlink, found among noise, refused without a signature."""

import math
import os
import struct
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import ardupilotmega as reference

from hub.robots.mavlink.wire import definitions
from hub.robots.mavlink.wire.checksum import checksum, plain_checksum
from hub.robots.mavlink.wire.definitions import BY_NAME, BY_NUMBER, MessageFormat
from hub.robots.mavlink.wire.frames import FramePacker, FrameParser
from hub.robots.mavlink.wire.signing import Signer, SigningClock
from tests.support import mavlink_definitions

READ = [form for form in BY_NAME.values() if form.fields]
KEY = bytes(range(32))
NOW = 1_800_000_000.0
_WHOLE = {"B": 8, "H": 16, "I": 32, "Q": 64, "b": -8, "h": -16, "i": -32, "q": -64}


def test_the_table_is_that_of_the_definitions():
    """After a new version of pymavlink, write it: RUNE_WRITE_SNAPSHOTS=1 pytest with this file."""
    path = Path(definitions.__file__).with_suffix(".txt")
    table = mavlink_definitions.table()
    if os.environ.get("RUNE_WRITE_SNAPSHOTS"):
        path.write_text(table, "ascii")
    assert path.read_text("ascii") == table


def test_every_message_is_that_of_pymavlink():
    for number, known in reference.mavlink_map.items():
        form = BY_NUMBER[number]
        assert (form.name, form.crc_extra) == (known.msgname, known.crc_extra)
        if form.fields:
            assert form.wire.size == known.unpacker.size
            assert [field.name for field in form.fields] == list(known.ordered_fieldnames)


def numbers_of(code: str) -> st.SearchStrategy[object]:
    if code in "fd":
        return st.floats(width=32, allow_nan=False)
    bits = _WHOLE[code]
    if bits < 0:
        return st.integers(-(1 << -bits - 1), (1 << -bits - 1) - 1)
    return st.integers(0, (1 << bits) - 1)


def codes(form: MessageFormat) -> list[str]:
    return [each for each in form.wire.format if each.isalpha()]


@st.composite
def messages(draw: st.DrawFn) -> tuple[MessageFormat, dict[str, object]]:
    form = draw(st.sampled_from(READ))
    values: dict[str, object] = {}
    for field, code in zip(form.fields, codes(form), strict=True):
        if field.text:
            letters = st.characters(min_codepoint=33, max_codepoint=126)
            values[field.name] = draw(st.text(letters, max_size=field.count))
        elif field.count:
            count = field.count
            values[field.name] = tuple(
                draw(st.lists(numbers_of(code), min_size=count, max_size=count))
            )
        else:
            values[field.name] = draw(numbers_of(code))
    return form, values


def same(one: object, other: object) -> bool:
    if isinstance(one, tuple):
        return isinstance(other, (list, tuple, bytes)) and list(one) == list(other)
    return one == other


@given(messages(), st.integers(1, 255), st.integers(1, 255))
def test_pymavlink_reads_what_is_packed_and_packs_what_is_read(message, system, component):
    form, values = message
    theirs = reference.MAVLink(None, system, component)
    frame = FramePacker(system, component).pack(form.name, **values)
    (read,) = theirs.parse_buffer(frame)
    assert read.get_type() == form.name
    assert all(same(value, getattr(read, name)) for name, value in values.items())
    (mine,) = FrameParser().feed(bytes(read.pack(theirs)))
    assert (mine.name, mine.system, mine.component) == (form.name, system, component)
    assert all(same(value, mine[name]) for name, value in values.items())


def test_frames_of_version_1_are_read():
    theirs = reference.MAVLink(None, 7, 1)
    packed = bytes(
        theirs.attitude_encode(1000, 0.5, 0, 0, 0, 0, 0).pack(theirs, force_mavlink1=True)
    )
    assert packed[0] == 0xFE
    (frame,) = FrameParser().feed(packed)
    assert (frame.name, frame.system, frame["roll"]) == ("ATTITUDE", 7, 0.5)


@given(st.lists(st.binary(max_size=300), max_size=20), st.integers(1, 600))
def test_noise_between_frames_loses_none(noise, step):
    sent, stream = 0, b""
    packer = FramePacker(1, 1)
    for each in noise:
        stream += packer.pack("ATTITUDE", time_boot_ms=sent) + each.replace(b"\xfd", b"").replace(
            b"\xfe", b""
        )
        sent += 1
    parser = FrameParser()
    read = [
        frame["time_boot_ms"]
        for at in range(0, len(stream), step)
        for frame in parser.feed(stream[at : at + step])
    ]
    assert read == list(range(sent))


@given(st.binary(max_size=2000))
def test_any_bytes_end_in_frames_or_counts(data):
    parser = FrameParser()
    frames = parser.feed(data) + parser.datagram(data)
    assert all(frame.raw in data for frame in frames)


@given(messages(), st.data())
def test_a_changed_bit_is_noticed(message, data):
    form, values = message
    frame = bytearray(FramePacker(1, 1).pack(form.name, **values))
    at = data.draw(st.integers(1, len(frame) - 1))
    frame[at] ^= 1 << data.draw(st.integers(0, 7))
    assert not [each for each in FrameParser().datagram(bytes(frame)) if each.name == form.name]


def test_a_false_start_holds_nothing_back_in_a_datagram():
    parser = FrameParser()
    assert not parser.datagram(b"\xfd\xff\x00\x00\x00\x01\x01\x00\x00\x00")
    assert [each.name for each in parser.datagram(FramePacker(1, 1).pack("HEARTBEAT"))] == [
        "HEARTBEAT"
    ]


@pytest.mark.parametrize("wrong", [{"nothing": 1}, {"target": 256}, {"x": math.inf}])
def test_a_field_that_is_none_or_out_of_range_is_refused(wrong):
    with pytest.raises((KeyError, struct.error, OverflowError)):
        FramePacker(255, 190).pack("MANUAL_CONTROL", **wrong)


@given(st.binary(max_size=400))
def test_both_checksums_are_equal(data):
    assert plain_checksum(data) == checksum(data)


def signer(path=None, now=NOW, link=0, key=KEY):
    return Signer(key, SigningClock(path, lambda: now), link)


def test_pymavlink_accepts_signed_frames_and_makes_such():
    theirs = reference.MAVLink(None, 1, 1)
    theirs.signing.secret_key = KEY
    theirs.signing.sign_outgoing = True
    theirs.signing.timestamp = int((NOW - 1420070400) * 1e5)
    packer = FramePacker(255, 190, signer())
    for _ in range(3):
        (read,) = theirs.parse_buffer(packer.pack("HEARTBEAT", type=6))
        assert read.get_signed()
    parser = FrameParser(signer())
    for _ in range(3):
        (frame,) = parser.feed(bytes(theirs.heartbeat_encode(10, 3, 0, 0, 3).pack(theirs)))
        assert frame.signed


def test_frames_without_a_genuine_signature_are_refused():
    parser = FrameParser(signer())
    packer = FramePacker(255, 190, signer())
    good = packer.pack("HEARTBEAT")
    assert parser.feed(good)
    for bad in (
        good,  # a second time
        FramePacker(255, 190).pack("HEARTBEAT"),
        FramePacker(255, 190, signer(key=bytes(32))).pack("HEARTBEAT"),
        FramePacker(1, 1, signer(now=NOW - 61)).pack("HEARTBEAT"),
        good[:-1] + bytes([good[-1] ^ 1]),
    ):
        assert not parser.feed(bad)
    assert parser.refused == 5
    assert parser.feed(packer.pack("HEARTBEAT"))


def test_telemetry_radios_need_no_signature():
    assert FrameParser(signer()).feed(FramePacker(51, 68).pack("RADIO_STATUS"))


def test_stamps_grow_after_a_restart_with_a_clock_that_went_back(tmp_path):
    path = tmp_path / "stamp"
    before = SigningClock(path, lambda: NOW)
    last = [before.next() for _ in range(5)][-1]
    after = SigningClock(path, lambda: NOW - 3600.0)
    assert after.next() > last


def test_a_stamp_that_cannot_be_kept_is_said_once_and_frames_go_on(tmp_path, caplog):
    """As on a full disk: a driver that ends for it leaves the vehicle alone."""
    folder = tmp_path / "no folder"
    folder.write_text("")
    clock = SigningClock(
        folder / "key.stamp", wall_clock=iter(range(1_500_000_000, 1_600_000_000, 60)).__next__
    )
    stamps = [clock.next() for _ in range(3)]
    assert stamps == sorted(set(stamps))
    (said,) = caplog.messages
    assert "key.stamp cannot be written" in said


def test_a_damaged_stamp_counts_as_none(tmp_path):
    path = tmp_path / "stamp"
    path.write_bytes(b"\xff" * 10)
    assert SigningClock(path, lambda: NOW).next() == int((NOW - 1420070400) * 1e5)


def version_1(name: str, payload: bytes, extra: int | None = None) -> bytes:
    form = BY_NAME[name]
    body = struct.pack("<BBBBB", len(payload), 0, 1, 1, form.number) + payload
    crc = checksum(body + bytes([form.crc_extra if extra is None else extra]))
    return b"\xfe" + body + crc.to_bytes(2, "little")


def version_2(name: str, payload: bytes, flags: int = 0, extra: int | None = None) -> bytes:
    form = BY_NAME[name]
    body = struct.pack("<BBBBBB", len(payload), flags, 0, 0, 1, 1)
    body += form.number.to_bytes(3, "little") + payload
    crc = checksum(body + bytes([form.crc_extra if extra is None else extra]))
    return b"\xfd" + body + crc.to_bytes(2, "little") + bytes(13 * (flags & 1))


OTHER_DIALECTS = {
    "the same id with other fields": version_2("HEARTBEAT", bytes(9), extra=51),
    "the same in version 1": version_1("HEARTBEAT", bytes(9), extra=51),
    "version 1 with fields that only version 2 has": version_1("STATUSTEXT", bytes(54)),
    "version 1 that is too short": version_1("ATTITUDE", bytes(12)),
    "unknown flags": version_2("HEARTBEAT", bytes(9), flags=2),
    "unknown flags of a signed frame": version_2("HEARTBEAT", bytes(9), flags=0x81),
    "an id that no known dialect has": b"\xfd\x09\0\0\0\1\1\xff\xff\xff" + bytes(11),
}


@pytest.mark.parametrize("frame", OTHER_DIALECTS.values(), ids=OTHER_DIALECTS)
@pytest.mark.parametrize("size", [1, 7, 1000])
def test_frames_of_another_dialect_are_counted_and_hold_nothing_back(frame, size):
    good = FramePacker(1, 1).pack("HEARTBEAT", type=10, autopilot=3)
    parser = FrameParser()
    stream = (frame + good) * 3
    pieces = [stream[at : at + size] for at in range(0, len(stream), size)]
    found = [each for piece in pieces for each in parser.feed(piece)]
    assert [each["type"] for each in found] == [10, 10, 10]
    assert parser.damaged + parser.unknown >= 3


def test_a_frame_with_more_fields_than_known_is_read_as_far_as_it_is_known():
    """Dialects add fields at the end; the checksum does not change."""
    (frame,) = FrameParser().feed(version_2("ATTITUDE", struct.pack("<I6f", 7, *[0.5] * 6) + b"1"))
    assert frame["time_boot_ms"] == 7
    assert frame["yawspeed"] == 0.5


def test_signed_frames_are_read_where_no_key_is_set():
    (frame,) = FrameParser().feed(version_2("HEARTBEAT", bytes(9), flags=1))
    assert not frame.signed
