"""What the daemon decides: rules one by one, and thousands of random histories."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hub.gcm.supervision import LEASE_S, CapabilityPhase, ModuleOrder, ModulePhase
from hub.robomon.life import Deed, Life
from hub.robomon.policy import (
    MAX_SHOWN,
    MAX_STRANGERS,
    MAX_UNKNOWN,
    STRANGER_S,
    Supervisor,
)
from hub.robomon.table import ModuleSpec
from hub.robomon.wants import MAX_HOLDERS, Wants

STEP_S = 0.05


@dataclass
class Process:
    """A module as it behaves; times are on the world's clock."""

    pid: int
    announce_at: float
    crash_at: float = float("inf")
    hang_at: float = float("inf")
    deaf_to: frozenset[Deed] = frozenset()
    end_at: float = float("inf")
    deeds: list[tuple[float, Deed]] = field(default_factory=list)


def ways(**values: Any) -> Callable[[str], dict[str, Any]]:
    """All modules behave like this; times are from their start on."""
    return lambda _: values


class World:
    """The policy with modules that behave as they are told to."""

    def __init__(self, *specs: ModuleSpec, needs: dict[str, str] | None = None) -> None:
        self.supervisor = Supervisor(specs)
        self.now = 100.0
        self.behave: Callable[[str], dict[str, Any]] = ways()
        self.processes: dict[str, Process] = {}
        self.log: list[tuple[float, str, str]] = []
        self._pids = 1000
        self._can = {
            spec.name: (spec.capabilities, tuple((needs or {}).get(spec.name, "").split()))
            for spec in specs
        }

    def __getitem__(self, name: str) -> Life:
        return self.supervisor.lives[name]

    def run(self, seconds: float, *, wants: str = "") -> None:
        """Let time pass; somebody wants these capabilities all the while."""
        end = self.now + seconds
        while self.now < end:
            self.now += STEP_S
            if wants:
                self.supervisor.wants.renew(7, "console", wants.split(), self.now)
            self._live()
            for life, deed in self.supervisor.step(self.now):
                self._do(life, deed)

    def starts(self, name: str) -> list[float]:
        return [time for time, who, what in self.log if (who, what) == (name, "start")]

    def _live(self) -> None:
        for name, process in list(self.processes.items()):
            ends = min(process.crash_at, process.end_at)
            if self.now >= ends:
                del self.processes[name]
                self.log.append((self.now, name, "end"))
                self[name].ended("ended with exit code 1", self.now)
            elif process.announce_at <= self.now < process.hang_at:
                self.supervisor.announced(name, process.pid, *self._can[name], self.now)

    def _do(self, life: Life, deed: Deed) -> None:
        name = life.spec.name
        if deed is Deed.START:
            assert name not in self.processes, "two at the same time"
            lacking = [
                need
                for need in self._can[name][1]
                if life.asked
                and not self._runs(need)
                and self._could_run(need)
                and not self._circular(need, name, set())
            ]
            assert not lacking, f"{name} was started before {lacking}"
            self._pids += 1
            self.log.append((self.now, name, "start"))
            ways = {"announce_at": self.now + 0.3} | {
                key: value + self.now if key.endswith("_at") else value
                for key, value in self.behave(name).items()
            }
            self.processes[name] = Process(pid=self._pids, **ways)
            life.started(self._pids, self.now)
            return
        process = self.processes[name]
        self.log.append((self.now, name, deed.value))
        process.deeds.append((self.now, deed))
        if deed not in process.deaf_to and not (
            deed is Deed.COMMAND and self.now >= process.hang_at
        ):
            process.end_at = self.now + 0.1

    def _runs(self, capability: str) -> bool:
        return any(
            capability in self._can[name][0] and life.phase is ModulePhase.RUNNING
            for name, life in self.supervisor.lives.items()
        )

    def _circular(self, need: str, name: str, seen: set[str]) -> bool:
        """Whether who has a capability needs this module in turn."""
        owners = [other for other, (has, _) in self._can.items() if need in has]
        if name in owners:
            return True
        seen.add(need)
        return any(
            self._circular(further, name, seen)
            for owner in owners
            for further in self._can[owner][1]
            if further not in seen
        )

    def _could_run(self, capability: str) -> bool:
        return any(
            capability in self._can[name][0] and life.usable
            for name, life in self.supervisor.lives.items()
        )


def spec(name: str, capabilities: str = "", **values: Any) -> ModuleSpec:
    return ModuleSpec(name=name, command=("x",), capabilities=tuple(capabilities.split()), **values)


def demand(name: str, capabilities: str, **values: Any) -> ModuleSpec:
    return spec(name, capabilities, always=False, **values)


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
    views = world.supervisor.capabilities(world.now)
    assert views["AUT"].phase is CapabilityPhase.RUNNING
    assert views["AUT"].wanted_by == ("console",)
    world.run(LEASE_S + 2.0)
    assert len(world.processes) == 3, "lingers"
    world.run(10.0)
    assert not world.processes
    assert all(life.phase is ModulePhase.STOPPED for life in world.supervisor.lives.values())


def test_console_that_leaves_gives_up_its_wants_at_once() -> None:
    wants = Wants()
    wants.renew(7, "console", ["VIS"], 0.0)
    wants.renew(8, "other", ["VIS"], 0.0)
    wants.gone("console")
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
    assert world.supervisor.ordered("bad", ModuleOrder.START, world.now)[0]
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


def test_rare_crashes_are_forgotten() -> None:
    world = World(spec("frail", restart_limit=1, restart_window_s=10.0))
    world.behave = ways(crash_at=11.0)
    world.run(100.0)
    assert len(world.starts("frail")) >= 8
    assert world["frail"].phase is not ModulePhase.FAILED


def test_hanging_module_is_terminated_and_killed_and_started_again() -> None:
    world = World(spec("stuck", keep_alive_s=2.0))
    world.behave = ways(hang_at=5.0, deaf_to=frozenset({Deed.COMMAND, Deed.TERMINATE}))
    world.run(1.0)
    world.behave = ways()
    world.run(20.0)
    whats = [what for _, _, what in world.log]
    assert whats == ["start", "send it SIGTERM", "send it SIGKILL", "end", "start"]
    hung, killed = world.log[1][0], world.log[2][0]
    assert hung - world.log[0][0] == pytest.approx(7.0, abs=0.2)
    assert killed - hung == pytest.approx(0.5, abs=2 * STEP_S)


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
    assert world.supervisor.unasked() == []


def test_stop_goes_from_command_to_kill() -> None:
    world = World(spec("deaf", ask_timeout_s=1.0, stop_timeout_s=2.5))
    world.behave = ways(deaf_to=frozenset({Deed.COMMAND, Deed.TERMINATE}))
    world.run(2.0)
    world.supervisor.ordered("deaf", ModuleOrder.STOP, world.now)
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
        world.supervisor.used("leaky", 150.0, world.now)
    world.supervisor.used("leaky", 90.0, world.now)
    for _ in range(2):
        world.supervisor.used("leaky", 150.0, world.now)
    assert world["leaky"].phase is ModulePhase.RUNNING, "not for a moment's need"
    world.supervisor.used("leaky", 150.0, world.now)
    assert world["leaky"].why == "takes 150 MB and may take 100"
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
    views = world.supervisor.capabilities(world.now)
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
    world.supervisor.announced("guest", 5, ["NONE"], [], world.now)
    world.run(1.0)
    assert "lonely" in world.processes


def test_module_that_somebody_else_started_counts_and_is_forgotten() -> None:
    world = World(demand("mine", "VID"))
    for number in range(2 * MAX_STRANGERS):
        world.supervisor.announced(f"guest{number}", 5, ["VID"], [], world.now)
    assert len(world.supervisor.strangers) == MAX_STRANGERS
    world.run(2.0, wants="VID")
    assert not world.starts("mine")
    assert world.supervisor.capabilities(world.now)["VID"].phase is CapabilityPhase.RUNNING
    world.run(STRANGER_S, wants="VID")
    assert world.starts("mine")


def test_pause_of_the_daemon_itself_is_not_held_against_the_modules() -> None:
    world = World(spec("fine", keep_alive_s=2.0))
    world.run(5.0)
    world.now += 60.0
    world.supervisor.step(world.now)
    assert world["fine"].phase is ModulePhase.RUNNING


def test_last_words_of_an_earlier_process_are_not_taken_for_the_new_one() -> None:
    world = World(spec("phoenix"))
    world.run(1.0)
    earlier = world.processes["phoenix"].pid
    world.processes["phoenix"].crash_at = world.now
    world.run(2 * STEP_S)
    assert world["phoenix"].phase is ModulePhase.STARTING
    world.supervisor.announced("phoenix", earlier, ["A"], [], world.now)
    assert world["phoenix"].phase is ModulePhase.STARTING


def test_orders_are_answered_in_words() -> None:
    world = World(spec("a"), spec("b"))
    done, text = world.supervisor.ordered("c", ModuleOrder.STOP, world.now)
    assert not done
    assert "this robot has a, b" in text


def test_a_start_that_has_to_wait_says_for_what() -> None:
    world = World(demand("autonomy", "AUT"), demand("map", "MAP"), needs={"autonomy": "MAP"})
    world["autonomy"].learned(world["autonomy"].provides, frozenset({"MAP"}))
    world.supervisor.ordered("map", ModuleOrder.STOP, world.now)
    text = "autonomy starts as soon as a module for MAP may start"
    assert world.supervisor.ordered("autonomy", ModuleOrder.START, world.now) == (True, text)
    world.run(2.0)
    assert not world.processes
    assert world.supervisor.ordered("map", ModuleOrder.START, world.now)[1] == "map is started"
    world.run(2.0)
    assert world["autonomy"].phase is ModulePhase.RUNNING


_MODULES = ("a", "b", "c", "d")
_CAPABILITIES = ("A", "B", "C")


@settings(max_examples=60)
@given(st.integers(0, 2**32))
def test_random_histories(seed: int) -> None:
    """Whatever modules do and whoever wants what: no storm, no doubles, no zombie, no deadlock."""
    chance = random.Random(seed)
    specs = [
        ModuleSpec(
            name=name,
            command=("x",),
            capabilities=tuple(chance.sample(_CAPABILITIES, chance.randint(0, 2))),
            always=chance.random() < 0.4,
            keep_alive_s=chance.choice([0.0, 2.0, 5.0]),
            start_timeout_s=3.0,
            linger_s=chance.choice([0.0, 1.0, 3.0]),
            restart_limit=chance.randint(0, 4),
            restart_window_s=chance.choice([5.0, 1000.0]),
        )
        for name in _MODULES
    ]
    needs = {name: chance.choice(["", "", *_CAPABILITIES]) for name in _MODULES}
    world = World(*specs, needs=needs)
    for each in specs:
        if chance.random() < 0.7:
            lacks = frozenset(needs[each.name].split())
            world[each.name].learned(frozenset(each.capabilities), lacks)

    def behave(name: str) -> dict[str, Any]:
        del name
        far = float("inf")
        return {
            "announce_at": chance.choice([0.1, 0.3, 1.0, far]),
            "crash_at": chance.choice([far, far, far, 0.0, 0.5, 4.0]),
            "hang_at": chance.choice([far, far, 2.0]),
            "deaf_to": frozenset(
                deed for deed in (Deed.COMMAND, Deed.TERMINATE) if chance.random() < 0.2
            ),
        }

    world.behave = behave
    restarts_allowed = True
    for _ in range(chance.randint(5, 25)):
        kind = chance.random()
        if kind < 0.25:
            order = chance.choice(list(ModuleOrder))
            name = chance.choice(_MODULES)
            world.supervisor.ordered(name, order, world.now)
            restarts_allowed = restarts_allowed and order is ModuleOrder.STOP
            if order is ModuleOrder.STOP:
                held = len(world.starts(name))
                world.run(3.0, wants="A B C")
                assert len(world.starts(name)) == held
                assert name not in world.processes, "lives on after a stop"
        wants = " ".join(chance.sample(_CAPABILITIES, chance.randint(0, 3)))
        world.run(chance.choice([0.2, 1.0, 4.0]), wants=wants)
    _check(world, orders=not restarts_allowed)
    # From now on all behave: whatever is wanted and not given up comes to run, the rest ends.
    world.behave = ways()
    for process in world.processes.values():
        process.deaf_to = frozenset()
    world.run(40.0, wants="A")
    view = world.supervisor.capabilities(world.now).get("A")
    able = [name for name, life in world.supervisor.lives.items() if "A" in life.provides]
    reachable = any(world[name].usable and not _lacks_for_ever(world, name, set()) for name in able)
    assert view is not None
    assert (view.phase is CapabilityPhase.RUNNING) or not reachable
    world.run(40.0)
    for name, life in world.supervisor.lives.items():
        needed = any(
            other.phase is ModulePhase.RUNNING and life.provides & other.needs
            for other in world.supervisor.lives.values()
        )
        replaces = any(f"{name} does its work" in o.why for o in world.supervisor.lives.values())
        if life.up and not needed and not replaces:
            assert life.spec.always or life.pinned, f"{name} runs and nobody wants it"


def _check(world: World, *, orders: bool) -> None:
    """No module is started more often than it may be."""
    for name, life in world.supervisor.lives.items():
        if orders:
            continue
        starts = world.starts(name)
        failures = [time for time, who, what in world.log if (who, what) == (name, "end")]
        for start in starts:
            recent = [t for t in failures if start - life.spec.restart_window_s < t <= start]
            assert len(recent) <= life.spec.restart_limit + len(starts), name
    for name, process in world.processes.items():
        kinds = [deed for _, deed in process.deeds]
        assert len(kinds) == len(set(kinds)), f"{name} was told the same twice"


def _lacks_for_ever(world: World, name: str, seen: set[str]) -> bool:
    """Whether a module needs what no usable module has."""
    if name in seen:
        return False
    seen.add(name)
    return any(
        not any(
            need in life.provides and life.usable and not _lacks_for_ever(world, other, seen)
            for other, life in world.supervisor.lives.items()
        )
        for need in world[name].needs
    )


def test_modules_that_all_need_each_other_start() -> None:
    """Twelve of them: to follow every way through the circle would take for ever."""
    names = [f"X_{number}" for number in range(12)]
    specs = [spec(name.lower(), name) for name in names]
    world = World(*specs, needs={name.lower(): " ".join({*names} - {name}) for name in names})
    for name in names:
        world[name.lower()].learned(frozenset({name}), frozenset({*names} - {name}))
    world.run(1.0)
    assert all(life.phase is ModulePhase.RUNNING for life in world.supervisor.lives.values())


def test_names_that_modules_announce_are_bounded() -> None:
    world = World(spec("one", "VID"))
    rubbish = ["GOOD", "two words", "line\nend", "A" * 65, ""]
    world.supervisor.announced(" long\nname " * 100, 5, rubbish, rubbish, world.now)
    (name,) = world.supervisor.strangers
    assert (len(name), name.isidentifier()) == (64, True)
    many = [f"X_{number}" for number in range(10_000)]
    world.run(0.1)
    world.supervisor.announced("one", world["one"].pid, many, rubbish, world.now)
    assert len(world["one"].provides) <= 64
    assert world["one"].needs == {"GOOD"}
    assert set(world.supervisor.capabilities(world.now)) == world["one"].provides | {"GOOD"}


def test_wants_of_what_nobody_has_do_not_crowd_out_the_others() -> None:
    world = World(demand("one", "VID"))
    wants = world.supervisor.wants
    for holder in range(MAX_HOLDERS):
        rubbish = [f"A_{holder}_{number}" for number in range(63)]
        wants.renew(holder, f"holder{holder}", [*rubbish, "VID"], world.now)
    world.run(1.0)
    views = world.supervisor.capabilities(world.now)
    assert views["VID"].phase is CapabilityPhase.RUNNING
    assert len(views["VID"].wanted_by) == MAX_SHOWN
    assert len(views) == 1 + MAX_UNKNOWN


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
    supervisor, tries = Supervisor([spec("one", restart_limit=5)]), []
    for step in range(2000):
        now = 100.0 + STEP_S * step
        for life, deed in supervisor.step(now):
            assert deed is Deed.START
            tries.append(now)
            life.not_started("cannot be started", now)
    pauses = [later - earlier for earlier, later in itertools.pairwise(tries)]
    assert pauses == pytest.approx([STEP_S, 0.2, 0.4, 0.8, 1.6], abs=1.5 * STEP_S)
    assert supervisor.lives["one"].phase is ModulePhase.FAILED


def test_others_do_not_speak_for_a_module_that_hangs() -> None:
    world = World(spec("one", "VID", keep_alive_s=2.0))
    world.behave = ways(hang_at=1.0)
    for _ in range(100):
        world.run(STEP_S)
        if world.now - world["one"].since > 0.5:  # it was heard itself by then
            world.supervisor.announced("one", 5, ["LIE"], [], world.now)
        assert world["one"].provides == {"VID"}
    assert len(world.starts("one")) == 2


def test_module_started_by_a_script_is_heard() -> None:
    """Also when the script starts it anew under another process id."""
    world = World(spec("one", "VID", keep_alive_s=2.0))
    world.behave = ways(announce_at=1000.0)
    for step in range(100):
        world.run(STEP_S)
        world.supervisor.announced("one", 5 + step // 50, ["VID"], [], world.now)
    assert world["one"].phase is ModulePhase.RUNNING
    assert len(world.starts("one")) == 1


def test_process_id_that_was_used_before_is_heard() -> None:
    life = Life(spec("one"))
    life.started(7, 0.0)
    life.ended("crashed", 1.0)
    life.started(7, 2.0)
    assert life.announced(7, 3.0)
