"""A recording of a console, made by its own parts on a clock of the test's own."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

from hub.gcm.navigation import ROBOT_STATE
from rune_tui.files.console_recording import ConsoleRecording
from rune_tui.files.frame_log import DrawnFrame, FrameLog
from rune_tui.files.recorder import record_layout
from rune_tui.model.console_state import ConsoleState
from rune_tui.model.own_records import TerminalRecord
from rune_tui.model.robot_state import LinkPhase, LinkState, Received, RobotState
from rune_tui.startup.opening import open_layout
from rune_tui.view import View
from tests.support.messages import robot_state

LAYOUT = """<rune>
  <robot name="blimp" hub="127.0.0.1">
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/><capability name="PRO_MAP"/>
  </robot>
  <view xsize="60" ysize="40">
    <viewport name="map" robot="blimp" xpos="0" ypos="0" xsize="30" ysize="40">
      <visualizer function="visualizeMapData"/>
      <widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget>
    </viewport>
    <viewport name="speed" robot="blimp" xpos="30" ypos="0" xsize="30" ysize="30">
      <visualizer function="visualizePlot" message="GCM_RobotState">
        <option name="field" value="linear"/><option name="seconds" value="20"/>
      </visualizer>
    </viewport>
    <viewport name="status" robot="blimp" xpos="30" ypos="38" xsize="30" ysize="2">
      <visualizer function="visualizeStatus"/>
    </viewport>
  </view>
</rune>
"""
COLUMNS, ROWS = 60, 20
HERTZ = 10


def logged_session(
    folder: Path,
    seconds: float,
    *,
    begin: float = 1000.0,
    hertz: int = HERTZ,
    silent: float = math.inf,
    connects: float = 0.0,
) -> Path:
    """Record a robot that drives in circles for a time, and is `silent` from then on [s].

    The console `connects` after a time [s].
    """
    layout_file, path = folder / "layout.xml", folder / "session.mcap"
    layout_file.write_text(LAYOUT)
    layout = open_layout(layout_file)
    now = begin
    recording = ConsoleRecording(path, {}, clock=lambda: now)
    log = FrameLog(recording, {"blimp": "blimp"}, TerminalRecord())
    record_layout(recording, layout, set())
    view = View(layout, spent=lambda: 0.0)
    view.resize(COLUMNS, ROWS)
    link = LinkState(phase=LinkPhase.CONNECTED, since=begin, endpoint="here")
    waiting = LinkState(phase=LinkPhase.CONNECTING, since=begin, endpoint="here")
    state = ConsoleState.at_start(layout, now, "jane")
    for number in range(1, round(seconds * hertz) + 1):
        now = begin + number / hertz
        angle = number / 1.5 / hertz
        value = robot_state(
            x=2.0 * math.cos(angle), y=2.0 * math.sin(angle), linear=math.sin(angle * 3.0)
        )
        connected = now - begin >= connects
        if connected and now - begin <= silent:
            recording.add("blimp", ROBOT_STATE, value, now - 0.02, number)
            received = Received(value=value, measured=now - 0.02, number=number)
        robot = RobotState(name="blimp", link=waiting)
        if connected:
            robot = RobotState(name="blimp", link=link, messages={ROBOT_STATE.name: received})
        state = dataclasses.replace(
            state, now=now, clock=f"12:00:{number // hertz % 60:02d}", robots={"blimp": robot}
        )
        if number % 70 == 0:
            state = dataclasses.replace(state, zooms={"map": 1.0 + number % 3})
        shown = dataclasses.replace(
            state, places=view.places, attention=view.attention, rows=view.rows
        )
        cells = view.render(shown)
        drawn = DrawnFrame(
            columns=COLUMNS, rows=ROWS, arranged=view.arranged, cells=cells, slow=view.times.slow
        )
        log.frame(shown, drawn)
    recording.close()
    return path
