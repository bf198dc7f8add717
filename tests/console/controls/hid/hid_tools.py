"""What hid-tools, of the makers of Linux's HID, reads out of the same descriptors and reports.

`pip install hid-tools==0.12`, then `python -m tests.console.controls.hid.hid_tools` writes
tests/golden/hid/ anew.
"""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

from tests.console.controls.hid.fixtures import NAMES, Device, device

GOLDEN = Path(__file__).parents[3] / "golden" / "hid"
_RANDOM_REPORTS = 24
_LONGEST = 32
"""Longest value that is compared [bits]."""


def what_hid_tools_says(each: Device) -> dict[str, Any]:
    """The fields of every input report, the values of the recorded reports and of random ones.

    Fields are [report id, first bit, size, count, usages, minimum, maximum, array, relative,
    nullable]; where reports have no ids, the id is 0. Values stand in the order of the fields;
    those of arrays and of fields that are padding or longer than a number are left out.
    """
    from hidtools.hid import ReportDescriptor

    described = ReportDescriptor.from_bytes(each.descriptor)
    fields, places = [], {}
    for report in described.input_reports.values():
        prefix = 8 if report.numbered else 0
        report_id = report.report_ID if report.numbered else 0
        places[report_id] = [
            field
            for field in report
            if not field.is_const and not field.is_array and field.size <= _LONGEST
        ]
        fields += [
            [
                report_id,
                field.start - prefix,
                field.size,
                field.count,
                field.usages if field.is_array else [field.usage],
                field.logical_min,
                field.logical_max,
                field.is_array,
                bool(field.type & 4),
                field.is_null,
            ]
            for field in report
            if not field.is_const
        ]
    generator = random.Random(each.name)
    reports = [*dict.fromkeys(each.reports)]
    for report in described.input_reports.values():
        start = bytes([report.report_ID]) if report.numbered else b""
        reports += [
            start + generator.randbytes(report.size - len(start)) for _ in range(_RANDOM_REPORTS)
        ]
    numbered = 0 not in places
    return {
        "fields": fields,
        "reports": [
            [
                report.hex(),
                [
                    field._get_value(list(report), 0)
                    for field in places[report[0] if numbered else 0]
                ],
            ]
            for report in reports
        ],
    }


def main() -> None:
    GOLDEN.mkdir(parents=True, exist_ok=True)
    for name in NAMES:
        said = what_hid_tools_says(device(name))
        lines = [f'"fields": {json.dumps(said["fields"], separators=(",", ":"))}']
        reports = ",\n".join(json.dumps(each, separators=(",", ":")) for each in said["reports"])
        lines.append(f'"reports": [\n{reports}\n]')
        (GOLDEN / f"{name}.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
