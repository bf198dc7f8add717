"""Joysticks of layouts: what devices are meant, what events mean by their controls."""

from __future__ import annotations

from pathlib import Path

import pytest

from rune_tui.layout.actions import Action, actions_of
from rune_tui.layout.spec import ControlKind, ControlSpec, EventSpec, JoystickSpec, LayoutSpec
from rune_tui.startup.opening import open_layout

PAGE = (Path(__file__).parents[3] / "docs" / "layout-reference.md").read_text()
EXAMPLES = [text.split("```")[0] for text in PAGE.split("\n```xml\n")[1:]]
STICK = next(text for text in EXAMPLES if text.startswith("<joystick"))
DRIVEN = next(text for text in EXAMPLES if '<joystick name="pad"/>' in text)


def load(folder: Path, widgets: str, joysticks: str = '<joystick name="pad"/>') -> LayoutSpec:
    path = folder / "layout.xml"
    path.write_text(
        f"""<rune><robot name="magellan"><capability name="NAV_MOVE"/><capability name="VIS_PTZ"/>
        </robot>{joysticks}<view xsize="80" ysize="48">
        <viewport name="camera" xpos="0" ypos="0" xsize="80" ysize="48">
        <visualizer function="visualizeLabel" text="Rune"/>{widgets}</viewport></view></rune>"""
    )
    return open_layout(path)


def events(layout: LayoutSpec) -> list[tuple[str, str, float]]:
    return [
        (event.name, event.control, event.value)
        for viewport in layout.view.viewports
        for widget in viewport.widgets
        for event in widget.events
    ]


def test_the_device_and_the_controls_of_the_page_arrive(tmp_path: Path):
    stop = '<widget handler="widgetStop"><event joystick="stick" button="trigger"/></widget>'
    (joystick,) = load(tmp_path, stop, STICK).joysticks
    assert (joystick.name, joystick.vid, joystick.pid) == ("stick", 0x046D, 0xC215)
    assert (joystick.serial, joystick.device) == ("", "")
    assert joystick.controls == (
        ControlSpec(name="forward", kind=ControlKind.AXIS, usage="y", deadzone=0.1, expo=0.3),
        ControlSpec(name="turn", kind=ControlKind.AXIS, role="twist", calibrate=True),
        ControlSpec(name="trigger", kind=ControlKind.BUTTON, index=0),
        ControlSpec(name="pov", kind=ControlKind.HAT, usage="hat switch", bindings=(0, 2, 4, 6)),
    )


def test_the_rest_of_what_a_layout_may_say_arrives(tmp_path: Path):
    joysticks = """<joystick name="wheel" vid="0X046D" serial="A 1" device="Logi*">
      <control name="brake" type="axis" index="3" min="-5" max="+9" invert="true"/>
      <control name="track" type="ball" usage="wheel#2"/></joystick><joystick name="unused"/>"""
    wheel, unused = load(
        tmp_path,
        '<widget handler="widgetAdjustZoom"><event joystick="wheel" ball="track"/></widget>',
        joysticks,
    ).joysticks
    assert (wheel.vid, wheel.pid, wheel.serial, wheel.device) == (0x046D, None, "A 1", "Logi*")
    brake, track = wheel.controls
    assert (brake.index, brake.minimum, brake.maximum, brake.invert) == (3, -5, 9, True)
    assert (track.kind, track.usage) == (ControlKind.BALL, "wheel#2")
    assert unused == JoystickSpec(name="unused")


def test_roles_that_events_name_are_controls_once_each(tmp_path: Path):
    layout = load(
        tmp_path,
        """<widget handler="widgetSetSpeed">
        <event joystick="pad" axis="lefty" control="translate"/>
        <event joystick="pad" button="lefty" control="turbo"/>
        <event joystick="pad" axis="mine" control="rotate"/></widget>
        <widget handler="widgetStop"><event joystick="pad" button="b"/></widget>""",
        '<joystick name="pad"><control name="mine" type="axis" usage="rz"/></joystick>',
    )
    assert layout.joysticks[0].controls == (
        ControlSpec(name="mine", kind=ControlKind.AXIS, usage="rz"),
        ControlSpec(name="lefty", kind=ControlKind.AXIS, role="lefty"),
        ControlSpec(name="b", kind=ControlKind.BUTTON, role="b"),
    )


def test_a_control_of_the_layout_goes_before_the_role_of_its_name(tmp_path: Path):
    layout = load(
        tmp_path,
        '<widget handler="widgetStop"><event joystick="pad" button="a"/></widget>',
        '<joystick name="pad"><control name="a" type="axis" usage="z"/></joystick>',
    )
    assert layout.joysticks[0].controls == (
        ControlSpec(name="a", kind=ControlKind.AXIS, usage="z"),
    )
    assert events(layout) == [("joystick pad a pressed", "", 1.0)]


def test_events_have_the_names_and_kinds_of_their_inputs(tmp_path: Path):
    layout = load(
        tmp_path,
        """<widget handler="widgetAdjustZoom">
        <event joystick="pad" axis="righty" value="0.5"/>
        <event joystick="pad" button="righttrigger"/>
        <event joystick="pad" button="a" when="released"/>
        <event joystick="pad" hat="dpad" direction="down" value="-1"/></widget>""",
    )
    (widget,) = layout.view.viewports[0].widgets
    lines = [event.line for event in widget.events]
    assert widget.events == (
        EventSpec(
            name="joystick pad righty", control="", value=0.5, line=lines[0], kind=ControlKind.AXIS
        ),
        EventSpec(
            name="joystick pad righttrigger pressed",
            control="",
            value=1.0,
            line=lines[1],
            kind=ControlKind.BUTTON,
        ),
        EventSpec(
            name="joystick pad a",
            control="",
            value=1.0,
            line=lines[2],
            released=True,
            kind=ControlKind.BUTTON,
        ),
        EventSpec(
            name="joystick pad dpad down",
            control="",
            value=-1.0,
            line=lines[3],
            kind=ControlKind.HAT,
        ),
    )


@pytest.mark.parametrize(
    ("handler", "across", "along"),
    [("widgetAdjustPanTilt", "pan", "tilt"), ("widgetSetSpeed", "rotate", "translate")],
)
def test_a_whole_hat_is_four_events(tmp_path: Path, handler: str, across: str, along: str):
    layout = load(
        tmp_path,
        f'<widget handler="{handler}"><event joystick="pad" hat="dpad" value="0.5"/></widget>',
    )
    assert sorted(events(layout)) == [
        ("joystick pad dpad down", along, -0.5),
        ("joystick pad dpad left", across, 0.5),
        ("joystick pad dpad right", across, -0.5),
        ("joystick pad dpad up", along, 0.5),
    ]


def test_parts_and_variables_bring_joysticks_controls_and_events(tmp_path: Path):
    (tmp_path / "pad.xml").write_text(
        """<part><variable name="vid" value="0001"/>
        <joystick name="${stick}" vid="${vid}"><include file="controls.xml"/></joystick></part>"""
    )
    (tmp_path / "controls.xml").write_text(
        """<part><control name="forward" type="axis" role="${role}" deadzone="${zone}"/></part>"""
    )
    (tmp_path / "drive.xml").write_text(
        """<part><event joystick="${stick}" axis="forward" control="translate"/></part>"""
    )
    layout = load(
        tmp_path,
        '<widget handler="widgetSetSpeed"><include file="drive.xml"/></widget>',
        """<variable name="stick" value="mine"/><variable name="role" value="lefty"/>
        <variable name="zone" value="0.2"/>
        <include file="pad.xml"><variable name="vid" value="054c"/></include>""",
    )
    (joystick,) = layout.joysticks
    assert (joystick.name, joystick.vid) == ("mine", 0x054C)
    assert joystick.controls == (
        ControlSpec(name="forward", kind=ControlKind.AXIS, role="lefty", deadzone=0.2),
    )
    assert events(layout) == [("joystick mine forward", "translate", 1.0)]


def test_the_whole_example_of_the_page_loads(tmp_path: Path):
    path = tmp_path / "example.xml"
    path.write_text(DRIVEN)
    layout = open_layout(path)
    assert {event.name for event in layout.view.viewports[0].widgets[1].events} == {
        "joystick pad b"
    }


def said(layout: LayoutSpec) -> dict[str, Action]:
    return {inputs: action for action in actions_of(layout) for inputs in action.inputs}


def test_the_help_says_what_to_do_with_sticks_and_what_comes_of_it(tmp_path: Path):
    path = tmp_path / "example.xml"
    path.write_text(DRIVEN)
    actions = said(open_layout(path))
    ends = {
        "pad left stick up": "Drive forward",
        "pad left stick down": "Drive backward",
        "pad left stick right": "Turn right",
        "pad left stick left": "Turn left",
        "pad left shoulder": "Hold it: sticks drive",
        "pad right trigger": "Hold it: faster",
        "pad B": "Stop",
        "pad hat up": "Look up",
        "pad hat left": "Look left",
        "pad right stick pressed": "Look straight ahead, wide",
    }
    for inputs, end in ends.items():
        assert actions[inputs].words == end, actions[inputs]


@pytest.mark.parametrize(
    ("control", "event", "words"),
    [
        (
            'type="axis" role="twist"',
            "axis",
            ["stick one clockwise", "stick one counter-clockwise"],
        ),
        ('type="axis" usage="y"', "axis", ["stick one up", "stick one down"]),
        ('type="axis" usage="y" invert="true"', "axis", ["stick one down", "stick one up"]),
        ('type="axis" usage="dial"', "axis", ["stick one one way", "stick one the other way"]),
        ('type="axis" role="throttle"', "axis", ["stick one"]),
        ('type="axis" role="throttle"', "button", ["stick one"]),
        ('type="axis" usage="x"', "button", ["stick one right or left"]),
        ('type="button" index="0"', "button", ["stick one"]),
        ('type="button" role="lefttrigger"', "button", ["stick one"]),
        ('type="ball" usage="wheel"', "ball", ["stick one"]),
    ],
)
def test_controls_of_the_layout_are_called_by_their_names(
    tmp_path: Path, control: str, event: str, words: list[str]
):
    layout = load(
        tmp_path,
        f'<widget handler="widgetAdjustZoom"><event joystick="stick" {event}="one"/></widget>',
        f'<joystick name="stick"><control name="one" {control}/></joystick>',
    )
    assert list(said(layout)) == words
    assert all(action.at_once is (event == "button") for action in actions_of(layout))


def test_a_button_that_is_let_go_is_said_to_go_up(tmp_path: Path):
    layout = load(
        tmp_path,
        """<widget handler="widgetStop">
        <event joystick="pad" button="a" when="released"/></widget>""",
    )
    assert list(said(layout)) == ["pad A goes up"]
