"""Carries out the policy's actions: starts, watches and ends the modules' processes."""

from __future__ import annotations

import logging
import math
import os
import time
from collections.abc import Callable, Sequence

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
from hub.values import dataclass

_logger = logging.getLogger(__name__)

BY_ROBOMON = "by robomon"
"""Argument of common commands from the daemon itself."""
_PERIOD_S = 0.1
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
        policy: Decides.
    """

    def __init__(
        self,
        policy: ModulePolicy,
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
            policy: Decides.
            client: The daemon's connection; its loop calls this.
            outputs: Keeps the modules' output.
            arguments: Added to each module's command.
            description_arguments: Added instead to ask for its capabilities.
            parent: Forks Python modules; None: all are spawned.
            changed: Called after a change of a module's phase, reason or number of starts.
        """
        self.policy = policy
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
        for lifecycle, action in self.policy.step(self._clock()):
            self._do(lifecycle, action)
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

    def _do(self, lifecycle: ModuleLifecycle, action: ProcessAction) -> None:
        name = lifecycle.spec.name
        if action is ProcessAction.START:
            self._start(lifecycle)
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

    def _start(self, lifecycle: ModuleLifecycle) -> None:
        name, now = lifecycle.spec.name, self._clock()
        try:
            process = ModuleProcess(lifecycle.spec, self._arguments, self._parent)
        except ModuleStartError as error:
            lifecycle.not_started(str(error), now)
            _log_end(lifecycle)
            return
        self._running[name] = _Running(process=process, watched=self._watch(process.pid))
        lifecycle.started(process.pid, now)
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
        lifecycle = self.policy.lifecycles[name]
        lifecycle.ended(how, self._clock())
        _log_end(lifecycle)

    def _ask(self) -> None:
        """Ask modules for their capabilities after the start of always-on modules."""
        lifecycles = self.policy.lifecycles.values()
        settled = not any(
            lifecycle.phase is ModulePhase.STARTING
            for lifecycle in lifecycles
            if lifecycle.spec.always
        )
        if settled or self._clock() - self._began > _SETTLED_S:
            self._probe.ask(self.policy.undescribed())
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
            self.policy.used(name, usage.memory_mb, now)
        own = {self._reaper.pid, self._probe.pid, self._parent.pid if self._parent else 0}
        leftovers = kill_leftovers({*own, *self.pids.values()})
        if leftovers:
            _logger.warning("%d processes that modules had left behind were killed", leftovers)

    def _report_changes(self) -> None:
        lifecycles = self.policy.lifecycles
        now = {
            name: (lifecycle.phase, lifecycle.why, lifecycle.starts)
            for name, lifecycle in lifecycles.items()
        }
        if now == self._reported:
            return
        for name, (phase, why, _) in now.items():
            if phase is ModulePhase.STOPPING and now[name] != self._reported.get(name):
                _logger.info("stopping %s: it %s", name, why)
        self._reported = now
        self._changed()


def _log_end(lifecycle: ModuleLifecycle) -> None:
    if lifecycle.phase is ModulePhase.FAILED:
        _logger.error("%s %s", lifecycle.spec.name, lifecycle.why)
    elif lifecycle.phase is ModulePhase.WAITING:
        _logger.warning("%s %s", lifecycle.spec.name, lifecycle.why)
    else:
        _logger.info("%s ended", lifecycle.spec.name)
