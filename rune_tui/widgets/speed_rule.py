"""The rule of widgetSetSpeed: its controls, their degrees of freedom, and its options."""

from __future__ import annotations

from typing import Final

from hub.gcm.body import ROBOT_DESCRIPTION, Freedom
from hub.gcm.navigation import ROBOT_STATE
from rune_tui.layout.rules import HandlerRule, NumberOption, Purpose, Section

ENABLE = "enable"
TURBO = "turbo"
TRANSLATE = "translate"
ROTATE = "rotate"
FREEDOMS: Final = {
    TRANSLATE: Freedom.SURGE,
    "strafe": Freedom.SWAY,
    "climb": Freedom.HEAVE,
    "roll": Freedom.ROLL,
    "pitch": Freedom.PITCH,
    ROTATE: Freedom.YAW,
}
"""The degree of freedom that each control moves."""
WHEELED: Final = frozenset({TRANSLATE, ROTATE})
"""Controls that every robot has; the robot itself limits their velocities."""

SPEED_RULE: Final = HandlerRule(
    purpose=Purpose.DRIVE,
    section=Section.DRIVE,
    says={
        "translate": "Drive {direction}",
        "rotate": "Turn {direction}",
        "climb": "Climb {direction}",
        "strafe": "Move {direction}",
        "pitch": "Pitch {direction}",
        "roll": "Roll {direction}",
        ENABLE: "Hold it: sticks drive",
        TURBO: "Hold it: faster",
    },
    meaning=(
        "Drives while held; positive `translate` is forward, positive `rotate` is "
        "counter-clockwise (to the left), positive `climb` is up, positive `strafe` is left, "
        "positive `pitch` is nose down, positive `roll` is right side down. A control that the "
        "robot's body does not have does nothing, and says so. Each control follows the newest "
        "of its keys, buttons and axes that is not neutral. Where `enable` is bound, axes count "
        "only while it is held; while `turbo` is held, all is faster. Where the terminal "
        "reports no releases, a press of a key drives a step, and its repeats drive on. Shift "
        "makes both finer. All is held down to the speed limit of `widgetSpeedLimit`."
    ),
    controls=("translate", "rotate", "climb", "strafe", "pitch", "roll", ENABLE, TURBO),
    options={
        "linear": NumberOption(
            default=0.5, least=0.0, most=10.0, unit="m/s", meaning="speed ahead at value 1"
        ),
        "angular": NumberOption(
            default=1.0, least=0.0, most=10.0, unit="rad/s", meaning="turn rate at value 1"
        ),
        "strafe": NumberOption(
            default=0.0,
            least=0.0,
            most=10.0,
            unit="m/s",
            meaning="speed to the side at value 1; 0: that of linear",
        ),
        "climb": NumberOption(
            default=0.3, least=0.0, most=10.0, unit="m/s", meaning="speed up and down at value 1"
        ),
        "tilt": NumberOption(
            default=0.5,
            least=0.0,
            most=10.0,
            unit="rad/s",
            meaning="rate of pitch and roll at value 1",
        ),
        "turbo_factor": NumberOption(
            default=2.0, least=1.0, most=10.0, meaning="how many times faster turbo is"
        ),
        "step": NumberOption(
            default=0.05,
            least=0.0,
            most=0.5,
            unit="m",
            meaning="way of a step; 0: a press drives at full speed for 0.6 s",
        ),
        "turn_step_deg": NumberOption(
            default=5.0, least=0.0, most=45.0, unit="deg", meaning="turn of a step; 0: as there"
        ),
        "fine": NumberOption(
            default=0.2,
            least=0.05,
            most=1.0,
            meaning="share of steps and speed of keys with Shift",
        ),
    },
    sends=("GCM_Velocity_Command",),
    uses=(ROBOT_STATE.name, ROBOT_DESCRIPTION.name),
    words={
        "translate": ("forward", "backward"),
        "rotate": ("left", "right"),
        "climb": ("up", "down"),
        "strafe": ("left", "right"),
        "pitch": ("nose down", "nose up"),
        "roll": ("right side down", "left side down"),
    },
    plane=("rotate", "translate"),
    held=True,
)
