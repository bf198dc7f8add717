"""Which modules run: from what happened and the time to what is to be done; pure.

A module runs if it is to run always, if somebody started it, if one of its capabilities is wanted,
or if another that runs needs one. One that ended too often, or again soon after it ended, is
replaced by another that can do the same, where there is one, and stays so until that one fails.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from hub.gcm.supervision import CapabilityPhase, ModuleOrder, ModulePhase
from hub.nearest import did_you_mean
from hub.own_pauses import OwnPauses
from hub.robomon.module_lifecycle import ModuleLifecycle, ProcessAction
from hub.robomon.module_table import ModuleSpec
from hub.robomon.wants import MAX_CAPABILITIES, MAX_NAME, Wants

AWAY_S = 1.0
"""A longer pause between two steps means that this process itself was away [s]."""
STRANGER_S = 4.0
"""Silence after which a module that the daemon did not start is forgotten [s]."""
MAX_STRANGERS = 64
MAX_UNKNOWN = 64
"""Wanted capabilities that no module has, of which is told."""
MAX_SHOWN = 16
"""Holders of a want who are named."""
_OVER_LIMIT_LOOKS = 3
"""Looks in a row at which a module takes too much before it is started anew."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ExternalModule:
    """A module that somebody else started.

    Attributes:
        pid: Process id on its machine.
        provides: Its capabilities.
        needs: What it needs of others.
        heard: When it announced itself last [s].
    """

    pid: int
    provides: frozenset[str]
    needs: frozenset[str]
    heard: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CapabilityView:
    """What can be expected of a capability.

    Attributes:
        phase: That.
        module: Who provides it, or would; empty if nobody can.
        modules: All that have it.
        wanted_by: Who wants it.
    """

    phase: CapabilityPhase
    module: str
    modules: tuple[str, ...]
    wanted_by: tuple[str, ...]


class ModulePolicy:
    """All modules of a robot; every method that needs it gets the time [s].

    Attributes:
        lives: The modules by name, in the order of the robot file.
        strangers: Modules that somebody else started, by name.
        wants: Who wants which capabilities.
    """

    def __init__(self, specs: Sequence[ModuleSpec]) -> None:
        self.lives = {spec.name: ModuleLifecycle(spec) for spec in specs}
        self.strangers: dict[str, ExternalModule] = {}
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
        """A module says that it lives, and what it can do."""
        can, lacks = _usable(provides), _usable(needs)
        life = self.lives.get(name)
        shown = "".join(name.split())[:MAX_NAME]
        if life is not None and life.has_process:
            if life.announced(pid, now):
                life.learned(can, lacks)
        elif life is None and (shown in self.strangers or len(self.strangers) < MAX_STRANGERS):
            self.strangers[shown] = ExternalModule(pid=pid, provides=can, needs=lacks, heard=now)

    def used(self, name: str, memory_mb: float, now: float) -> None:
        """A look at what a module takes."""
        life = self.lives[name]
        limit = life.spec.memory_limit_mb
        over = self._over.get(name, 0) + 1 if 0.0 < limit < memory_mb else 0
        self._over[name] = over
        if over >= _OVER_LIMIT_LOOKS:
            self._over[name] = 0
            life.over_limit(f"took {memory_mb:.0f} MB and may take {limit:g}", now)

    def ordered(self, name: str, order: ModuleOrder, now: float) -> tuple[bool, str]:
        """Somebody wants something done with a module; whether it is, and what or why not."""
        life = self.lives.get(name)
        if life is None:
            return False, self.unknown(name)
        if order is ModuleOrder.STOP:
            life.told_to_stop(now)
            return True, f"{name} is stopped, and stays so until somebody starts it"
        if order is ModuleOrder.RESTART:
            life.told_to_restart(now)
            return True, f"{name} is started anew"
        running = life.up
        life.told_to_start()
        if running:
            return True, f"{name} runs already"
        self._survey()
        lacks = sorted(life.needs - self._outside)
        missing = [need for need in lacks if self._provider(need) is None]
        if missing:
            return True, f"{name} starts as soon as a module for {' and '.join(missing)} may start"
        return True, f"{name} is started"

    def unknown(self, name: str) -> str:
        """What to say of a module that the robot does not have."""
        known = ", ".join(self.lives)
        near = did_you_mean(name, self.lives)
        return f"there is no module {name[:40]!r}; this robot has {known}{near}"

    def step(self, now: float) -> list[tuple[ModuleLifecycle, ProcessAction]]:
        """What is to be done now, in order."""
        if self._pauses.look(now):
            for life in self.lives.values():
                life.forgive(now)
        self.strangers = {
            name: one for name, one in self.strangers.items() if now - one.heard < STRANGER_S
        }
        for life in self.lives.values():
            life.look(now)
        self._survey()
        wanted = self._plan(now)
        self._providers.clear()
        actions = []
        for name, life in self.lives.items():
            lacking = self._lacking(life, wanted) if name in wanted and not life.up else ()
            action = life.step(now, wanted=name in wanted, ready=not lacking)
            if action is not None:
                actions.append((life, action))
            elif lacking and life.phase is ModulePhase.STOPPED and not life.held:
                life.why = f"waits for {' and '.join(lacking)}"
        return actions

    def unasked(self) -> list[ModuleLifecycle]:
        """Modules that have not yet said what they can do, as they were not started."""
        return [
            life
            for life in self.lives.values()
            if not life.asked and not life.starts and life.keep_alive_s > 0.0
        ]

    def capabilities(self, now: float) -> dict[str, CapabilityView]:
        """Every capability that a module has, in alphabetical order, and some that are wanted."""
        self._survey()
        wants = self.wants.current(now)
        known = self._outside | self._known
        unknown = heapq.nsmallest(MAX_UNKNOWN, (name for name in wants if name not in known))
        return {
            name: self._view(name, tuple(wants.get(name, ())[:MAX_SHOWN]))
            for name in sorted(known.union(unknown))
        }

    @property
    def undeclared(self) -> int:
        """Number of modules that have not said what they can do, and have no hint of it."""
        return sum(not (life.asked or life.provides) for life in self.lives.values())

    def _view(self, capability: str, wanted_by: tuple[str, ...]) -> CapabilityView:
        others = [n for n, one in self.strangers.items() if capability in one.provides]
        owners = [n for n, life in self.lives.items() if capability in life.provides]
        life = self._provider(capability)
        if others and not (life and life.phase is ModulePhase.RUNNING):
            phase, module = CapabilityPhase.RUNNING, others[0]
        elif life is None:
            phase, module = CapabilityPhase.UNAVAILABLE, ""
        else:
            module = life.spec.name
            phase = {
                ModulePhase.RUNNING: CapabilityPhase.RUNNING,
                ModulePhase.STARTING: CapabilityPhase.STARTING,
                ModulePhase.WAITING: CapabilityPhase.STARTING,
            }.get(life.phase, CapabilityPhase.AVAILABLE)
        return CapabilityView(
            phase=phase, module=module, modules=(*owners, *others), wanted_by=wanted_by
        )

    def _plan(self, now: float) -> set[str]:
        """The modules that are to run."""
        plan: set[str] = set()
        for name, life in self.lives.items():
            stands_back = life.spec.always and self._stands_back(name, life)
            if stands_back:
                self._include(self.lives[life.replaced_by], plan)
            elif life.pinned or life.spec.always:
                self._include(life, plan)
        for capability in self.wants.current(now):
            if capability in self._known and capability not in self._outside:
                self._include(self._provider(capability), plan)
        return plan

    def _include(self, life: ModuleLifecycle | None, plan: set[str]) -> None:
        """Add a module with all that it needs."""
        if life is None or life.spec.name in plan:
            return
        plan.add(life.spec.name)
        if not life.usable or not self._possible(life):
            return  # then nobody is to run for its sake
        for need in life.needs:
            if need not in self._outside:
                self._include(self._provider(need), plan)

    def _stands_back(self, name: str, life: ModuleLifecycle) -> bool:
        """Whether another does the work of a module that is to run always, as it cannot."""
        if life.replaced_by and self._could_do_it(self.lives[life.replaced_by], life):
            return True
        life.replaced_by = ""
        if life.held or life.sound:
            return False
        for other, spare in self.lives.items():
            if other != name and self._could_do_it(spare, life):
                life.stand_back(other)
                return True
        return False

    def _could_do_it(self, spare: ModuleLifecycle, life: ModuleLifecycle) -> bool:
        """Whether a module can do all that another should do, and now."""
        able = bool(life.provides) and spare.provides >= life.provides
        return able and spare.sound and self._possible(spare)

    def _provider(self, capability: str) -> ModuleLifecycle | None:
        """The module that shall provide a capability: the one that did, if it still can."""
        able = [
            life
            for life in self.lives.values()
            if capability in life.provides and life.usable and not life.replaced_by
        ]
        possible = [life for life in able if self._possible(life)] or able
        sound = [life for life in possible if life.sound] or possible
        if not sound:
            return None
        chosen = self.lives.get(self._chosen.get(capability, ""))
        if chosen not in sound:
            chosen = next((life for life in sound if life.up), sound[0])
            self._chosen[capability] = chosen.spec.name
        return chosen

    def _possible(self, life: ModuleLifecycle) -> bool:
        """Whether there are modules for all that a module needs, and for what those need."""
        return life.needs <= self._offered

    def _survey(self) -> None:
        """See what comes from outside, and what can be had at all.

        Of the modules that can be started, those that lack something are left out until no more
        does; so circles of needs stay, as their members are started together.
        """
        self._outside = frozenset().union(*(one.provides for one in self.strangers.values()))
        self._known = frozenset().union(*(life.provides for life in self.lives.values()))
        able = [life for life in self.lives.values() if life.usable]
        while True:
            self._offered = self._outside.union(*(life.provides for life in able))
            left = [life for life in able if self._possible(life)]
            if len(left) == len(able):
                return
            able = left

    def _lacking(self, life: ModuleLifecycle, plan: set[str]) -> tuple[str, ...]:
        """What a module needs and nobody provides yet; who needs it in turn is not waited for."""
        return tuple(
            need
            for need in sorted(life.needs)
            if need not in self._outside
            and not self._provided(self._provider(need), plan)
            and not self._depends(self._provider(need), life)
        )

    @staticmethod
    def _provided(life: ModuleLifecycle | None, plan: set[str]) -> bool:
        return life is not None and life.phase is ModulePhase.RUNNING and life.spec.name in plan

    def _depends(self, life: ModuleLifecycle | None, on: ModuleLifecycle) -> bool:
        """Whether a module needs another, itself or through others."""
        seen: set[str] = set()
        ahead = [life] if life else []
        while ahead:
            each = ahead.pop()
            if each is on:
                return True
            if each.spec.name not in seen:
                seen.add(each.spec.name)
                ahead += self._needed(each)
        return False

    def _needed(self, life: ModuleLifecycle) -> list[ModuleLifecycle]:
        """Who provides what a module needs, in the step that is under way."""
        name = life.spec.name
        if name not in self._providers:
            found = {each.spec.name: each for need in life.needs if (each := self._provider(need))}
            self._providers[name] = list(found.values())
        return self._providers[name]


def _usable(names: Iterable[str]) -> frozenset[str]:
    """What of this can be names of capabilities; the rest is left out."""
    some = itertools.islice(names, MAX_CAPABILITIES)
    return frozenset(name for name in some if name.isidentifier() and len(name) <= MAX_NAME)
