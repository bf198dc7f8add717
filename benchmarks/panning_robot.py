"""A robot whose camera pans over a detailed scene and writes the time into each picture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from benchmarks.camera_scenes import panning
from benchmarks.stand_in_robot import StandInRobot, coded
from hub.gcm import vision
from tests.support.messages import camera_state

Pixels = npt.NDArray[np.uint8]

COLUMNS, ROWS = 160, 48
PICTURE = (160, 96)
PANE = (COLUMNS, 2 * ROWS - 2)
"""Width and height of what the picture is stretched to [pixels]."""
BITS, BLOCK = 16, 10
LAYOUT = f"""<rune>
  <robot name="r" hub="{{hub}}">
    <capability name="VIS_VID" interval_ms="{{interval}}"/><capability name="VIS_PTZ"/>
    <capability name="NAV_STATE"/><capability name="NAV_MOVE"/>
  </robot>
  <view xsize="{COLUMNS}" ysize="{2 * ROWS}">
    <viewport name="camera" xpos="0" ypos="0" xsize="{COLUMNS}" ysize="{PANE[1]}">
      <visualizer function="visualizeCameraImage"><option name="fit" value="stretch"/></visualizer>
      <widget handler="widgetSetSpeed"><event key="w" control="translate"/></widget>
    </viewport>
    <viewport name="status" xpos="0" ypos="{PANE[1]}" xsize="{COLUMNS}" ysize="2">
      <visualizer function="visualizeStatus"/>
    </viewport>
  </view>
</rune>"""


def stamped(pixels: Pixels, now: float) -> Pixels:
    """The picture with the time in milliseconds as black and white squares, above and below."""
    code = code_of(now)
    for bit in range(BITS):
        shade = 255 if code >> bit & 1 else 0
        for edge in (pixels[:BLOCK], pixels[-BLOCK:]):
            edge[:, bit * BLOCK : (bit + 1) * BLOCK] = shade
    return pixels


def code_of(now: float) -> int:
    """What stands in a picture for the time [ms]."""
    return int(now * 1000) % (1 << BITS)


def code_in(pixels: Pixels) -> int | None:
    """What stands in the picture on a screen; None while it is not one whole picture."""
    columns = [round(PANE[0] / PICTURE[0] * BLOCK * (bit + 0.5)) for bit in range(BITS)]
    shades = [pixels[row, columns].mean(-1) for row in (BLOCK // 2, PANE[1] - BLOCK // 2)]
    codes = {sum(1 << bit for bit, shade in enumerate(row) if shade > 127) for row in shades}
    clear = all(((row < 60) | (row > 195)).all() for row in shades)
    if len(codes) != 1 or not clear:
        return None
    return codes.pop()


class PanningCamera:
    """Takes a picture after the other, there and back, with the time in each."""

    def __init__(self) -> None:
        there = [cells.pixels[..., :3] for cells in panning()]
        self._frames = [*there, *there[-2:0:-1]]

    def taken(self, number: int, now: float) -> Pixels:
        """The picture of this number, shape (96, 160, 3)."""
        return stamped(self._frames[number % len(self._frames)].copy(), now)

    def __call__(self, number: int, now: float) -> vision.Image:
        return coded(self.taken(number, now), camera_state(), quality=100)


def panning_robots() -> list[StandInRobot]:
    """Start it."""
    return [StandInRobot(PanningCamera())]
