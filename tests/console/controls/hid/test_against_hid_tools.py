"""Descriptors and reports of real devices mean what hid-tools says they mean."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rune_tui.controls.hid.channels import find_channels
from rune_tui.controls.hid.descriptor import ReportDescriptor, parse
from rune_tui.controls.hid.device_controls import DeviceDecoder
from rune_tui.layout.spec import ControlKind
from tests.console.controls.hid.fixtures import NAMES, device
from tests.console.controls.hid.hid_tools import GOLDEN, what_hid_tools_says
from tests.support.cases import for_each


def golden(name: str) -> dict[str, Any]:
    said: dict[str, Any] = json.loads((GOLDEN / f"{name}.json").read_text())
    return said


def fields(parsed: ReportDescriptor) -> list[list[Any]]:
    """As hid-tools has them: every element of its own, but for arrays."""
    found = []
    for each in parsed.fields:
        usages = list(each.usages_of_elements())
        ends = [each.minimum, each.maximum, each.array, each.relative, each.nullable]
        if each.array:
            found.append([each.report_id, each.bit, each.size, each.count, usages, *ends])
        else:
            found += [
                [each.report_id, each.bit + place * each.size, each.size, 1, [usage], *ends]
                for place, usage in enumerate(usages)
            ]
    return found


@for_each("name", NAMES)
def test_every_field_is_where_hid_tools_finds_it(name: str) -> None:
    assert fields(parse(device(name).descriptor)) == golden(name)["fields"]


@for_each("name", NAMES)
def test_every_control_has_the_value_that_hid_tools_reads(name: str) -> None:
    descriptor, said = device(name).descriptor, golden(name)
    parsed = parse(descriptor)
    channels = find_channels(parsed)
    decoder = DeviceDecoder(descriptor, vid=0, pid=0)
    compared = 0
    for text, values in said["reports"]:
        report = bytes.fromhex(text)
        decoded = dict(decoder.decode(report))
        report_id = report[0] if parsed.numbered else 0
        places = [
            (each[0], each[1])
            for each in said["fields"]
            if each[0] == report_id and not each[7] and each[2] <= 32
        ]
        read = dict(zip(places, values, strict=True))
        held = [n for n, each in enumerate(channels) if each.field.report_id == report_id]
        assert sorted(decoded) == held
        for which in held:
            channel = channels[which]
            value: int | None = read[report_id, channel.bit]
            limited = channel.kind is ControlKind.HAT or channel.field.nullable
            if limited and not channel.minimum <= value <= channel.maximum:
                value = None
            assert decoded[which] == value, channel
            compared += 1
    assert compared or not decoder.joystick
    assert decoder.unread == 0


def test_hid_tools_still_says_the_same() -> None:
    pytest.importorskip("hidtools", reason="hid-tools is not installed")
    for name in NAMES:
        assert json.loads(json.dumps(what_hid_tools_says(device(name)))) == golden(name)
