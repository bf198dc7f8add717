"""A world in which the daemon's policy is tried: modules that behave as they are told to."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from hub.gcm.supervision import ModuleOrder, ModulePhase
from hub.robomon.module_lifecycle import ModuleLifecycle, ProcessAction
from hub.robomon.module_table import ModuleSpec
from hub.robomon.policy import ModulePolicy

STEP_S = 0.05


@dataclass
class Process:
    """A module as it behaves; times are on the world's clock."""

    pid: int
    announce_at: float
    crash_at: float = float("inf")
    hang_at: float = float("inf")
    deaf_to: frozenset[ProcessAction] = frozenset()
    end_at: float = float("inf")
    actions: list[ProcessAction] = field(default_factory=list)


def ways(**values: Any) -> Callable[[str], dict[str, Any]]:
    """All modules behave like this; times are from their start on."""
    return lambda _: values


class World:
    """The policy with modules that behave as they are told to.

    Whatever the policy does is checked as it does it: no module is started twice, or before what it
    needs, or again more often than it may be, and none is told the same twice.
    """

    def __init__(self, *specs: ModuleSpec, needs: dict[str, str] | None = None) -> None:
        self.policy = ModulePolicy(specs)
        self.now = 100.0
        self.behave: Callable[[str], dict[str, Any]] = ways()
        self.processes: dict[str, Process] = {}
        self.log: list[tuple[float, str, str]] = []
        self._waits: defaultdict[str, list[float]] = defaultdict(list)
        self._pids = 1000
        self._can = {
            spec.name: (spec.capabilities, tuple((needs or {}).get(spec.name, "").split()))
            for spec in specs
        }

    def __getitem__(self, name: str) -> ModuleLifecycle:
        return self.policy.lifecycles[name]

    def run(self, seconds: float, *, wants: str = "") -> None:
        """Let time pass; somebody wants these capabilities all the while."""
        end = self.now + seconds
        while self.now < end:
            self.now += STEP_S
            if wants:
                self.policy.wants.renew(7, "console", wants.split(), self.now)
            self._live()
            for life, action in self.policy.step(self.now):
                self._do(life, action)

    def order(self, name: str, order: ModuleOrder) -> tuple[bool, str]:
        """A person has something done with a module; to start it forgives its earlier failures."""
        if order is not ModuleOrder.STOP:
            self._waits.pop(name, None)
        return self.policy.ordered(name, order, self.now)

    def starts(self, name: str) -> list[float]:
        return [time for time, who, what in self.log if (who, what) == (name, "start")]

    def _live(self) -> None:
        for name, process in list(self.processes.items()):
            ends = min(process.crash_at, process.end_at)
            if self.now >= ends:
                del self.processes[name]
                self.log.append((self.now, name, "end"))
                self[name].ended("ended with exit code 1", self.now)
                self._see_whether_it_waits(self[name])
            elif process.announce_at <= self.now < process.hang_at:
                self.policy.announced(name, process.pid, *self._can[name], self.now)

    def _see_whether_it_waits(self, life: ModuleLifecycle) -> None:
        """Count the ends after which a module is to start again: too many would be a storm."""
        if life.phase is not ModulePhase.WAITING:
            return
        waits = self._waits[life.spec.name]
        waits.append(self.now)
        recent = [time for time in waits if time > self.now - life.spec.restart_window_s]
        assert len(recent) <= life.spec.restart_limit, f"{life.spec.name} is started for ever"

    def _do(self, life: ModuleLifecycle, action: ProcessAction) -> None:
        name = life.spec.name
        if action is ProcessAction.START:
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
        self.log.append((self.now, name, action.value))
        assert action not in process.actions, f"{name} is told the same twice"
        process.actions.append(action)
        if action not in process.deaf_to and not (
            action is ProcessAction.COMMAND and self.now >= process.hang_at
        ):
            process.end_at = self.now + 0.1

    def _runs(self, capability: str) -> bool:
        return any(
            capability in self._can[name][0] and life.phase is ModulePhase.RUNNING
            for name, life in self.policy.lifecycles.items()
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
            for name, life in self.policy.lifecycles.items()
        )


def spec(name: str, capabilities: str = "", **values: Any) -> ModuleSpec:
    return ModuleSpec(name=name, command=("x",), capabilities=tuple(capabilities.split()), **values)


def demand(name: str, capabilities: str, **values: Any) -> ModuleSpec:
    return spec(name, capabilities, always=False, **values)
