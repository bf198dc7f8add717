"""The stale stick, many times each: hands, console, link, robot and wheels on one clock.

`tests/system/stale_stick/test_stale_stick.py` does the same to real processes, fewer times.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from rune_tui.layout.spec import LayoutSpec
from rune_tui.startup.opening import open_layout
from tests.console.controls.hands_to_wheels import Console, World
from tests.console.controls.pure_agent import PadAgent
from tests.support.repetitions import repetitions

TIMES = repetitions(12, 1000)
STOPPED_S = 0.35
REST_S = 0.7
INSISTED_S = 0.2
INSISTED_WITH_GAPS_S = 1.5
_LAYOUT = """<rune>
  <robot name="magellan"><capability name="NAV_MOVE"/></robot>
  <joystick name="pad"/>
  <view xsize="9" ysize="9">
    <viewport name="drive" robot="magellan" xpos="0" ypos="0" xsize="9" ysize="9">
      <widget handler="widgetSetSpeed">
        <event key="w" control="translate"/>
        <event key="s" control="translate" value="-1"/>
        <event joystick="pad" axis="lefty" control="translate"/>
        <event joystick="pad" axis="leftx" control="rotate" value="-1"/>
      </widget>
      <widget handler="widgetStop"><event key="space"/></widget>
      <widget handler="widgetReleaseControl"><event key="c"/></widget>
    </viewport>
  </view>
</rune>
"""
Deed = Callable[[World], object]


def nothing(world: World) -> None:
    """All is as before, but for what the robot makes of it."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """As in the system's tests.

    `keys`: whether the operator presses keys; `elsewhere`: whether the pad is, with `rune pad`.
    """

    name: str
    strike: Deed
    mend: Deed = nothing
    press: Deed = World.push
    before: Deed = nothing
    keys: bool = False
    elsewhere: bool = False


def press(key: str) -> Deed:
    """A key of the operator's."""
    return lambda world: world.console.key(key, world.now + world.ahead)


def fall_asleep(world: World) -> None:
    world.console.runs = False


def with_gaps(strike: Deed) -> Deed:
    """From then on, repeats of the key that is held are missing now and then."""

    def struck(world: World) -> None:
        world.gaps = True
        strike(world)

    return struck


def awake(world: World) -> None:
    """It goes on."""
    world.console.runs = True


def clock_leaps(world: World) -> None:
    """The operator's monotonic clock goes on from another time, as a machine's that is moved."""
    world.ahead += world.chance.uniform(0.4, 1e6)


def rest(console: Console, world: World, *, resting: bool) -> None:
    console.resting = resting
    if resting:
        console.let_go(world.now + world.ahead)


def cut(world: World) -> None:
    world.console.link.cut = True


def heal(world: World) -> None:
    world.console.link.cut = False


def end(world: World) -> None:
    world.console.runs = False
    world.consoles.remove(world.console)
    world.robot.arbiter.disconnected(world.console.link.number, world.now)


def start_again(world: World) -> None:
    world.console = world.start()
    world.plug()


def lose_hub(world: World) -> None:
    world.console.link.gone = True
    world.robot.navigates = False


def another_hub(world: World) -> None:
    world.robot.restart(world.now)
    world.reconnect()


def lose_navigation(world: World) -> None:
    world.robot.navigates = False


def another_navigation(world: World) -> None:
    world.robot.began(world.now)


def rival_takes_over(world: World) -> None:
    world.robot.arbiter.take_over(world.rival.link.number, "rival", world.now)


def rival_gives_up(world: World) -> None:
    world.robot.arbiter.release(world.rival.link.number, world.now)


def silence(world: World) -> None:
    agent(world).runs = False


def speak_again(world: World) -> None:
    agent(world).runs = True


def cut_off(world: World) -> None:
    agent(world).link.cut = True


def let_through(world: World) -> None:
    agent(world).link.cut = False


def agent(world: World) -> PadAgent:
    assert world.agent is not None
    return world.agent


CASES = (
    Case(name="unplugged", strike=World.unplug, mend=World.plug),
    Case(
        name="focus lost",
        strike=lambda world: rest(world.console, world, resting=True),
        mend=lambda world: rest(world.console, world, resting=False),
    ),
    Case(name="asleep", strike=fall_asleep, mend=awake),
    Case(
        name="asleep with a key held",
        press=World.hold_key,
        strike=fall_asleep,
        mend=awake,
        keys=True,
    ),
    Case(
        name="asleep with a key held and gaps",
        press=World.hold_key,
        strike=with_gaps(fall_asleep),
        mend=awake,
        keys=True,
    ),
    Case(name="clock leaps", strike=clock_leaps),
    Case(name="killed", strike=end, mend=start_again),
    Case(name="hub killed", strike=lose_hub, mend=another_hub),
    Case(name="navigation killed", strike=lose_navigation, mend=another_navigation),
    Case(name="network cut", strike=cut, mend=heal),
    Case(
        name="network cut with a key held", press=World.hold_key, strike=cut, mend=heal, keys=True
    ),
    Case(
        name="connected anew",
        strike=lambda world: setattr(world.console.link, "gone", True),
        mend=World.reconnect,
    ),
    Case(name="stopped from elsewhere", strike=lambda world: world.robot.stop(world.now)),
    Case(
        name="stopped from elsewhere with a key held and gaps",
        press=World.hold_key,
        strike=with_gaps(lambda world: world.robot.stop(world.now)),
        keys=True,
    ),
    Case(name="stopped by key", strike=press("space"), keys=True),
    Case(name="taken over", strike=rival_takes_over, mend=rival_gives_up),
    Case(
        name="two push and control is given up",
        before=World.rival_pushes,
        strike=press("c"),
        keys=True,
    ),
    Case(name="pad agent silent", strike=silence, mend=speak_again, elsewhere=True),
    Case(name="pad agent killed", strike=silence, mend=World.start_agent, elsewhere=True),
    Case(name="pad agent cut off", strike=cut_off, mend=let_through, elsewhere=True),
)


@pytest.fixture(scope="module")
def layout(tmp_path_factory: pytest.TempPathFactory) -> LayoutSpec:
    path = tmp_path_factory.mktemp("layout") / "layout.xml"
    path.write_text(_LAYOUT)
    return open_layout(path)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name.replace(" ", "-"))
def test_whatever_happens_the_robot_stops_and_stands_until_it_is_driven_from_neutral(
    case: Case, layout: LayoutSpec
) -> None:
    world = World(layout, random.Random(case.name), elsewhere=case.elsewhere)
    drive(world, case)
    for number in range(TIMES):
        try:
            play(world, case)
        except AssertionError as error:
            error.add_note(f"in repetition {number}")
            raise


def play(world: World, case: Case) -> None:
    """Somebody drives; have it happen, insist in vain, and drive again."""
    case.before(world)
    world.wait(world.chance.uniform(0.06, 0.16))
    assert world.robot.driven
    struck = world.now
    case.strike(world)
    world.wait(REST_S, until=lambda: not (world.robot.driven or world.robot.moves))
    assert world.driven_until - struck <= STOPPED_S
    assert world.moved_until - struck <= REST_S
    world.wait(world.chance.uniform(0.0, 0.3))
    case.mend(world)
    world.wait(INSISTED_WITH_GAPS_S if world.gaps else INSISTED_S)
    assert world.driven_until - struck <= STOPPED_S, "it drives with what was held before"
    drive(world, case)


def drive(world: World, case: Case) -> None:
    """From neutral."""
    world.neutral()
    # After a stop, keys have to be silent for so long on terminals that report no releases.
    world.wait(1.25 if case.keys else 0.25)
    case.press(world)
    world.wait(0.35, until=lambda: world.robot.driven)
    assert world.robot.driven, "it cannot be driven"
