"""What the daemon decides, rule by rule."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

from hub.gcm.supervision import (
    LEASE_S,
    CapabilityPhase,
    ModuleOrder,
    ModulePhase,
    announce_every_s,
    keep_alive_s,
)
from hub.robomon.module_lifecycle import ModuleLifecycle, ProcessAction
from hub.robomon.policy import (
    EXTERNAL_SILENCE_S,
    MAX_EXTERNALS,
    MAX_SHOWN,
    MAX_UNKNOWN,
    ModulePolicy,
)
from hub.robomon.wants import MAX_HOLDERS, Wants
from tests.hub.robomon.world import STEP_S, World, demand, spec, ways


def test_wanted_capability_starts_what_it_needs_first_and_stops_when_nobody_wants_it() -> None:
    world = World(
        demand("autonomy", "AUT", linger_s=3.0),
        demand("map", "MAP", linger_s=3.0),
        demand("driver", "DRV", linger_s=3.0),
        needs={"autonomy": "MAP DRV", "map": "DRV"},
    )
    for life, needs in (("autonomy", {"MAP", "DRV"}), ("map", {"DRV"})):
        world[life].learned(world[life].provides, frozenset(needs))
    world.run(1.0)
    assert not world.log
    world.run(5.0, wants="AUT")
    assert [who for _, who, _ in world.log] == ["driver", "map", "autonomy"]
    views = world.policy.capabilities(world.now)
    assert views["AUT"].phase is CapabilityPhase.RUNNING
    assert views["AUT"].wanted_by == "console"
    world.run(LEASE_S + 2.0)
    assert len(world.processes) == 3, "lingers"
    world.run(10.0)
    assert not world.processes
    assert all(life.phase is ModulePhase.STOPPED for life in world.policy.lifecycles.values())


def test_console_that_leaves_gives_up_its_wants_at_once() -> None:
    wants = Wants()
    wants.renew(7, "console", ["VIS"], 0.0)
    wants.renew(8, "other", ["VIS"], 0.0)
    wants.disconnected("console")
    assert wants.current(0.1) == {"VIS": ["other"]}
    assert wants.current(LEASE_S) == {}


def test_wants_are_bounded() -> None:
    wants = Wants()
    for holder in range(MAX_HOLDERS + 5):
        wants.renew(holder, "x", ["VIS"], 0.0)
    wants.renew(1, "x", ["no capability"], 0.0)
    wants.renew(2, "x", [f"C{number}" for number in range(1000)], 0.0)
    assert wants.refused == 7
    assert len(wants.current(0.1)["VIS"]) == MAX_HOLDERS


def test_crash_is_followed_by_a_start_at_once_then_by_longer_pauses_then_by_none() -> None:
    world = World(spec("bad", "BAD", restart_limit=4, backoff_s=1.0, backoff_longest_s=3.0))
    world.behave = ways(crash_at=0.2)
    world.run(60.0)
    starts = world.starts("bad")
    ends = [time for time, _, what in world.log if what == "end"]
    pauses = [start - end for start, end in zip(starts[1:], ends, strict=False)]
    assert pauses == pytest.approx([0.0, 1.0, 2.0, 3.0], abs=2 * STEP_S)
    assert world["bad"].phase is ModulePhase.FAILED
    assert "given up" in world["bad"].why
    world.behave = ways()
    assert world.order("bad", ModuleOrder.START)[0]
    world.run(2.0)
    assert world["bad"].phase is ModulePhase.RUNNING


def test_module_that_ran_for_a_while_is_started_again_at_once_each_time() -> None:
    world = World(spec("frail", settled_s=2.0))
    world.behave = ways(crash_at=2.5)
    world.run(20.0)
    ends = [time for time, _, what in world.log if what == "end"]
    pauses = [b - a for a, b in zip(ends, world.starts("frail")[1:], strict=False)]
    assert len(pauses) > 5
    assert max(pauses) < 2 * STEP_S


@pytest.mark.parametrize("keep_alive_s", [0.0, 5.0])
def test_module_that_runs_again_says_what_ended_it_until_a_person_starts_it(
    keep_alive_s: float,
) -> None:
    world = World(spec("one", keep_alive_s=keep_alive_s))
    world.run(1.0)
    assert world["one"].why == ""
    world.processes["one"].crash_at = world.now
    world.run(1.0)
    assert world["one"].phase is ModulePhase.RUNNING
    assert world["one"].why == "runs again; it ended with exit code 1"
    world.order("one", ModuleOrder.RESTART)
    world.run(2.0)
    assert world["one"].phase is ModulePhase.RUNNING
    assert world["one"].why == ""


def test_module_that_was_not_wanted_meanwhile_does_not_run_again() -> None:
    world = World(demand("one", "A", linger_s=0.0))
    world.run(1.0, wants="A")
    world.processes["one"].crash_at = world.now
    world.run(1.0, wants="A")
    assert "exit code 1" in world["one"].why
    world.run(10.0)
    world.run(1.0, wants="A")
    assert world["one"].phase is ModulePhase.RUNNING
    assert world["one"].why == ""


def test_rare_crashes_are_forgotten() -> None:
    world = World(spec("frail", restart_limit=1, restart_window_s=10.0))
    world.behave = ways(crash_at=11.0)
    world.run(100.0)
    assert len(world.starts("frail")) >= 8
    assert world["frail"].phase is not ModulePhase.FAILED


def test_hanging_module_is_terminated_and_killed_and_started_again() -> None:
    world = World(spec("stuck", keep_alive_s=2.0))
    world.behave = ways(
        hang_at=5.0, deaf_to=frozenset({ProcessAction.COMMAND, ProcessAction.TERMINATE})
    )
    world.run(1.0)
    world.behave = ways()
    world.run(20.0)
    whats = [what for _, _, what in world.log]
    assert whats == ["start", "send it SIGTERM", "send it SIGKILL", "end", "start"]
    hung, killed = world.log[1][0], world.log[2][0]
    assert hung - world.log[0][0] == pytest.approx(7.0, abs=0.2)
    assert killed - hung == pytest.approx(0.5, abs=2 * STEP_S)
    assert world["stuck"].why == "runs again; it hung: silent for 2 s"


@pytest.mark.parametrize(
    ("says", "longest"),
    [({"capabilities": "DRV_BASE"}, 1.0), ({}, 5.0), ({"keep_alive_s": 3.0}, 3.0)],
)
def test_driver_that_hangs_is_ended_sooner_than_others(
    says: dict[str, Any], longest: float
) -> None:
    world = World(spec("one", **says))
    world.behave = ways(hang_at=5.0)
    world.run(1.0)
    world.behave = ways()
    world.run(20.0)
    assert world["one"].why == f"runs again; it hung: silent for {longest:g} s"
    assert world.log[1][0] - world.log[0][0] == pytest.approx(5.0 + longest, abs=0.2)


def test_every_module_announces_itself_several_times_within_its_keep_alive() -> None:
    for capabilities in ([], ["DRV_BASE"]):
        assert announce_every_s(capabilities) * 4 <= keep_alive_s(capabilities)


def test_module_that_never_announces_itself_is_ended() -> None:
    world = World(spec("mute", start_timeout_s=3.0, restart_limit=0))
    world.behave = ways(announce_at=1e9)
    world.run(10.0)
    assert world["mute"].phase is ModulePhase.FAILED
    assert "did not announce itself in 3 s" in world["mute"].why


def test_program_that_announces_nothing_is_asked_for_nothing() -> None:
    world = World(spec("plain", keep_alive_s=0.0))
    world.behave = ways(announce_at=1e9)
    world.run(100.0)
    assert world["plain"].phase is ModulePhase.RUNNING
    assert world.policy.undescribed() == []


def test_stop_goes_from_command_to_kill() -> None:
    world = World(spec("deaf", ask_timeout_s=1.0, stop_timeout_s=2.5))
    world.behave = ways(deaf_to=frozenset({ProcessAction.COMMAND, ProcessAction.TERMINATE}))
    world.run(2.0)
    world.order("deaf", ModuleOrder.STOP)
    world.run(5.0)
    times = [time for time, _, what in world.log if what not in ("start", "end")]
    assert [what for _, _, what in world.log[1:4]] == [
        "tell it to stop", "send it SIGTERM", "send it SIGKILL"
    ]  # fmt: skip
    assert times[1] - times[0] == pytest.approx(1.0, abs=2 * STEP_S)
    assert times[2] - times[0] == pytest.approx(2.5, abs=2 * STEP_S)
    world.run(20.0)
    assert len(world.starts("deaf")) == 1, "stays stopped"


def test_memory_beyond_the_limit_starts_it_anew() -> None:
    world = World(spec("leaky", memory_limit_mb=100.0))
    world.run(1.0)
    for _ in range(2):
        world.policy.used("leaky", 150.0, world.now)
    world.policy.used("leaky", 90.0, world.now)
    for _ in range(2):
        world.policy.used("leaky", 150.0, world.now)
    assert world["leaky"].phase is ModulePhase.RUNNING, "not for a moment's need"
    world.policy.used("leaky", 150.0, world.now)
    assert world["leaky"].why == "took 150 MB and may take 100"
    world.run(2.0)
    assert len(world.starts("leaky")) == 2
    assert world["leaky"].phase is ModulePhase.RUNNING


def test_module_that_fails_again_is_replaced_by_one_that_can_do_the_same() -> None:
    world = World(
        spec("vision", "VID PTZ", restart_limit=3),
        demand("spare", "VID PTZ NIGHT"),
        demand("poor", "VID"),
    )
    world.behave = lambda name: {"crash_at": 0.5} if name == "vision" else {}
    world.run(30.0)
    assert world["spare"].phase is ModulePhase.RUNNING
    assert not world.starts("poor")
    assert len(world.starts("vision")) == 2, "stands back while its spare works"
    assert "spare does its work" in world["vision"].why
    views = world.policy.capabilities(world.now)
    assert views["PTZ"].module == "spare"
    world.processes["spare"].crash_at = world.now
    world.run(3.0)
    assert world["spare"].phase is ModulePhase.RUNNING, "a first crash is no failure"
    world.behave = lambda name: {"crash_at": 0.5} if name == "spare" else {}
    world.processes["spare"].crash_at = world.now
    world.run(10.0)
    assert world["vision"].phase is ModulePhase.RUNNING, "takes over again"


def test_wanted_capability_moves_to_another_module() -> None:
    world = World(demand("bad", "VID"), demand("good", "VID"))
    world.behave = lambda name: {"crash_at": 0.1} if name == "bad" else {}
    world.run(20.0, wants="VID")
    assert world["good"].phase is ModulePhase.RUNNING
    assert len(world.starts("bad")) == 2


def test_modules_that_need_each_other_both_start() -> None:
    world = World(spec("a", "A"), spec("b", "B"), needs={"a": "B", "b": "A"})
    world["a"].learned(frozenset({"A"}), frozenset({"B"}))
    world["b"].learned(frozenset({"B"}), frozenset({"A"}))
    world.run(3.0)
    assert set(world.processes) == {"a", "b"}


def test_what_nobody_has_is_waited_for_and_said() -> None:
    world = World(spec("lonely", "A"))
    world["lonely"].learned(frozenset({"A"}), frozenset({"NONE"}))
    world.run(3.0)
    assert world["lonely"].why == "waits for NONE"
    world.policy.announced("guest", 5, ["NONE"], [], world.now)
    world.run(1.0)
    assert "lonely" in world.processes


def test_module_that_somebody_else_started_counts_and_is_forgotten() -> None:
    world = World(demand("mine", "VID"))
    for number in range(2 * MAX_EXTERNALS):
        world.policy.announced(f"guest{number}", 5, ["VID"], [], world.now)
    assert len(world.policy.externals) == MAX_EXTERNALS
    world.run(2.0, wants="VID")
    assert not world.starts("mine")
    assert world.policy.capabilities(world.now)["VID"].phase is CapabilityPhase.RUNNING
    world.run(EXTERNAL_SILENCE_S, wants="VID")
    assert world.starts("mine")


def test_pause_of_the_daemon_itself_is_not_held_against_the_modules() -> None:
    world = World(spec("fine", keep_alive_s=2.0))
    world.run(5.0)
    world.now += 60.0
    world.policy.step(world.now)
    assert world["fine"].phase is ModulePhase.RUNNING


def test_last_words_of_an_earlier_process_are_not_taken_for_the_new_one() -> None:
    world = World(spec("phoenix"))
    world.run(1.0)
    earlier = world.processes["phoenix"].pid
    world.processes["phoenix"].crash_at = world.now
    world.run(2 * STEP_S)
    assert world["phoenix"].phase is ModulePhase.STARTING
    world.policy.announced("phoenix", earlier, ["A"], [], world.now)
    assert world["phoenix"].phase is ModulePhase.STARTING


def test_orders_are_answered_in_words() -> None:
    world = World(spec("driver"), spec("vision"))
    done, text = world.order("driwer", ModuleOrder.STOP)
    assert not done
    assert text.endswith("this robot has driver, vision; did you mean 'driver'?")


def test_a_start_that_has_to_wait_says_for_what() -> None:
    world = World(demand("autonomy", "AUT"), demand("map", "MAP"), needs={"autonomy": "MAP"})
    world["autonomy"].learned(world["autonomy"].provides, frozenset({"MAP"}))
    world.order("map", ModuleOrder.STOP)
    text = "autonomy starts as soon as a module for MAP may start"
    assert world.order("autonomy", ModuleOrder.START) == (True, text)
    world.run(2.0)
    assert not world.processes
    assert world.order("map", ModuleOrder.START)[1] == "map is started"
    world.run(2.0)
    assert world["autonomy"].phase is ModulePhase.RUNNING


def test_modules_that_all_need_each_other_start() -> None:
    """Twelve of them: to follow every way through the circle would take for ever."""
    names = [f"X_{number}" for number in range(12)]
    specs = [spec(name.lower(), name) for name in names]
    world = World(*specs, needs={name.lower(): " ".join({*names} - {name}) for name in names})
    for name in names:
        world[name.lower()].learned(frozenset({name}), frozenset({*names} - {name}))
    world.run(1.0)
    assert all(life.phase is ModulePhase.RUNNING for life in world.policy.lifecycles.values())


def test_names_that_modules_announce_are_bounded() -> None:
    world = World(spec("one", "VID"))
    rubbish = ["GOOD", "two words", "line\nend", "A" * 65, ""]
    world.policy.announced(" long\nname " * 100, 5, rubbish, rubbish, world.now)
    (name,) = world.policy.externals
    assert (len(name), name.isidentifier()) == (64, True)
    many = [f"X_{number}" for number in range(10_000)]
    world.run(0.1)
    world.policy.announced("one", world["one"].pid, many, rubbish, world.now)
    assert len(world["one"].provides) <= 64
    assert world["one"].needs == {"GOOD"}
    assert set(world.policy.capabilities(world.now)) == world["one"].provides | {"GOOD"}


def test_wants_of_what_nobody_has_do_not_crowd_out_the_others() -> None:
    world = World(demand("one", "VID"))
    wants = world.policy.wants
    for holder in range(MAX_HOLDERS):
        rubbish = [f"A_{holder}_{number}" for number in range(63)]
        wants.renew(holder, f"holder{holder}", [*rubbish, "VID"], world.now)
    world.run(1.0)
    views = world.policy.capabilities(world.now)
    assert views["VID"].phase is CapabilityPhase.RUNNING
    assert len(views["VID"].wanted_by.split()) == MAX_SHOWN
    assert len(views) == 1 + MAX_UNKNOWN


def test_a_want_holds_for_as_long_as_it_says_but_not_for_ever() -> None:
    wants = Wants()
    wants.renew(1, "slow", ["A"], 0.0, lease_s=15.0)
    assert wants.current(14.9) == {"A": ["slow"]}
    assert wants.current(15.0) == {}
    for lease in (0.0, -1.0, math.nan, math.inf):
        wants.renew(1, "odd", ["A"], 20.0, lease_s=lease)
    assert wants.current(20.0) == {}
    assert wants.refused == 4


def test_wants_that_change_or_end_are_seen_at_once() -> None:
    wants = Wants()
    wants.renew(1, "one", ["A"], 0.0)
    wants.renew(2, "two", ["A"], 1.0)
    assert wants.current(1.0) == {"A": ["one", "two"]}
    wants.renew(2, "two", ["B"], 1.0)
    assert wants.current(1.0) == {"A": ["one"], "B": ["two"]}
    wants.renew(2, "three", ["B"], 1.0)
    assert wants.current(1.0) == {"A": ["one"], "B": ["three"]}
    assert wants.current(LEASE_S) == {"B": ["three"]}
    wants.renew(2, "three", [], LEASE_S)
    assert wants.current(LEASE_S) == {}


def test_module_that_cannot_be_started_is_tried_with_pauses() -> None:
    """A program may lie on a disk that is there a moment later."""
    supervisor, tries = ModulePolicy([spec("one", restart_limit=5)]), []
    for step in range(2000):
        now = 100.0 + STEP_S * step
        for life, action in supervisor.step(now):
            assert action is ProcessAction.START
            tries.append(now)
            life.not_started("could not be started", now)
    pauses = [later - earlier for earlier, later in itertools.pairwise(tries)]
    assert pauses == pytest.approx([STEP_S, 0.2, 0.4, 0.8, 1.6], abs=1.5 * STEP_S)
    assert supervisor.lifecycles["one"].phase is ModulePhase.FAILED


def test_others_do_not_speak_for_a_module_that_hangs() -> None:
    world = World(spec("one", "VID", keep_alive_s=2.0))
    world.behave = ways(hang_at=1.0)
    for _ in range(100):
        world.run(STEP_S)
        if world.now - world["one"].since > 0.5:  # it was heard itself by then
            world.policy.announced("one", 5, ["LIE"], [], world.now)
        assert world["one"].provides == {"VID"}
    assert len(world.starts("one")) == 2


def test_module_started_by_a_script_is_heard() -> None:
    """Also when the script starts it anew under another process id."""
    world = World(spec("one", "VID", keep_alive_s=2.0))
    world.behave = ways(announce_at=1000.0)
    for step in range(100):
        world.run(STEP_S)
        world.policy.announced("one", 5 + step // 50, ["VID"], [], world.now)
    assert world["one"].phase is ModulePhase.RUNNING
    assert len(world.starts("one")) == 1


def test_process_id_that_was_used_before_is_heard() -> None:
    life = ModuleLifecycle(spec("one"))
    life.started(7, 0.0)
    life.ended("crashed", 1.0)
    life.started(7, 2.0)
    assert life.announced(7, 3.0)
