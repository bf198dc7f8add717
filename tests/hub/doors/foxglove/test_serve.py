"""`rune-hub serve foxglove`: what it refuses, the layouts it writes, and the facts it tells."""

from __future__ import annotations

import json
import math
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from websockets import Subprotocol
from websockets.sync.client import connect

from hub.command_line import ExitCode
from hub.doors.foxglove.layout import LAYOUT, layout_of
from hub.doors.foxglove.tool_server import ServerSettings, ToolServer
from hub.doors.panels.parameters import parameters_of
from hub.doors.panels.wishes import CMD_VEL
from hub.errors import DoorError
from hub.gcm.body import CameraBody, Freedom, Motion, RangeGroup, RangeKind, RobotBody
from tests.support.command_line import rune_hub
from tests.support.foxglove_panel import SUBPROTOCOL
from tests.support.waiting import until

BODY = RobotBody(
    name="rover", kind="ros", radius=0.3,
    cameras=(CameraBody(name="front left", horizontal_fov=1.0),),
    ranges=(RangeGroup(name="laser", kind=RangeKind.LASER, farthest=8.0),),
    motions=(Motion(freedom=Freedom.SURGE, limit=1.0, acceleration=1.0),
             Motion(freedom=Freedom.YAW, limit=2.0, acceleration=1.0)),
)  # fmt: skip


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--drive", "--host", "0.0.0.0"], "no login"),
        (["--drive", "--host", "robot.example"], "`ssh -L 8765:127.0.0.1:8765 robot`"),
        (["--drive", "--host", "::", "--tls-cert", "a.pem", "--tls-key", "a.key"], "no login"),
        (["--tls-cert", "a.pem"], "both"),
    ],
)
def test_other_machines_do_not_drive(options: list[str], words: str) -> None:
    done = rune_hub("serve", "foxglove", *options)
    assert done.returncode == ExitCode.USAGE
    assert words in done.stderr


def test_without_its_library_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [each for each in sys.modules if each.startswith("hub.doors.foxglove.")]:
        monkeypatch.delitem(sys.modules, name)
    for name in [each for each in sys.modules if each.partition(".")[0] == "websockets"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "websockets", None)
    done = rune_hub("serve", "foxglove")
    assert done.returncode == ExitCode.USAGE
    assert "robot-user-nexus[tools]" in done.stderr


def test_a_busy_port_and_a_wrong_certificate_are_said(tmp_path: Path) -> None:
    settings = ServerSettings(name="one")
    first = ToolServer(settings, lambda: None)
    try:
        port = first.port
        with pytest.raises(
            DoorError, match=f"{port}: another program listens there; give .*--port"
        ):
            ToolServer(ServerSettings(name="two", port=port), lambda: None)
    finally:
        first.close()
    none = tmp_path / "none.pem"
    none.write_text("none")
    for certificate in (none, tmp_path / "missing.pem"):
        with pytest.raises(DoorError, match="TLS file"):
            ToolServer(ServerSettings(name="x", certificate=certificate, key=none), lambda: None)


def test_a_program_with_many_panels_leaves_room_for_others() -> None:
    with (
        closing(ToolServer(ServerSettings(name="one", drive=True), lambda: None)) as server,
        connect(server.address, subprotocols=[Subprotocol(SUBPROTOCOL)]) as greedy,
        connect(server.address, subprotocols=[Subprotocol(SUBPROTOCOL)]) as other,
    ):
        for program, count in ((greedy, 100), (other, 1)):
            channels = [
                {"id": number, "topic": CMD_VEL, "encoding": "json", "schemaName": "Twist"}
                for number in range(count)
            ]
            program.send(json.dumps({"op": "advertise", "channels": channels}))
            until(lambda: server.refused > 90, 10.0)
        until(lambda: len({program for program, _ in server.take_wishes().panels}) == 2, 10.0)


def test_a_layout_has_the_topics_and_speeds_of_the_robot() -> None:
    panels: dict[str, Any] = json.loads(layout_of(BODY))["configById"]
    assert panels["Image!rune"]["imageMode"]["imageTopic"] == (
        "/camera/front_left/image/compressed"
    )
    assert "/scan/laser" in panels["3D!rune"]["topics"]
    assert "/scan" not in panels["3D!rune"]["topics"]
    teleop = panels["Teleop!rune"]
    assert (teleop["topic"], teleop["publishRate"]) == (CMD_VEL, 10)
    assert (teleop["upButton"]["value"], teleop["rightButton"]["value"]) == (0.5, -1.0)


def _placed(layout: Any) -> set[str]:
    if isinstance(layout, str):
        return {layout}
    return _placed(layout["first"]) | _placed(layout["second"])


def test_all_panels_of_the_layout_have_a_place() -> None:
    layout = json.loads(Path(LAYOUT).read_text())
    assert _placed(layout["layout"]) == layout["configById"].keys()


def test_parameters_leave_out_what_is_not_known() -> None:
    facts = parameters_of(BODY, drive=False)
    assert facts["limit.yaw_rad_per_s"] == 2.0
    assert facts["door.drive"] is False
    assert "robot.mass_kg" not in facts
    assert not any(isinstance(each, float) and math.isnan(each) for each in facts.values())
