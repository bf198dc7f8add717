"""The answers of a simulated autopilot to questions for parameters, streams and missions."""

from __future__ import annotations

import math
from typing import Final

from hub.robots.mavlink.wire.frames import MavlinkFrame
from hub.robots.simulated_autopilot.condition import VehicleCondition
from hub.robots.simulated_autopilot.parameters import ParameterStore
from hub.robots.simulated_autopilot.reports import REPORTS, stream_messages
from hub.robots.simulated_autopilot.station_link import StationLink

_NO_INDEX: Final = 65_535
_WAYPOINT: Final = 16
_MOST_ITEMS: Final = 65_535
_FASTEST: Final = 50
"""Highest rate of a stream [Hz]."""


def send_parameter(
    parameters: ParameterStore, link: StationLink, name: str, index: int = _NO_INDEX
) -> None:
    """Tell a parameter; an unknown one gets no answer."""
    if name in parameters:
        link.send(
            "PARAM_VALUE",
            param_id=name,
            param_value=parameters[name],
            param_type=parameters.type(name),
            param_count=len(parameters.names),
            param_index=index,
        )


def answer_question(vehicle: VehicleCondition, link: StationLink, frame: MavlinkFrame) -> None:
    """Answer a question, which may be for a stream; another message changes nothing."""
    fields, parameters = frame.fields, vehicle.parameters
    sender = {"target_system": frame.system, "target_component": frame.component}
    match frame.name:
        case "PARAM_REQUEST_READ":
            index = fields["param_index"]
            if 0 <= index < len(parameters.names):
                send_parameter(parameters, link, parameters.names[index], index)
            elif index < 0:
                send_parameter(parameters, link, fields["param_id"])
        case "PARAM_REQUEST_LIST":
            link.parameters.clear()
            link.parameters.extend((name, index) for index, name in enumerate(parameters.names))
        case "REQUEST_DATA_STREAM" if not fields["req_stream_id"]:
            rate = fields["req_message_rate"] if fields["start_stop"] else 0
            for name in stream_messages(vehicle.kind.name):
                link.set_rate(name, 1.0 / min(rate, _FASTEST) if rate else math.inf)
        case "MISSION_REQUEST_LIST":
            kind = fields["mission_type"]
            count = 0 if kind else max(0, min(_MOST_ITEMS, int(parameters["MIS_TOTAL"])))
            link.send("MISSION_COUNT", count=count, mission_type=kind, **sender)
        case "MISSION_REQUEST_INT" if fields["seq"] == 0 and not fields["mission_type"]:
            home = REPORTS["HOME_POSITION"](vehicle) or {"latitude": 0, "longitude": 0}
            place = {"x": home["latitude"], "y": home["longitude"]}
            link.send("MISSION_ITEM_INT", command=_WAYPOINT, autocontinue=1, **place, **sender)
        case _:
            pass
