"""Carries out the policy's actions: starts, watches and ends the modules' processes."""

from __future__ import annotations

import logging
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hub.errors import ModuleStartError
from hub.gcm.common import COMMON_COMMAND, CommonCommand, CommonCommandKind
from hub.gcm.supervision import ModulePhase
from hub.ipc.client import Client
from hub.robomon.capability_probe import CapabilityProbe
from hub.robomon.module_lifecycle import ModuleLifecycle, ProcessAction
from hub.robomon.module_logs import ModuleLogs
from hub.robomon.policy import ModulePolicy
from hub.robomon.process import ModuleProcess, OrphanReaper, Usage, kill_leftovers
from hub.robomon.warm_parent import WarmParent

_logger = logging.getLogger(__name__)

BY_ROBOMON = "by robomon"
"""Argument of common commands from the daemon itself."""
_PERIOD_S = 0.05
_SAMPLE_S = 1.0
_SETTLED_S = 10.0
"""Latest time at which stopped modules are asked for their capabilities [s]."""
_IN_ORDER_S = 0.25
"""Time in which modules get the order to stop, one after the other [s]."""


@dataclass(slots=True)
class _Running:
    """A process, and its usage at the last sample."""

    process: ModuleProcess
    watched: int | None
    usage: Usage | None = None
    sampled: float = 0.0
    processor: float = math.nan


class ProcessSupervisor:
    """The modules' processes.

    Attributes:
        supervisor: Decides.
    """

    def __init__(
        self,
        supervisor: ModulePolicy,
        client: Client,
        outputs: ModuleLogs,
        *,
        arguments: Sequence[str],
        description_arguments: Sequence[str],
        parent: WarmParent | None,
        changed: Callable[[], None],
    ) -> None:
        """Start without processes; the first start comes with the loop.

        Args:
            supervisor: Decides.
            client: The daemon's connection; its loop calls this.
            outputs: Keeps the modules' output.
            arguments: Added to each module's command.
            description_arguments: Added instead to ask for its capabilities.
            parent: Forks Python modules; None: all are spawned.
            changed: Called after a change of a module's phase, reason or number of starts.
        """
        self.supervisor = supervisor
        self._client = client
        self._outputs = outputs
        self._arguments = arguments
        self._parent = parent
        self._changed = changed
        self._clock = time.monotonic
        self._reaper = OrphanReaper()
        self._probe = CapabilityProbe(description_arguments, parent)
        self._running: dict[str, _Running] = {}
        self._reported: dict[str, tuple[ModulePhase, str, int]] = {}
        self._began = self._clock()
        client.every(_PERIOD_S, self.step)
        client.every(_SAMPLE_S, self._sample)

    @property
    def pids(self) -> dict[str, int]:
        """Process ids of the modules that run."""
        return {name: running.process.pid for name, running in self._running.items()}

    def processor(self, name: str) -> float:
        """The part of one processor that a module uses; NaN: unknown."""
        running = self._running.get(name)
        return running.processor if running else math.nan

    def memory_mb(self, name: str) -> float:
        """Resident memory of a module [MB]; NaN: unknown."""
        running = self._running.get(name)
        return running.usage.memory_mb if running and running.usage else math.nan

    def step(self) -> None:
        """Note the processes that have ended, and carry out the policy's actions."""
        for name, running in list(self._running.items()):
            code = running.process.exit_code()
            if code is not None:
                self._end_of(name, code)
        for life, action in self.supervisor.step(self._clock()):
            self._do(life, action)
        self._ask()
        self._report_changes()

    def close(self) -> None:
        """End all modules, the last started first: the driver stops the wheels until the end.

        Each has a short time to end before the next gets the order. One that hangs does not delay
        the others further, because the robot must not drive on meanwhile.
        """
        self._probe.close()
        started = self._clock()
        running = [each.process for each in reversed(self._running.values())]
        for process in running:
            _logger.info("stopping %s", process.spec.name)
            process.ask_to_stop()
            process.wait(started + _IN_ORDER_S - self._clock())
        for process in running:
            process.wait(started + process.spec.stop_timeout_s - self._clock())
            process.end()
        if self._parent is not None:
            self._parent.close()
        kill_leftovers({self._reaper.pid})
        self._reaper.close()

    def _do(self, life: ModuleLifecycle, action: ProcessAction) -> None:
        name = life.spec.name
        if action is ProcessAction.START:
            self._start(life)
            return
        running = self._running.get(name)
        if running is None:
            return
        if action is ProcessAction.COMMAND:
            self._client.publish(
                COMMON_COMMAND,
                CommonCommand(module=name, command=CommonCommandKind.STOP, argument=BY_ROBOMON),
            )
        elif action is ProcessAction.TERMINATE:
            running.process.ask_to_stop()
        else:
            running.process.kill()

    def _start(self, life: ModuleLifecycle) -> None:
        name, now = life.spec.name, self._clock()
        try:
            process = ModuleProcess(life.spec, self._arguments, self._parent)
        except ModuleStartError as error:
            life.not_started(str(error), now)
            _log_end(life)
            return
        self._running[name] = _Running(process=process, watched=self._watch(process.pid))
        life.started(process.pid, now)
        self._reaper.watch(process.pid)
        self._outputs.add(name, process.output)
        _logger.info("%s started (pid %d)", name, process.pid)

    def _watch(self, pid: int) -> int | None:
        """Let the loop call `step` at the end of this process, if the system has such files."""
        try:
            file = os.pidfd_open(pid)
        except (OSError, AttributeError):
            return None
        self._client.loop.watch(file, self.step)
        return file

    def _end_of(self, name: str, code: int) -> None:
        running = self._running.pop(name)
        if running.watched is not None:
            self._client.loop.unwatch(running.watched)
            os.close(running.watched)
        running.process.end()
        self._reaper.forget(running.process.pid)
        how = f"was ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
        life = self.supervisor.lifecycles[name]
        life.ended(how, self._clock())
        _log_end(life)

    def _ask(self) -> None:
        """Ask modules for their capabilities after the start of always-on modules."""
        lives = self.supervisor.lifecycles.values()
        settled = not any(life.phase is ModulePhase.STARTING for life in lives if life.spec.always)
        if settled or self._clock() - self._began > _SETTLED_S:
            self._probe.ask(self.supervisor.undescribed())
        self._probe.poll(self._clock())

    def _sample(self) -> None:
        """Measure the modules' usage, and end processes that ended modules have left."""
        now = self._clock()
        self._reaper.restart_if_ended()
        if self._parent is not None:
            self._parent.restart_if_ended()
        for name, running in self._running.items():
            usage = running.process.usage()
            if usage is None:
                continue
            if running.usage is not None and now > running.sampled:
                spent = usage.processor_s - running.usage.processor_s
                running.processor = spent / (now - running.sampled)
            running.usage, running.sampled = usage, now
            self.supervisor.used(name, usage.memory_mb, now)
        own = {self._reaper.pid, self._probe.pid, self._parent.pid if self._parent else 0}
        leftovers = kill_leftovers({*own, *self.pids.values()})
        if leftovers:
            _logger.warning("%d processes that modules had left behind were killed", leftovers)

    def _report_changes(self) -> None:
        lives = self.supervisor.lifecycles
        now = {name: (life.phase, life.why, life.starts) for name, life in lives.items()}
        if now == self._reported:
            return
        for name, (phase, why, _) in now.items():
            if phase is ModulePhase.STOPPING and now[name] != self._reported.get(name):
                _logger.info("stopping %s: it %s", name, why)
        self._reported = now
        self._changed()


def _log_end(life: ModuleLifecycle) -> None:
    if life.phase is ModulePhase.FAILED:
        _logger.error("%s %s", life.spec.name, life.why)
    elif life.phase is ModulePhase.WAITING:
        _logger.warning("%s %s", life.spec.name, life.why)
    else:
        _logger.info("%s ended", life.spec.name)
