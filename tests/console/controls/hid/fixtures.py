"""Descriptors of real devices, and the reports that were recorded of some of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from rune_tui.controls.hid.device_controls import DeviceDecoder, PhysicalControl

FOLDER = Path(__file__).parents[3] / "data" / "hid"


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    name: str
    vid: int
    pid: int
    bus: int
    descriptor: bytes
    reports: tuple[bytes, ...]

    def decoder(self) -> DeviceDecoder:
        return DeviceDecoder(self.descriptor, vid=self.vid, pid=self.pid, bus=self.bus)


def device(name: str) -> Device:
    """The device of this file."""
    said = json.loads((FOLDER / f"{name}.json").read_text())
    return Device(
        name=name,
        vid=int(said["vid"], 16),
        pid=int(said["pid"], 16),
        bus=said["bus"],
        descriptor=bytes.fromhex(said["report_descriptor"]),
        reports=tuple(map(bytes.fromhex, said["reports"])),
    )


NAMES = tuple(sorted(path.stem for path in FOLDER.glob("*.json")))


def by_usage(decoder: DeviceDecoder, report: bytes) -> dict[str, int | None]:
    """The values that a report holds, by usage."""
    return {decoder.controls[which].usage: value for which, value in decoder.decode(report)}


def by_role(decoder: DeviceDecoder, report: bytes) -> dict[str, int | None]:
    """The values that a report holds, by role; without those that have none."""
    return {
        decoder.controls[which].role: value
        for which, value in decoder.decode(report)
        if decoder.controls[which].role
    }


def control(decoder: DeviceDecoder, usage: str) -> PhysicalControl:
    return next(each for each in decoder.controls if each.usage == usage)
