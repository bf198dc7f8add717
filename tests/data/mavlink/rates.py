"""Makes the extract of how recorded vehicles started and what they send.

    python -m tests.data.mavlink.rates FOLDER OUT.json

FOLDER has boot_KIND.json of each kind of vehicle. The extract has for each kind:

| key | content |
| --- | --- |
| heard | when the first heartbeat came, after the start [s] |
| unasked | rates of the messages that come by themselves [Hz] |
| all4 | the same after REQUEST_DATA_STREAM for all streams at 4 Hz |
| asked40 | answer and rate of each message that was asked for at 40 Hz [Hz] |

Messages that the vehicle sends at events, and those that Rune does not read, are left out.
"""

import json
import sys
from pathlib import Path
from typing import Any

from hub.robots.simulated_autopilot.reports import REPORTS

AT_EVENTS = ("HEARTBEAT", "HOME_POSITION", "GPS_GLOBAL_ORIGIN")
REGULAR_HZ = 0.5


def extract(boot: dict[str, Any]) -> dict[str, Any]:
    """The extract of one vehicle."""

    def regular(rates: dict[str, float]) -> dict[str, int]:
        return {
            name: round(rate)
            for name, rate in rates.items()
            if rate > REGULAR_HZ and name in REPORTS and name not in AT_EVENTS
        }

    asked = {
        name: [answers[0][0], round(rate)]
        for name, (answers, rate) in boot["set_interval_40hz"].items()
        if name in REPORTS or answers[0][0] == "DENIED"
    }
    return {
        "heard": round(boot["first_heartbeat_s"], 2),
        "unasked": regular(boot["rates_hb"]),
        "all4": regular(boot["rates_all4"]),
        "asked40": asked,
    }


if __name__ == "__main__":
    folder, out = Path(sys.argv[1]), Path(sys.argv[2])
    made = {
        kind: extract(json.loads((folder / f"boot_{kind}.json").read_text()))
        for kind in ("rover", "sub", "blimp")
    }
    out.write_text(json.dumps(made, indent=1) + "\n")
