"""visualizeAttitude: an artificial horizon."""

from __future__ import annotations

import math
from typing import ClassVar

from hub.gcm.imu import IMU, Imu
from hub.values import dataclass
from rune_tui.layout.rules import NumberOption, VisualizerRule
from rune_tui.model.robot_state import RobotState
from rune_tui.model.theme import Theme
from rune_tui.raster.canvas import Canvas
from rune_tui.raster.shapes import drawing
from rune_tui.raster.urgency import Urgency
from rune_tui.visualizers.parts.message_gauge import MessageGauge
from rune_tui.visualizers.parts.rows import fitting_form

_DEFAULT_SPAN_DEG = 60.0
_FAR = 4.0


@dataclass(frozen=True, slots=True)
class _Tilt:
    """Roll and pitch in whole degrees; None if unknown.

    Attributes:
        right: Right side down [deg].
        up: Nose up [deg].
    """

    right: int | None
    up: int | None


class Attitude(MessageGauge[Imu, _Tilt]):
    """The ground below a horizon, as seen from the robot, and the angles in words."""

    rule: ClassVar = VisualizerRule(
        meaning="roll and pitch, as an artificial horizon and in words",
        message=IMU.name,
        measured=True,
        option=NumberOption(
            default=0.0,
            least=0.0,
            most=180.0,
            unit="deg",
            meaning="pitch from the lower edge to the upper; 0 means 60 deg",
        ),
    )
    urgency: ClassVar[Urgency] = Urgency.DRIVE
    definition = IMU
    subject = "attitude"

    def reading(self, value: Imu, _robot: RobotState) -> _Tilt:
        """Right side down and nose up; positive pitch in the message is nose down."""
        roll, pitch, _ = value.roll_pitch_yaw
        return _Tilt(_degrees(roll), _degrees(-pitch))

    def show(self, canvas: Canvas, reading: _Tilt, theme: Theme) -> None:
        """The horizon above the words; in one row only the words."""
        last = canvas.rows - 1
        if last and reading.right is not None and reading.up is not None:
            self._show_horizon(canvas, reading.right, reading.up, theme)
        words = _words(reading, canvas.width)
        canvas.text((canvas.width - len(words)) // 2, last, words, theme.ink)

    def _show_horizon(self, canvas: Canvas, right: int, up: int, theme: Theme) -> None:
        height = 2 * (canvas.rows - 1)
        scale = height / (self.option or _DEFAULT_SPAN_DEG)
        roll = math.radians(right)
        # With the right side down, the horizon's right end is higher.
        along = (math.cos(roll), -math.sin(roll))
        down = (math.sin(roll), math.cos(roll))
        x, y = canvas.width / 2.0, height / 2.0
        # A farther horizon is outside the canvas.
        far = canvas.width + height
        shift = max(-far, min(far, up * scale))
        x, y = x + down[0] * shift, y + down[1] * shift
        reach = _FAR * (canvas.width + height + abs(shift))
        ends = [(x + side * reach * along[0], y + side * reach * along[1]) for side in (-1.0, 1.0)]
        below = [(a + reach * down[0], b + reach * down[1]) for a, b in reversed(ends)]
        mark = fitting_form(canvas.width // 2, "─── ┼ ───", "──┼──", "┼")
        column, row = (canvas.width - len(mark)) // 2, (canvas.rows - 1) // 2
        with drawing(canvas) as pen:
            pen.polygon([*ends, *below], theme.faint)
            pen.line(ends, theme.ink)
            pen.rectangle(0, height, canvas.width, canvas.height, theme.panel)
            pen.rectangle(column, 2 * row, column + len(mark), 2 * row + 2, theme.panel)
        canvas.text(column, row, mark, theme.ink)


def _degrees(angle: float) -> int | None:
    """An angle [rad] in whole degrees, -180 to 180; None if unknown."""
    if not math.isfinite(angle):
        return None
    return round(math.degrees(math.remainder(angle, 2.0 * math.pi)))


def _words(tilt: _Tilt, columns: int) -> str:
    roll = _side_words(tilt.right, "right", "left")
    pitch = _side_words(tilt.up, "up", "down")
    return fitting_form(
        columns,
        f"roll {roll}, pitch {pitch}",
        f"{roll}, {pitch}",
        f"{roll} {pitch}".replace("right", "R").replace("left", "L"),
        roll,
    )


def _side_words(angle: int | None, positive: str, negative: str) -> str:
    if angle is None:
        return "?"
    side = f" {positive if angle > 0 else negative}" if angle else ""
    return f"{abs(angle)}°{side}"
