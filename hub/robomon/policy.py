"""The modules that run: from events and time to actions; pure.

A module runs in four cases: it runs always, an order started it, one of its capabilities is wanted,
or another running module needs one. A module that ended too often, or again soon after a start, has
a spare: another module with the same capabilities replaces it, until that one fails.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable, Sequence

from hub.gcm.supervision import CapabilityPhase, CapabilityReport, ModuleOrder, ModulePhase
from hub.nearest import did_you_mean
from hub.own_pauses import OwnPauses
from hub.robomon.module_lifecycle import ModuleLifecycle, ProcessAction
from hub.robomon.module_table import ModuleSpec
from hub.robomon.wants import MAX_CAPABILITIES, MAX_NAME, Wants
from hub.values import dataclass

AWAY_S = 1.0
"""Pause between two steps after which this process counts as paused [s]."""
EXTERNAL_SILENCE_S = 4.0
"""Silence after which a module that the daemon did not start is forgotten [s]."""
MAX_EXTERNALS = 64
MAX_UNKNOWN = 64
"""Most reported capabilities that are wanted and that no module has."""
MAX_SHOWN = 16
"""Most holders of a want that are named."""
_OVER_LIMIT_SAMPLES = 3
"""Samples in a row above a limit after which a module restarts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExternalModule:
    """A module that another program started.

    Attributes:
        pid: Process id on its machine.
        provides: Its capabilities.
        needs: The capabilities it needs.
        last_heard: Time of its last announcement [s].
    """

    pid: int
    provides: frozenset[str]
    needs: frozenset[str]
    last_heard: float


class ModulePolicy:
    """All modules of a robot; methods get the time [s].

    Attributes:
        lifecycles: The modules by name, in the order of the robot file.
        externals: Modules that another program started, by name.
        wants: The wanted capabilities.
    """

    def __init__(self, specs: Sequence[ModuleSpec]) -> None:
        self.lifecycles = {spec.name: ModuleLifecycle(spec) for spec in specs}
        self.externals: dict[str, ExternalModule] = {}
        self.wants = Wants()
        self._chosen: dict[str, str] = {}
        self._over: dict[str, int] = {}
        self._pauses = OwnPauses(AWAY_S)
        self._outside: frozenset[str] = frozenset()
        self._offered: frozenset[str] = frozenset()
        self._known: frozenset[str] = frozenset()
        self._providers: dict[str, list[ModuleLifecycle]] = {}

    def announced(
        self, name: str, pid: int, provides: Iterable[str], needs: Iterable[str], now: float
    ) -> None:
        """Note a module's announcement and its capabilities."""
        can, lacks = _usable(provides), _usable(needs)
        lifecycle = self.lifecycles.get(name)
        shown = "".join(name.split())[:MAX_NAME]
        if lifecycle is not None and lifecycle.has_process:
            if lifecycle.announced(pid, now):
                lifecycle.learned(can, lacks)
        elif lifecycle is None and (shown in self.externals or len(self.externals) < MAX_EXTERNALS):
            self.externals[shown] = ExternalModule(
                pid=pid, provides=can, needs=lacks, last_heard=now
            )

    def used(self, name: str, memory_mb: float, now: float) -> None:
        """Note a sample of a module's memory."""
        lifecycle = self.lifecycles[name]
        limit = lifecycle.spec.memory_limit_mb
        over = self._over.get(name, 0) + 1 if 0.0 < limit < memory_mb else 0
        self._over[name] = over
        if over >= _OVER_LIMIT_SAMPLES:
            self._over[name] = 0
            lifecycle.over_limit(f"took {memory_mb:.0f} MB and may take {limit:g}", now)

    def ordered(self, name: str, order: ModuleOrder, now: float) -> tuple[bool, str]:
        """Carry out an order about a module; whether it is done, and the result or the reason."""
        lifecycle = self.lifecycles.get(name)
        if lifecycle is None:
            return False, self.unknown(name)
        if order is ModuleOrder.STOP:
            lifecycle.stop_by_order(now)
            return True, f"{name} is stopped; only an order starts it again"
        if order is ModuleOrder.RESTART:
            lifecycle.restart_by_order(now)
            return True, f"{name} is restarted"
        running = lifecycle.up
        lifecycle.start_by_order()
        if running:
            return True, f"{name} runs already"
        self._survey()
        lacks = sorted(lifecycle.needs - self._outside)
        missing = [need for need in lacks if self._provider(need) is None]
        if missing:
            return True, f"{name} starts as soon as a module for {' and '.join(missing)} may start"
        return True, f"{name} is started"

    def unknown(self, name: str) -> str:
        """The sentence about a module that the robot does not have."""
        known = ", ".join(self.lifecycles)
        near = did_you_mean(name, self.lifecycles)
        return f"there is no module {name[:40]!r}; this robot has {known}{near}"

    def step(self, now: float) -> list[tuple[ModuleLifecycle, ProcessAction]]:
        """The next actions, in order."""
        if self._pauses.look(now):
            for lifecycle in self.lifecycles.values():
                lifecycle.skip_pause(now)
        self.externals = {
            name: one
            for name, one in self.externals.items()
            if now - one.last_heard < EXTERNAL_SILENCE_S
        }
        for lifecycle in self.lifecycles.values():
            lifecycle.check_silence(now)
        self._survey()
        wanted = self._plan(now)
        self._providers.clear()
        actions = []
        for name, lifecycle in self.lifecycles.items():
            lacking = (
                self._lacking(lifecycle, wanted) if name in wanted and not lifecycle.up else ()
            )
            action = lifecycle.step(now, wanted=name in wanted, ready=not lacking)
            if action is not None:
                actions.append((lifecycle, action))
            elif lacking and lifecycle.phase is ModulePhase.STOPPED and not lifecycle.held:
                lifecycle.why = f"waits for {' and '.join(lacking)}"
        return actions

    def undescribed(self) -> list[ModuleLifecycle]:
        """Modules without a report of their capabilities, because they were never started."""
        return [
            lifecycle
            for lifecycle in self.lifecycles.values()
            if not lifecycle.asked and not lifecycle.starts and lifecycle.keep_alive_s > 0.0
        ]

    def capabilities(self, now: float) -> dict[str, CapabilityReport]:
        """Every capability of a module, by name, and some wanted ones without a module."""
        self._survey()
        wants = self.wants.current(now)
        known = self._outside | self._known
        unknown = heapq.nsmallest(MAX_UNKNOWN, (name for name in wants if name not in known))
        return {
            name: self._view(name, wants.get(name, ())[:MAX_SHOWN])
            for name in sorted(known.union(unknown))
        }

    @property
    def undeclared(self) -> int:
        """Number of modules without a report of their capabilities, or a hint of them."""
        return sum(
            not (lifecycle.asked or lifecycle.provides) for lifecycle in self.lifecycles.values()
        )

    def _view(self, capability: str, wanted_by: Iterable[str]) -> CapabilityReport:
        others = [n for n, one in self.externals.items() if capability in one.provides]
        owners = [n for n, lifecycle in self.lifecycles.items() if capability in lifecycle.provides]
        lifecycle = self._provider(capability)
        if others and not (lifecycle and lifecycle.phase is ModulePhase.RUNNING):
            phase, module = CapabilityPhase.RUNNING, others[0]
        elif lifecycle is None:
            phase, module = CapabilityPhase.UNAVAILABLE, ""
        else:
            module = lifecycle.spec.name
            phase = {
                ModulePhase.RUNNING: CapabilityPhase.RUNNING,
                ModulePhase.STARTING: CapabilityPhase.STARTING,
                ModulePhase.WAITING: CapabilityPhase.STARTING,
            }.get(lifecycle.phase, CapabilityPhase.AVAILABLE)
        return CapabilityReport(
            name=capability,
            phase=phase,
            module=module,
            modules=" ".join((*owners, *others)),
            wanted_by=" ".join(wanted_by),
        )

    def _plan(self, now: float) -> set[str]:
        """The modules that should run."""
        plan: set[str] = set()
        for name, lifecycle in self.lifecycles.items():
            stands_back = lifecycle.spec.always and self._is_replaced_by_spare(name, lifecycle)
            if stands_back:
                self._include(self.lifecycles[lifecycle.replaced_by], plan)
            elif lifecycle.pinned or lifecycle.spec.always:
                self._include(lifecycle, plan)
        for capability in self.wants.current(now):
            if capability in self._known and capability not in self._outside:
                self._include(self._provider(capability), plan)
        return plan

    def _include(self, lifecycle: ModuleLifecycle | None, plan: set[str]) -> None:
        """Add a module with all its needs."""
        if lifecycle is None or lifecycle.spec.name in plan:
            return
        plan.add(lifecycle.spec.name)
        if not lifecycle.usable or not self._possible(lifecycle):
            return  # then no other module runs for it
        for need in lifecycle.needs:
            if need not in self._outside:
                self._include(self._provider(need), plan)

    def _is_replaced_by_spare(self, name: str, lifecycle: ModuleLifecycle) -> bool:
        """Whether a spare replaces this failed always-on module."""
        if lifecycle.replaced_by and self._can_replace(
            self.lifecycles[lifecycle.replaced_by], lifecycle
        ):
            return True
        lifecycle.replaced_by = ""
        if lifecycle.held or lifecycle.sound:
            return False
        for other, spare in self.lifecycles.items():
            if other != name and self._can_replace(spare, lifecycle):
                lifecycle.replace_by(other)
                return True
        return False

    def _can_replace(self, spare: ModuleLifecycle, lifecycle: ModuleLifecycle) -> bool:
        """Whether a module can do all the work of another now."""
        able = bool(lifecycle.provides) and spare.provides >= lifecycle.provides
        return able and spare.sound and self._possible(spare)

    def _provider(self, capability: str) -> ModuleLifecycle | None:
        """The module for a capability: the present provider, if it still can."""
        able = [
            lifecycle
            for lifecycle in self.lifecycles.values()
            if capability in lifecycle.provides and lifecycle.usable and not lifecycle.replaced_by
        ]
        possible = [lifecycle for lifecycle in able if self._possible(lifecycle)] or able
        sound = [lifecycle for lifecycle in possible if lifecycle.sound] or possible
        if not sound:
            return None
        chosen = self.lifecycles.get(self._chosen.get(capability, ""))
        if chosen not in sound:
            chosen = next((lifecycle for lifecycle in sound if lifecycle.up), sound[0])
            self._chosen[capability] = chosen.spec.name
        return chosen

    def _possible(self, lifecycle: ModuleLifecycle) -> bool:
        """Whether all needs of a module, direct and indirect, have modules."""
        return lifecycle.needs <= self._offered

    def _survey(self) -> None:
        """Note the capabilities from outside, and those that are possible at all.

        Modules that lack a capability are removed until no one does. Circles of needs stay,
        because their members start together.
        """
        self._outside = frozenset().union(*(one.provides for one in self.externals.values()))
        self._known = frozenset().union(
            *(lifecycle.provides for lifecycle in self.lifecycles.values())
        )
        able = [lifecycle for lifecycle in self.lifecycles.values() if lifecycle.usable]
        while True:
            self._offered = self._outside.union(*(lifecycle.provides for lifecycle in able))
            left = [lifecycle for lifecycle in able if self._possible(lifecycle)]
            if len(left) == len(able):
                return
            able = left

    def _lacking(self, lifecycle: ModuleLifecycle, plan: set[str]) -> tuple[str, ...]:
        """The missing capabilities of a module, without those of modules that need it in turn."""
        return tuple(
            need
            for need in sorted(lifecycle.needs)
            if need not in self._outside
            and not self._provided(self._provider(need), plan)
            and not self._depends(self._provider(need), lifecycle)
        )

    @staticmethod
    def _provided(lifecycle: ModuleLifecycle | None, plan: set[str]) -> bool:
        return (
            lifecycle is not None
            and lifecycle.phase is ModulePhase.RUNNING
            and lifecycle.spec.name in plan
        )

    def _depends(self, lifecycle: ModuleLifecycle | None, on: ModuleLifecycle) -> bool:
        """Whether a module needs another, directly or indirectly."""
        seen: set[str] = set()
        ahead = [lifecycle] if lifecycle else []
        while ahead:
            each = ahead.pop()
            if each is on:
                return True
            if each.spec.name not in seen:
                seen.add(each.spec.name)
                ahead += self._needed(each)
        return False

    def _needed(self, lifecycle: ModuleLifecycle) -> list[ModuleLifecycle]:
        """The providers of a module's needs, in the present step."""
        name = lifecycle.spec.name
        if name not in self._providers:
            found = {
                each.spec.name: each for need in lifecycle.needs if (each := self._provider(need))
            }
            self._providers[name] = list(found.values())
        return self._providers[name]


def _usable(names: Iterable[str]) -> frozenset[str]:
    """The valid names of capabilities among these."""
    some = itertools.islice(names, MAX_CAPABILITIES)
    return frozenset(name for name in some if name.isidentifier() and len(name) <= MAX_NAME)
